"""Reading FOLD documents: frames with inheritance resolved and every property checked for its shape."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NoReturn

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_server.errors import ProgramError

Coordinates = list[float]
LARGEST = 1e9
"""Coordinates beyond this are no drawing; their squares would leave no digits to measure with."""


class FoldRecord(BaseModel):
    """The ``folding:record`` of our own files: what the simulator needs beyond the standard properties."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    version: Literal[1]
    sheet: tuple[float, float]
    order: list[int]
    isometries: list[tuple[float, float, float, float, float, float]]
    counterclockwise: list[int]
    creases: list[tuple[tuple[int, int], list[tuple[int, int]]]]
    folds: int
    fold_edges: list[tuple[int, int, int]]


class FoldFrame(BaseModel):
    """One frame of a FOLD file; properties that are not used here are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    frame_classes: list[str] = []
    vertices_coords: list[Coordinates] = []
    edges_vertices: list[tuple[int, int]] = []
    edges_assignment: list[Literal["B", "M", "V", "F", "U", "C", "J", "b", "m", "v", "f", "u", "c", "j"]] = []
    fold_angles: list[float | None] = Field(default=[], alias="edges_foldAngle")
    faces_vertices: list[list[int]] = []
    face_orders: list[tuple[int, int, Literal[-1, 0, 1]]] = Field(default=[], alias="faceOrders")
    vertex_ids: list[int] = Field(default=[], alias="folding:vertex_ids")
    face_ids: list[int] = Field(default=[], alias="folding:face_ids")
    record: FoldRecord | None = Field(default=None, alias="folding:record")

    def of_class(self, name: str) -> bool:
        """Whether the frame says that it is a ``foldedForm``, ``creasePattern``, ..."""
        return name in self.frame_classes

    def assignments(self) -> tuple[str, ...]:
        """The assignment of each edge, upper case: as assigned, else by its fold angle, else U."""
        if self.edges_assignment:
            return tuple(assignment.upper() for assignment in self.edges_assignment)
        if self.fold_angles:
            return tuple(
                "U" if a is None else "V" if a > 0 else "M" if a < 0 else "F" for a in self.fold_angles
            )
        return ("U",) * len(self.edges_vertices)


def read_frames(source: str | Mapping[str, Any]) -> list[FoldFrame]:
    """All frames of a FOLD file, the key frame first. ``source`` is its text or the parsed document.

    ProgramError if it is not JSON or no FOLD object, or a property has a wrong shape or a wrong index.
    """
    document = _document(source)
    below = document.get("file_frames", [])
    if not isinstance(below, list) or not all(isinstance(frame, Mapping) for frame in below):
        raise ProgramError(
            "The FOLD file's file_frames is not a list of frames; give a list of JSON objects."
        )
    raw = [{k: v for k, v in document.items() if not k.startswith("file_")}, *below]
    return [_frame(_inherited(raw, i), i) for i in range(len(raw))]


def frame_of(frames: Sequence[FoldFrame], name: str) -> FoldFrame | None:
    """The first frame of a class, such as ``creasePattern``; None if there is none."""
    return next((frame for frame in frames if frame.of_class(name)), None)


def parse_json_object(text: str, kind: str) -> Mapping[str, Any]:
    """The JSON object in a text; ProgramError with line and column if it is none. ``kind`` names the file."""
    try:
        document = json.loads(text, parse_constant=_refuse_constant)
    except _ConstantError as error:
        raise ProgramError(
            f"The {kind} is not JSON: it has the number {error}, which JSON has not; give a finite number."
        ) from None
    except (ValueError, RecursionError) as error:
        where = (
            f" (line {error.lineno}, column {error.colno})" if isinstance(error, json.JSONDecodeError) else ""
        )
        raise ProgramError(f"The {kind} is not JSON{where}; check the file or save it again.") from None
    if not isinstance(document, Mapping):
        raise ProgramError(f"The {kind} holds a JSON {type(document).__name__} where an object is needed.")
    return document


def _refuse_constant(name: str) -> NoReturn:
    raise _ConstantError(name)


class _ConstantError(Exception):
    """A NaN or an infinity in a document."""


def _document(source: str | Mapping[str, Any]) -> Mapping[str, Any]:
    return parse_json_object(source, "FOLD file") if isinstance(source, str) else source


def _inherited(raw: Sequence[Mapping[str, Any]], index: int) -> dict[str, Any]:
    """A frame with what it inherits from its parents filled in."""
    merged: dict[str, Any] = {}
    seen: set[int] = set()
    while index not in seen:
        seen.add(index)
        frame = raw[index]
        merged = {**frame, **merged}
        parent = frame.get("frame_parent")
        if not frame.get("frame_inherit") or parent is None:
            return merged
        if not isinstance(parent, int) or not 0 <= parent < len(raw):
            raise ProgramError(
                f"Frame {_said(index)} of the FOLD file has frame_parent {parent!r}, but frame_parent is from 0, the key frame, to "
                f"{len(raw) - 1}."
            )
        index = parent
    raise ProgramError(
        f"Frame {_said(index)} of the FOLD file inherits from itself; break the circle of frame_parent."
    )


def _said(index: int) -> str:
    """The number of a frame in words, as ``--frame`` takes it: from 1."""
    return f"{index + 1} (the key frame)" if index == 0 else str(index + 1)


def _frame(properties: dict[str, Any], index: int) -> FoldFrame:
    try:
        frame = FoldFrame.model_validate(properties)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ProgramError(
            f"In frame {_said(index)} of the FOLD file, {where} is wrong: {first['msg']}."
        ) from None
    _check_sizes(frame, index)
    _check_numbers(frame, index)
    return frame


def _check_numbers(frame: FoldFrame, index: int) -> None:
    """Coordinates must be numbers that can be measured with."""
    for v, point in enumerate(frame.vertices_coords):
        for axis, c in zip("xyzw", point, strict=False):
            if not abs(c) <= LARGEST:
                raise ProgramError(
                    f"In frame {_said(index)} of the FOLD file, the {axis} coordinate of vertex {v} is {c:g}; coordinates are numbers from "
                    f"-{LARGEST:g} to {LARGEST:g}."
                )


def _check_sizes(frame: FoldFrame, index: int) -> None:
    """Every index must name something, and parallel lists must be as long as what they describe."""
    vertices, edges, faces = len(frame.vertices_coords), len(frame.edges_vertices), len(frame.faces_vertices)
    _check_range(
        index, "edges_vertices", (v for edge in frame.edges_vertices for v in edge), vertices, "vertices"
    )
    _check_range(
        index, "faces_vertices", (v for face in frame.faces_vertices for v in face), vertices, "vertices"
    )
    _check_range(index, "faceOrders", (f for order in frame.face_orders for f in order[:2]), faces, "faces")
    lengths = (
        ("edges_assignment", len(frame.edges_assignment), edges),
        ("edges_foldAngle", len(frame.fold_angles), edges),
        ("folding:vertex_ids", len(frame.vertex_ids), vertices),
        ("folding:face_ids", len(frame.face_ids), faces),
    )
    for name, length, wanted in lengths:
        if length not in (0, wanted):
            raise ProgramError(
                f"In frame {_said(index)} of the FOLD file, {name} has {length} entries where {wanted} are needed."
            )
    loop = next((i for i, (u, v) in enumerate(frame.edges_vertices) if u == v), None)
    if loop is not None:
        v = frame.edges_vertices[loop][0]
        raise ProgramError(
            f"In frame {_said(index)} of the FOLD file, edge {loop} joins vertex {v} with itself; leave it out."
        )
    thin = next((i for i, face in enumerate(frame.faces_vertices) if len(face) < 3), None)
    if thin is not None:
        raise ProgramError(
            f"In frame {_said(index)} of the FOLD file, face {thin} has fewer than three corners."
        )
    if any(len(point) < 2 for point in frame.vertices_coords):
        raise ProgramError(
            f"In frame {_said(index)} of the FOLD file, a vertex has fewer than two coordinates."
        )


def _check_range(index: int, name: str, used: Iterable[int], count: int, kind: str) -> None:
    for i in used:
        if not 0 <= i < count:
            raise ProgramError(
                f"In frame {_said(index)} of the FOLD file, {name} names number {i}, but there are {count} "
                f"{kind}, from 0."
            )
