"""The folder that photographs are written into: new, empty, or with photographs of an earlier time and nothing else."""

import re
from collections.abc import Iterator
from pathlib import Path

from folding_server.errors import PhotoError

TRUTH_FILE = "truth.json"
"""What every folder of photographs holds, and no other sequence."""
WRITTEN = frozenset({"keyframes.json", "program.json", TRUTH_FILE})
"""The documents beside the pictures."""
PICTURE_NAMES = {"frames": re.compile(r"\d{6}\.jpg"), "masks": re.compile(r"\d{6}\.png")}
"""The folders of pictures, and what their files are called."""


def require_usable(folder: Path) -> None:
    """Raise PhotoError if a folder is a file, or holds anything that was not written there by photographing."""
    if folder.exists() and not folder.is_dir():
        raise PhotoError(f"{folder} is a file; give a folder to write the sequence into.")
    if not folder.is_dir() or not any(folder.iterdir()):
        return
    if (folder / "keyframes.json").exists() and not (folder / TRUTH_FILE).exists():
        raise PhotoError(f"{folder} holds a sequence that was not made here; give another folder.")
    strange = next(_not_ours(folder), None)
    if strange is not None or not (folder / TRUTH_FILE).exists():
        named = strange or next(folder.iterdir())
        raise PhotoError(
            f"{folder} holds {named.relative_to(folder)}, which is no photograph of a program; "
            "give a new or empty folder, or one with photographs alone."
        )


def _not_ours(folder: Path) -> Iterator[Path]:
    """What lies in a folder and is nothing that photographing writes, in order of name."""
    for path in sorted(folder.iterdir()):
        if path.name in PICTURE_NAMES and path.is_dir():
            yield from (
                each for each in sorted(path.iterdir()) if not PICTURE_NAMES[path.name].fullmatch(each.name)
            )
        elif path.name not in WRITTEN or not path.is_file():
            yield path
