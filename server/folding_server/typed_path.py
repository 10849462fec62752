"""Paths as users type them."""

from collections.abc import Iterable
from pathlib import Path

import typer


def typed_path(text: str) -> Path:
    """A path as given, where ``~`` is the user's own folder although no shell has seen it."""
    if not text:
        raise typer.BadParameter("the path is empty; give one, or . for the folder you are in")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise typer.BadParameter(
            f"{text!r} begins with a user who has no folder here; give the whole path"
        ) from error


def require_folders(folders: Iterable[Path], use: str = "serve sequences from") -> None:
    """Raise BadParameter for the first folder that is none, or that may not be looked at; ``use`` is what it is for."""
    for folder in folders:
        try:
            found = folder.is_dir()
        except OSError as error:
            raise typer.BadParameter(
                f"the folder {folder} cannot be looked at ({error.strerror}); give another to {use}"
            ) from error
        if not found:
            raise typer.BadParameter(f"there is no folder {folder} to {use}; create it or name another")
