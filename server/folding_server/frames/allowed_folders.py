"""The folders of a user's own files that the server may read from, and paths below them as callers type them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from folding_server.errors import PhotoError

LONGEST_PATH = 4096
"""Characters of the longest path that is looked at: PATH_MAX of Linux."""
_SHOWN = 80
"""How many characters of a path are repeated to the caller."""


@dataclass(frozen=True)
class AllowedFolders:
    """The folders below which files may be read; ``kept_out`` is a folder below which none may, wherever it lies.

    A path is judged by where it leads once ``..`` and links are followed. Refusals name the path as it was typed and the
    allowed folders, these by their last part alone where ``short`` is set; they are the same whether a file that may not be
    read is there or not.
    """

    folders: tuple[Path, ...]
    kept_out: Path
    short: bool = False

    def find(self, typed: str) -> Path:
        """The real path of the file or folder that a caller typed, below an allowed folder.

        ``~`` is the user's own folder; a relative path is looked for in each of the folders. PhotoError if it leads
        elsewhere, or is not there.
        """
        for place in self._places(typed):
            real = _real(place)
            if real is not None and self._may_be_read(real):
                if _is_there(real):
                    return real
                raise PhotoError(
                    f"there is no file or folder {_cut(typed)}; give the path of a film or of photos"
                )
        raise PhotoError(
            f"{_cut(typed)} may not be read: only files in {self.in_words()} may; {self._advice()}"
        )

    def require(self, path: Path, called: str) -> None:
        """PhotoError if a path found below an allowed folder leads out of all of them by a link; ``called`` is what it is called."""
        real = _real(path)
        if real is None or not self._may_be_read(real):
            raise PhotoError(f"{_cut(called)} leads out of {self.in_words()}: copy the file into the folder")

    def in_words(self) -> str:
        """The allowed folders as they are named to the caller."""
        return " and ".join(repr(folder.name) if self.short else str(folder) for folder in self.folders)

    def _advice(self) -> str:
        if self.short:
            return "ask whoever runs the server to start it with --allow and the folder that holds it"
        return "move it there, or start the server with --allow and the folder that holds it"

    def _places(self, typed: str) -> Iterator[Path]:
        """Where a typed path may mean, without following links: nothing where no system has such a path."""
        if not typed.strip() or len(typed) > LONGEST_PATH or "\0" in typed:
            return
        try:
            path = Path(typed).expanduser()
        except RuntimeError:
            return
        if path.drive and not path.is_absolute():
            return
        candidates = [folder / path for folder in self.folders]
        drives = {folder.resolve().drive.casefold() for folder in self.folders}
        known = [place for place in candidates if place.drive.casefold() in drives]
        yield from sorted(dict.fromkeys(known), key=lambda place: not _is_there(place))

    def _may_be_read(self, real: Path) -> bool:
        return any(_is_within(real, folder) for folder in self.folders) and not _is_within(
            real, self.kept_out
        )


def _real(place: Path) -> Path | None:
    """A path with its links followed; None where they lead round in a circle, or may not be followed."""
    try:
        return place.resolve()
    except (OSError, RuntimeError, ValueError):
        return None


def _is_there(place: Path) -> bool:
    try:
        return place.exists()
    except (OSError, ValueError):
        return False


def _is_within(real: Path, folder: Path) -> bool:
    """Whether a real path is a folder or below it; the folder itself may be written in another case, or by another name."""
    try:
        if real.is_relative_to(folder.resolve()):
            return True
    except (OSError, RuntimeError):
        return False
    return any(_is_same(above, folder) for above in (real, *real.parents))


def _is_same(path: Path, folder: Path) -> bool:
    try:
        return path.samefile(folder)
    except (OSError, ValueError):
        return False


def _cut(typed: str) -> str:
    """A path as it was typed, in quotes, cut where it gets long."""
    return repr(typed) if len(typed) <= _SHOWN else f"{typed[:_SHOWN]!r}..."
