"""Where the states of a sequence are: a FOLD file for each, or the frames of one file."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from folding_server.errors import FoldingError, ProgramError
from folding_server.interchange.fold_frames import parse_json_object
from folding_server.typed_text import text_in

STATES_ADVICE = "give a FOLD file with a frame for each state, or a folder with a FOLD file for each"
STEP_FILES = ("*.fold", "*/cp.fold", "*/*.fold")
"""Where a folder has them: side by side, or each in the folder of its step."""


def given_documents(source: Path) -> list[Mapping[str, Any]]:
    """The FOLD document of each state in order. FoldingError if there is none, or a file cannot be read."""
    if source.is_dir():
        files = next((found for pattern in STEP_FILES if (found := list(source.glob(pattern)))), [])
        if not files:
            raise FoldingError(f"{source} holds no FOLD file; {STATES_ADVICE}.")
        return [_document(file) for file in sorted(files, key=_by_numbers)]
    return documents_of_frames(_document(source))


def _document(file: Path) -> Mapping[str, Any]:
    return parse_json_object(text_in(file, STATES_ADVICE), f"file {file.name}")


def _by_numbers(file: Path) -> tuple[tuple[int, ...], str]:
    """Files in the order of the numbers in their paths, so that 10 comes after 9."""
    text = f"{file.parent.name}/{file.name}"
    return tuple(map(int, re.findall(r"\d+", text))), text


def documents_of_frames(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Each state of a file with frames as a document of its own.

    A file that has as many folded forms as crease patterns has one of each a state, in order; otherwise each frame is a state.
    """
    below = document.get("file_frames", [])
    if not isinstance(below, list) or not all(isinstance(frame, Mapping) for frame in below):
        raise ProgramError(
            "The FOLD file's file_frames is not a list of frames; give a list of JSON objects."
        )
    key = {name: value for name, value in document.items() if not name.startswith("file_")}
    frames: list[Mapping[str, Any]] = [each for each in _whole([key, *below]) if "vertices_coords" in each]
    folded = [frame for frame in frames if "foldedForm" in frame.get("frame_classes", [])]
    flat = [frame for frame in frames if frame not in folded]
    if len(folded) == len(flat):
        return [{**pattern, "file_frames": [form]} for pattern, form in zip(flat, folded, strict=True)]
    return frames


def _whole(frames: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The frames with what they inherit from their parents."""
    found: list[dict[str, Any]] = []
    for index, frame in enumerate(frames):
        parent = frame.get("frame_parent")
        inherits = frame.get("frame_inherit") and isinstance(parent, int) and 0 <= parent < index
        above = found[parent] if inherits and isinstance(parent, int) else {}
        own = {name: value for name, value in frame.items() if name not in {"frame_parent", "frame_inherit"}}
        found.append({**above, **own})
    return found
