"""The sequences that were added through the server, in a folder of its own: one appears or changes as a whole, or not at all.

A sequence's folder is named by a digest, never by what a caller typed. Its images lie in a folder that no other version of
it shares, so that the one file ``keyframes.json``, which says which, takes it from one version to the next.
"""

import hashlib
import json
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.manifest import FILE_NAME, Manifest, check_name, read_manifest
from folding_server.frames.sequence_folder import CONTACT_SHEET, DeclaredSheet, manifest_text

SOURCE_NAME = "source.json"
"""Beside the manifest: what the sequence was made from, and the name it would have if no other had it."""

STALE_SECONDS = 86_400.0
"""How old a folder is that nobody is writing any more: a server was killed while it did."""

_MAKING = ".making"
_LOCAL = "local"
_DIGEST_LENGTH = 16
_REMOVALS, _REMOVAL_SECONDS = 20, 0.05
"""How often a folder is removed until it is gone, and the seconds between: a killed process is gone within far less than one."""


@dataclass(frozen=True)
class AddedSequence:
    """A sequence that was added: its folder, what its manifest says, and what it was made from, as a digest."""

    folder: Path
    manifest: Manifest
    source: str
    title: str

    @property
    def images(self) -> Path:
        """The folder of its images."""
        return self.folder / (self.manifest.frames or "frames")


class AddedSequences:
    """The sequences that one owner, or whoever calls without a token, has added."""

    def __init__(self, data: Path, owner: str | None) -> None:
        """``data`` is the server's data folder. Nothing is made there yet."""
        self._making = data / "added" / _MAKING
        self.folder = added_folder(data, owner)

    def find(self, name: str) -> AddedSequence | None:
        """The sequence of this name; None if there is none, or it is damaged."""
        return _readable(self._place(name))

    def holds(self, name: str) -> bool:
        """Whether there is one of this name, damaged or not."""
        return self._place(name).is_dir()

    def made_from(self, source: str) -> AddedSequence | None:
        """The sequence that was made from this source, the one written last if there are several."""
        found = [each for each in self._all() if each.source == source]
        return max(found, key=lambda each: (each.folder / FILE_NAME).stat().st_mtime_ns, default=None)

    def bytes_stored(self) -> int:
        """What all sequences here take up."""
        return sum(path.stat().st_size for path in self.folder.rglob("*") if path.is_file())

    @contextmanager
    def making(self) -> Iterator[Path]:
        """An empty folder to write a sequence into, which is gone afterwards; what earlier deaths left is removed."""
        self._making.mkdir(parents=True, exist_ok=True)
        _remove_stale(self._making)
        made = Path(tempfile.mkdtemp(dir=self._making))
        try:
            yield made
        finally:
            _remove_wholly(made)

    def keep(self, made: Path, name: str, source: str, title: str) -> AddedSequence:
        """Put a finished folder, which ``fill_folder`` has written, in its place, instead of an earlier one of that name.

        OSError if that cannot be done; then everything is as it was.
        """
        manifest = read_manifest(made)
        images = f"frames-{made.name}"
        paper = DeclaredSheet(check_name(name), manifest.front_color, manifest.back_color)
        (made / "frames").rename(made / images)
        text = manifest_text(manifest.indices, paper, images, manifest.moving)
        (made / FILE_NAME).write_text(text, encoding="utf-8")
        (made / SOURCE_NAME).write_text(json.dumps({"source": source, "title": title}), encoding="utf-8")
        place = self._place(name)
        if place.is_dir():
            _replace(place, made, images)
        else:
            self.folder.mkdir(parents=True, exist_ok=True)
            made.chmod(0o755)
            made.rename(place)
        return _read(place)

    def remove(self, name: str) -> None:
        """Remove the sequence of this name, which is there: from one moment to the next. OSError if that cannot be done."""
        with self.making() as empty:
            self._place(name).rename(empty / "removed")

    def _all(self) -> list[AddedSequence]:
        if not self.folder.is_dir():
            return []
        folders = [each for each in self.folder.iterdir() if (each / SOURCE_NAME).is_file()]
        return [each for each in map(_readable, folders) if each is not None]

    def _place(self, name: str) -> Path:
        """Where the sequence of a name lies."""
        plain = re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-")[:40]
        return self.folder / f"{plain}-{_digest(name)}".lstrip("-")


def added_folder(data: Path, owner: str | None) -> Path:
    """The folder for the sequences of an owner, or of whoever calls without a token, below a server's data folder.

    No two owners share one, also where the file system takes upper and lower case for the same.
    """
    return data / "added" / (_LOCAL if owner is None else f"{owner}-{_digest(owner)}")


def source_digest(files: list[Path]) -> str:
    """What tells files from others, and from themselves once they have changed: path, size and time of change of each."""
    digest = hashlib.sha256()
    for path in files:
        status = path.stat()
        digest.update(f"{path}\0{status.st_size}\0{status.st_mtime_ns}\0".encode(errors="surrogatepass"))
    return digest.hexdigest()


def _replace(place: Path, made: Path, images: str) -> None:
    """Put a new version into the folder of a sequence, and take the old one away once nothing needs it."""
    before = {path.name for path in place.iterdir() if path.is_dir()}
    (made / images).rename(place / images)
    for name in (CONTACT_SHEET, SOURCE_NAME, FILE_NAME):
        (made / name).replace(place / name)
    for old in before:
        shutil.rmtree(place / old, ignore_errors=True)


def _readable(folder: Path) -> AddedSequence | None:
    """A sequence, or None where its folder is damaged."""
    try:
        return _read(folder)
    except (OSError, PhotoError, ValueError, KeyError):
        return None


def _read(folder: Path) -> AddedSequence:
    about = json.loads((folder / SOURCE_NAME).read_text(encoding="utf-8"))
    return AddedSequence(folder, read_manifest(folder), about["source"], about["title"])


def _remove_wholly(folder: Path) -> None:
    """Remove a folder, into which a process that was just killed may have written a last file meanwhile."""
    for _ in range(_REMOVALS):
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            return
        time.sleep(_REMOVAL_SECONDS)


def _remove_stale(making: Path) -> None:
    for folder in making.iterdir():
        with suppress(FileNotFoundError):  # another process has removed it
            if time.time() - folder.stat().st_mtime > STALE_SECONDS:
                shutil.rmtree(folder, ignore_errors=True)


def _digest(name: str) -> str:
    return hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()[:_DIGEST_LENGTH]
