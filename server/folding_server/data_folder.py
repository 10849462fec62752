"""The data folder of a server."""

from pathlib import Path

from folding_server.errors import FoldingError


def data_folder(given: Path | None) -> Path:
    """The folder for the database: the user's own data folder if nothing else is said."""
    from platformdirs import user_data_path  # noqa: PLC0415  (a command loads what it needs)

    return given or user_data_path("foldingagent", appauthor=False)


def folder_for_runs(given: Path | None, database: str | None) -> Path:
    """The data folder, made where it is to hold the database. FoldingError if it cannot be made."""
    folder = data_folder(given)
    if database is None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FoldingError(
                f"The data folder {folder} cannot be made ({error.strerror}); choose another with --data."
            ) from error
    return folder
