"""The files of a site: written when they are new or other than before, and removed when they are not wanted any more."""

import hashlib
import re
import shutil
from collections.abc import Container
from pathlib import Path

from folding_client.interrupts import UsageError
from folding_client.record.folder import file_trouble, write_atomically

MARKER = ".foldingagent-site"
"""The file by which a folder is known to be a site of ours, whose files may be replaced; it says of which kind."""
MEDIA = "media"
"""The folder of pictures, named by what they show."""
_SUFFIX_OF = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/svg+xml": "svg"}


def content_key(*parts: object) -> str:
    """A short name for what some values determine."""
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:16]


def page_name(*words: str) -> str:
    """A file name from words that may hold anything: readable where they are, and another for other words."""
    plain = re.sub(r"[^a-z0-9]+", "-", "-".join(words).lower()).strip("-")[:60].strip("-")
    return f"{plain or 'run'}-{content_key(*words)[:6]}"


class SiteFiles:
    """The folder of a site of a ``kind``, such as ``report``. UsageError if it holds something else, or cannot be written."""

    def __init__(self, folder: Path, kind: str) -> None:
        self.folder = folder
        self._kind = kind
        self.changed: list[str] = []
        self._known: dict[str, str] = {}
        self._require_ours()
        try:
            (folder / MEDIA).mkdir(parents=True, exist_ok=True)
            (folder / MARKER).write_text(kind, encoding="utf-8")
        except OSError as error:
            message = f"{file_trouble(error)}, or name another folder with -o."
            raise UsageError(message) from error
        self._pictures = {file.stem: file.name for file in (folder / MEDIA).iterdir()}

    def _require_ours(self) -> None:
        folder = self.folder
        if folder.exists() and not folder.is_dir():
            message = f"{folder} is a file, not a folder for a site; name another with -o."
            raise UsageError(message)
        ours = (folder / MARKER).is_file() and (folder / MARKER).read_text(encoding="utf-8") == self._kind
        if folder.is_dir() and not ours and any(folder.iterdir()):
            message = f"{folder} holds other things than a {self._kind} of ours; name a new or an empty folder with -o."
            raise UsageError(message)

    def write(self, name: str, text: str) -> None:
        """Write a text file if it is new or another than before."""
        data, path = text.encode("utf-8"), self.folder / name
        digest = hashlib.sha256(data).hexdigest()
        if self._known.get(name) == digest:
            return
        if not path.is_file() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(path, data)
            self.changed.append(name)
        self._known[name] = digest

    @property
    def versions(self) -> dict[str, str]:
        """The pages that were written, each with what tells its content from another."""
        return {name: digest[:16] for name, digest in self._known.items() if name.endswith(".html")}

    def copy(self, source: Path, name: str) -> bool:
        """Copy a file if it is there and newer or of another size; whether the site has it."""
        target = self.folder / name
        try:
            here = source.stat()
            if target.is_file():
                there = target.stat()
                if (there.st_size, there.st_mtime_ns) == (here.st_size, here.st_mtime_ns):
                    return True
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target)
        except OSError:
            return target.is_file()
        return True

    def picture(self, key: str) -> str | None:
        """Where a picture is within the site, None if it is not there."""
        name = self._pictures.get(key)
        return f"{MEDIA}/{name}" if name else None

    def keep_picture(self, key: str, data: bytes, mime: str) -> str:
        """Write a picture under a key; its place within the site."""
        name = f"{key}.{_SUFFIX_OF.get(mime, 'bin')}"
        write_atomically(self.folder / MEDIA / name, data)
        self._pictures[key] = name
        return f"{MEDIA}/{name}"

    def keep_only(self, pictures: Container[str]) -> None:
        """Remove the pictures that are not among these places within the site."""
        for key, name in list(self._pictures.items()):
            if f"{MEDIA}/{name}" not in pictures:
                (self.folder / MEDIA / name).unlink(missing_ok=True)
                del self._pictures[key]

    def copy_picture(self, source: Path) -> str | None:
        """Copy a recorded picture, whose name tells its content; its place within the site, None if it is missing."""
        if (there := self.picture(source.stem)) is not None:
            return there
        try:
            write_atomically(self.folder / MEDIA / source.name, source.read_bytes())
        except OSError:
            return None
        self._pictures[source.stem] = source.name
        return f"{MEDIA}/{source.name}"
