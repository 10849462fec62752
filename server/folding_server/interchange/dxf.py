"""Crease patterns in DXF drawings: LINE, LWPOLYLINE and POLYLINE of the ASCII form, by layer or colour. Read only."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from folding_server.errors import ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.arrangement import arranged
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.fold_frames import LARGEST
from folding_server.interchange.gaps import GAP
from folding_server.interchange.line_files import ALL_LETTERS, framed
from folding_server.simulator.foldability import Assignment, CreasePattern

Tag = tuple[int, str]
"""A group code and its value."""

COLOR_NUMBERS: Mapping[int, Assignment] = {0: "B", 1: "M", 5: "V", 6: "U", 7: "B", 250: "B"}
"""Colour numbers of AutoCAD: red, blue, magenta, white (black on paper); the others are marks."""
WORDS: Mapping[str, Assignment] = {
    "mountain": "M", "valley": "V", "border": "B", "edge": "B", "outline": "B", "cut": "B", "aux": "F", "mark": "F",
}  # fmt: skip
"""Words in the name of a layer that say what its lines are, before their colour does."""
BY_LAYER = 256
CODE_X, CODE_Y, CODE_LAYER, CODE_COLOR, CODE_FLAGS = 10, 20, 8, 62, 70


def read_dxf(text: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern of a DXF drawing, whose y runs up. Layers named after mountains, valleys and edges, else colours, tell
    the lines apart: red 1, blue 5, black or white 7. ProgramError names the line of the file that cannot be read.
    """
    records = list(_records(_tags(text)))
    layers = {_first(record, 2): _color(record, 7) for record in records if record[0] == (0, "LAYER")}
    lines = [line for record in _joined(records) for line in _drawn(record, layers)]
    if not lines:
        raise ProgramError(
            "The DXF file has no LINE, LWPOLYLINE or POLYLINE; explode blocks and save it as ASCII DXF."
        )
    lines, notes = framed(lines)
    return replace(arranged(lines, gap=gap, off_sheet=ALL_LETTERS), notes=notes)


def _tags(text: str) -> Iterator[Tag]:
    rows = text.splitlines()
    for number in range(0, len(rows) - 1, 2):
        try:
            yield int(rows[number]), rows[number + 1].strip()
        except ValueError:
            raise ProgramError(
                f"Line {number + 1} of the DXF file reads {rows[number].strip()[:40]!r} where a group code is due; save it as "
                "ASCII DXF."
            ) from None


def _records(tags: Iterator[Tag]) -> Iterator[list[Tag]]:
    """Each entity, table entry or section with what belongs to it: what begins with group code 0."""
    record: list[Tag] = []
    for tag in tags:
        if tag[0] == 0:
            if record:
                yield record
            record = []
        record.append(tag)
    if record:
        yield record


def _joined(records: Sequence[list[Tag]]) -> Iterator[list[Tag]]:
    """The records, each POLYLINE with the points of the VERTEX records after it."""
    whole: list[Tag] | None = None
    for record in records:
        kind = record[0][1]
        if kind == "VERTEX" and whole is not None:
            whole += [tag for tag in record if tag[0] in {CODE_X, CODE_Y}]
            continue
        if whole is not None:
            yield whole
        whole = [tag for tag in record if tag[0] not in {CODE_X, CODE_Y}] if kind == "POLYLINE" else None
        if whole is None:
            yield record
    if whole is not None:
        yield whole


def _drawn(record: list[Tag], layers: Mapping[str, int]) -> Iterator[DrawnLine]:
    kind = record[0][1]
    if kind == "LINE":
        points = [_point(record, CODE_X, CODE_Y), _point(record, CODE_X + 1, CODE_Y + 1)]
    elif kind in {"LWPOLYLINE", "POLYLINE"}:
        xs, ys = ([_number(v) for c, v in record if c == code] for code in (CODE_X, CODE_Y))
        points = list(zip(xs, ys, strict=False))
        if int(_number(_first(record, CODE_FLAGS) or "0")) & 1 and points:
            points.append(points[0])
    else:
        return
    letter = _letter(record, layers)
    yield from (DrawnLine(p, q, letter) for p, q in pairwise(points))


def _letter(record: list[Tag], layers: Mapping[str, int]) -> Assignment:
    layer = _first(record, CODE_LAYER)
    named = next((letter for word, letter in WORDS.items() if word in layer.lower()), None)
    if named:
        return named
    color = _color(record, BY_LAYER)
    return COLOR_NUMBERS.get(layers.get(layer, 7) if color == BY_LAYER else color, "F")


def _color(record: list[Tag], missing: int) -> int:
    given = _first(record, CODE_COLOR)
    return abs(int(_number(given))) if given else missing


def _first(record: list[Tag], code: int) -> str:
    return next((value for each, value in record if each == code), "")


def _point(record: list[Tag], x: int, y: int) -> Point:
    return _number(_first(record, x)), _number(_first(record, y))


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) <= LARGEST:
        raise ProgramError(
            f"The DXF file has {text[:40]!r} where a number up to {LARGEST:g} is due; save it as ASCII DXF."
        )
    return value
