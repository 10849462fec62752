"""PurelandFold, the data set of the FoldingAgent paper, read from its Parquet files.

A row is a keyframe: ``sequence``, ``step``, ``image``, ``cp.svg``, ``cp.fold`` and ``flat_folder``. Known of it: 27 sequences of 5
to 21 keyframes, 337 in all; coordinates have three decimals; there are no labels of actions; some sequences begin with creases
already made; ``faceOrders`` name the upper face first as the model is seen; mountains and valleys are swapped while the
model is flipped.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_client.interrupts import UsageError

NEEDED = ("sequence", "step", "cp.fold")
IMAGE_ENDINGS = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}
"""Of photos by how their bytes begin."""


@dataclass(frozen=True)
class Keyframe:
    """A row: what it says of one keyframe; each None where the row does not say it."""

    step: int
    fold: str | None
    photo: bytes | None
    drawing: str | None


def purelandfold_sequences(file: Path) -> dict[str, list[Keyframe]]:
    """The keyframes of each sequence in order. UsageError if the file cannot be read or lacks a column."""
    found: dict[str, list[Keyframe]] = {}
    for row in _rows(file):
        found.setdefault(_name(row["sequence"], file), []).append(_keyframe(row, file))
    if not found:
        message = f"{file} holds no keyframe."
        raise UsageError(message)
    return {name: sorted(frames, key=lambda frame: frame.step) for name, frames in sorted(found.items())}


def _rows(file: Path) -> Iterator[Mapping[str, Any]]:
    try:
        from pyarrow import ArrowException, parquet
    except ImportError as error:
        message = "Parquet files are read with pyarrow, which is not installed; pip install 'foldingagent-mcp[datasets]' brings it."
        raise UsageError(message) from error
    try:
        table = parquet.ParquetFile(file)
        missing = [name for name in NEEDED if name not in table.schema_arrow.names]
        if missing:
            message = (
                f"{file} has no column {missing[0]!r}; its columns are {', '.join(table.schema_arrow.names)}. Name a file of "
                "PurelandFold."
            )
            raise UsageError(message)
        for batch in table.iter_batches(batch_size=16):
            yield from batch.to_pylist()
    except (OSError, ArrowException) as error:
        message = f"{file} cannot be read as Parquet: {' '.join(str(error).split())}."
        raise UsageError(message) from error


def _name(value: object, file: Path) -> str:
    """The name of a sequence, which becomes a folder's."""
    name = str(value)
    if not name.strip() or not name.isprintable() or name.startswith(".") or set(name) & set("/\\:"):
        message = f"{file} names a sequence {name!r}, which cannot be the name of a folder."
        raise UsageError(message)
    return name


def _keyframe(row: Mapping[str, Any], file: Path) -> Keyframe:
    try:
        step = int(row["step"])
    except (TypeError, ValueError) as error:
        message = f"{file} has the step {row['step']!r} in {row['sequence']}; steps are whole numbers."
        raise UsageError(message) from error
    pattern, folded = _text(row["cp.fold"]), _text(row.get("flat_folder"))
    photo = _bytes(row.get("image"))
    return Keyframe(step, pattern and with_folded_form(pattern, folded), photo, _text(row.get("cp.svg")))


def _bytes(value: object) -> bytes | None:
    """The bytes of a cell: as they are, or in a record with their path, as libraries for data sets keep files."""
    if isinstance(value, dict):
        value = value.get("bytes")
    return value.encode() if isinstance(value, str) else value if isinstance(value, bytes) and value else None


def _text(value: object) -> str | None:
    if isinstance(value, dict) and "bytes" not in value:
        return json.dumps(value)
    found = _bytes(value)
    return None if found is None else found.decode("utf-8", errors="replace")


def with_folded_form(pattern: str, folded: str | None) -> str:
    """The text of a FOLD file with the folded form that stands in another, if it has none itself."""
    one, other = _document(pattern), _document(folded)
    if one is None or other is None or _folded_frame(one) is not None:
        return pattern
    frame = _folded_frame(other)
    if frame is None or len(frame["vertices_coords"]) != len(one.get("vertices_coords", ())):
        return pattern
    mesh: dict[str, Any] = {
        key: one[key] for key in ("edges_vertices", "edges_assignment", "faces_vertices") if key in one
    }
    form: dict[str, Any] = {
        "frame_classes": ["foldedForm"],
        "vertices_coords": frame["vertices_coords"],
        **mesh,
    }
    flat: dict[str, Any] = {**one, "frame_classes": ["creasePattern"]}
    orders = frame.get("faceOrders") or one.get("faceOrders") or []
    return json.dumps({**flat, "file_frames": [*one.get("file_frames", ()), {**form, "faceOrders": orders}]})


def _document(text: str | None) -> dict[str, Any] | None:
    try:
        document = json.loads(text or "")
    except ValueError:
        return None
    return document if isinstance(document, dict) else None


def _folded_frame(document: Mapping[str, Any]) -> Mapping[str, Any] | None:
    frames = [document, *document.get("file_frames", ())]
    return next(
        (
            frame
            for frame in frames
            if "foldedForm" in frame.get("frame_classes", ()) and frame.get("vertices_coords")
        ),
        None,
    )
