"""Crease patterns in Oriedita's ``.ori``: JSON with the lines of its canvas. Read only."""

from collections.abc import Iterator, Mapping
from typing import Any

from folding_server.errors import ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.fold_frames import LARGEST, parse_json_object
from folding_server.interchange.gaps import GAP
from folding_server.interchange.line_files import drawn_downwards
from folding_server.simulator.foldability import Assignment, CreasePattern

LINE_COLORS: Mapping[str, Assignment] = {"BLACK_0": "B", "RED_1": "M", "BLUE_2": "V"}
"""What lines of a colour are; the others are auxiliary."""


def read_oriedita(text: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern of an ``.ori`` file, y turned up. ProgramError names the line that cannot be read."""
    document = parse_json_object(text, ".ori file")
    listed = document.get("lineSegments")
    if not isinstance(listed, list):
        raise ProgramError(
            "The .ori file has no lineSegments; save it again in Oriedita, or export it as .cp or FOLD."
        )
    if not listed:
        raise ProgramError(
            "The .ori file has no lines: its lineSegments are empty; draw the crease pattern first."
        )
    return drawn_downwards(list(_lines(listed)), gap)


def _lines(listed: list[Any]) -> Iterator[DrawnLine]:
    for number, each in enumerate(listed, 1):
        if not isinstance(each, Mapping):
            raise ProgramError(f"Line {number} of the .ori file is no object with the ends a and b.")
        color = each.get("color")
        letter = LINE_COLORS.get(color, "F") if isinstance(color, str) else "F"
        yield DrawnLine(_point(each.get("a"), number), _point(each.get("b"), number), letter)


def _point(given: object, line: int) -> Point:
    """An end as ``"x,y"`` or as an object with x and y."""
    parts: list[Any] = given.split(",") if isinstance(given, str) else []
    if isinstance(given, Mapping):
        parts = [given.get("x"), given.get("y")]
    try:
        x, y = (float(part) for part in parts)
    except (TypeError, ValueError):
        x = y = float("nan")
    if not (abs(x) <= LARGEST and abs(y) <= LARGEST):
        raise ProgramError(
            f"Line {line} of the .ori file ends at {str(given)[:60]!r}; it should be two numbers up to {LARGEST:g}: x,y."
        )
    return x, y
