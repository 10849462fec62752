"""The folder of a run: where its files are, and how they are written so that a kill never leaves
half of one.
"""

import hashlib
import json
import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from folding_client.interrupts import UsageError
from folding_client.messages import Picture
from folding_client.record.redaction import redact

if TYPE_CHECKING:
    from filelock import BaseFileLock

_SUFFIXES = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/svg+xml": "svg"}


class RunFolder:
    """A run's files: ``run.json``, ``events.jsonl``, ``images/``, ``store/`` and, at the end, the results.

    Whoever writes to them holds the folder first. The hidden file ``.lock`` is what is locked; it stays, and
    means nothing when nobody holds it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.events = path / "events.jsonl"
        self.store = path / "store"
        self._lock: BaseFileLock | None = None
        self._made: tuple[Path, ...] = ()
        self._parents: tuple[Path, ...] = ()

    def holds_run(self) -> bool:
        """Whether a run has begun in the folder. UsageError if it cannot be looked at."""
        try:
            return (self.path / "run.json").exists()
        except OSError as error:
            raise self._unusable(error) from error

    def require_free(self) -> None:
        """UsageError if a run is in the folder already."""
        if self.holds_run():
            message = (
                f"{self.path} holds a run already; continue it with --resume {self.path}, or name another "
                "folder."
            )
            raise UsageError(message)

    def hold(self) -> None:
        """Keep other processes out until ``release``, or until this process ends however it does. UsageError if
        another holds the folder already.
        """
        if self._lock is not None:
            return
        from filelock import FileLock, Timeout  # noqa: PLC0415  (takes a while to load)

        lock = FileLock(self.path / ".lock", blocking=False, thread_local=False)
        try:
            lock.acquire()
        except Timeout as error:
            raise self._taken() from error
        except OSError as error:
            message = f"Cannot write to the run folder {self.path}: {error.strerror}. Make it writable, or use another folder."
            raise UsageError(message) from error
        if not Path(lock.lock_file).exists():  # whoever held it gave the folder up and removed it meanwhile
            lock.release()
            raise self._taken()
        self._lock = lock

    def _taken(self) -> UsageError:
        return UsageError(f"Another process works on the run in {self.path}; wait until it has ended.")

    def release(self) -> None:
        """Let other processes work on the run; nothing if it is not held."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def claim(self) -> None:
        """Make the folder and hold it for a new run. UsageError if a run is in it already, another process
        holds it, or it cannot be made.
        """
        self.require_free()
        made = () if self.path.exists() else (self.path,)
        parents = tuple(folder for folder in self.path.parents if not folder.exists())
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise self._unusable(error) from error
        self.hold()
        self._made, self._parents = made, parents
        try:
            self.require_free()
        except UsageError:
            self.release()
            raise

    def create(self) -> None:
        """Make and hold the folder, without what a run that never began may have left. UsageError as ``claim``."""
        self.claim()
        inside = self.path / "images", self.store
        self._made = (*(folder for folder in inside if not folder.exists()), *self._made)
        try:
            self.events.unlink(missing_ok=True)
            for folder in inside:
                folder.mkdir(exist_ok=True)
        except OSError as error:
            self.discard()
            raise self._unusable(error) from error

    def discard(self) -> None:
        """Remove the folders made for a run that never began, and release; nothing if ``run.json`` says that it
        began.

        What was there before stays: a run may be sent to a folder that holds other things, and others beside it.
        """
        if self._lock is not None and not self.holds_run():
            for own in self._made:
                shutil.rmtree(own, ignore_errors=True)
            with suppress(OSError):
                Path(self._lock.lock_file).unlink(missing_ok=True)
            with suppress(OSError):
                for parent in self._parents:
                    parent.rmdir()
        self.release()

    def _unusable(self, error: OSError) -> UsageError:
        return UsageError(
            f"Cannot use {self.path} as a run folder: {error.strerror}. Name another with --out."
        )

    def keep_picture(self, picture: Picture) -> str:
        """Write a picture under a name made from its content, once; the path inside the run folder."""
        name = picture_name(picture)
        if not (self.path / name).exists():
            write_atomically(self.path / name, picture.data)
        return name

    def write_json(self, name: str, data: object) -> Path:
        """Write a JSON file, redacted, in one move."""
        return self.write_text(name, json.dumps(data, indent=1, ensure_ascii=False) + "\n")

    def write_text(self, name: str, text: str) -> Path:
        """Write a text file, redacted, in one move."""
        write_atomically(self.path / name, redact(text).encode("utf-8"))
        return self.path / name

    def description(self, *needed: str) -> dict[str, Any]:
        """What ``run.json`` says. UsageError if there is none, it cannot be read, or an object that is ``needed``
        besides the sequence is missing.
        """
        file = self.path / "run.json"
        try:
            data = json.loads(file.read_text(encoding="utf-8"))
        except OSError as error:
            message = (
                f"No recorded run at {self.path}: {error.strerror}. Name a folder that holds a run.json."
            )
            raise UsageError(message) from error
        except ValueError as error:
            message = f"{file} is not JSON, so the record is damaged; start a new run."
            raise UsageError(message) from error
        if not isinstance(data, dict) or data.get("format") != 1:
            message = f"{file} is not a run of format 1; start a new run or use the version that wrote it."
            raise UsageError(message)
        if missing := [part for part in ("sequence", *needed) if not isinstance(data.get(part), dict)]:
            message = f"{file} says nothing of {missing[0]}, so the record is damaged; start a new run."
            raise UsageError(message)
        return data


def picture_name(picture: Picture) -> str:
    """Where a picture is kept inside a run folder; pictures with the same content have the same name."""
    return f"images/{hashlib.sha256(picture.data).hexdigest()[:20]}.{_SUFFIXES.get(picture.mime, 'bin')}"


def file_trouble(error: OSError) -> str:
    """The beginning of a sentence on a file or folder that cannot be used, such as on a full disk."""
    return f"A file cannot be read or written: {error.strerror or error}{f' ({error.filename})' if error.filename else ''}; mend that"


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file beside its place and move it there: readers see the old content or the new, never
    a part.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    temporary.write_bytes(data)
    temporary.replace(path)
