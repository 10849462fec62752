"""Reading and replacing a configuration file: all or nothing, with a copy of what was there."""

import os
import shutil
import tempfile
from itertools import count
from pathlib import Path

from folding_server.errors import FoldingError


def read_settings(path: Path) -> str:
    """The text of a file as it stands, with its line ends; "" if there is none. FoldingError if it cannot be read."""
    try:
        return path.read_bytes().decode()
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise FoldingError(
            f"{path} cannot be read ({error.strerror}); mend that and run this again."
        ) from error
    except UnicodeDecodeError as error:
        raise FoldingError(
            f"{path} is not UTF-8, so it is left as it is; save it as UTF-8 and run this again."
        ) from error


def replace_settings(path: Path, text: str) -> Path | None:
    """Replace a file, or make it with its folders; where a link stands, the file it names. The copy of what was there, if any.

    FoldingError if it cannot be written; then the file is as it was.
    """
    target = path.resolve()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        backup = _backup(target) if target.exists() else None
        _replace(target, text)
    except OSError as error:
        raise FoldingError(
            f"{path} cannot be written ({error.strerror}), so it is as it was; use --dry-run and add the entry yourself."
        ) from error
    return backup


def _backup(target: Path) -> Path:
    """A copy beside a file, under the first name that is free: file.bak, file.bak2, and so on."""
    names = (target.with_name(f"{target.name}.bak{number if number > 1 else ''}") for number in count(1))
    backup = next(name for name in names if not name.exists())
    shutil.copy2(target, backup)
    return backup


def _replace(target: Path, text: str) -> None:
    """Write a file beside the target, through to the disk, and give it the target's name and rights."""
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(text.encode())
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            shutil.copymode(target, name)
        Path(name).replace(target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
