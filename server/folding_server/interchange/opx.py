"""Crease patterns in ORIPA's ``.opx``: the XML that Java's XMLEncoder writes of its lines. Read only."""

from collections.abc import Iterator
from math import isfinite
from xml.etree.ElementTree import Element

from folding_server.errors import ProgramError
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.fold_frames import LARGEST
from folding_server.interchange.gaps import GAP
from folding_server.interchange.line_files import drawn_downwards
from folding_server.interchange.oripa import LINE_ASSIGNMENTS
from folding_server.interchange.xml_reading import xml_root
from folding_server.simulator.foldability import CreasePattern

LINE_CLASS = "OriLineProxy"
"""How the Java class of a line ends; its package changed between versions."""


def read_opx(text: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern of an ``.opx`` file, y turned up. Numbers that the file leaves out are 0, as Java does.

    ProgramError if it is not XML, has no lines, or a line has a coordinate that is no number.
    """
    lines = list(_lines(xml_root(text, ".opx file")))
    if not lines:
        raise ProgramError("The .opx file has no lines; save it again in ORIPA, or export it as .cp or FOLD.")
    return drawn_downwards(lines, gap)


def _lines(root: Element) -> Iterator[DrawnLine]:
    objects = (each for each in root.iter("object") if each.get("class", "").endswith(LINE_CLASS))
    for number, each in enumerate(objects, 1):
        values = {v.get("property", ""): _number(v, number) for v in each.findall("void")}
        x1, y1, x2, y2 = (values.get(name, 0.0) for name in ("x0", "y0", "x1", "y1"))
        yield DrawnLine((x1, y1), (x2, y2), LINE_ASSIGNMENTS.get(int(values.get("type", 0.0)), "F"))


def _number(void: Element, line: int) -> float:
    text = "".join(void.itertext()).strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (isfinite(value) and abs(value) <= LARGEST):
        raise ProgramError(
            f"Line {line} of the .opx file has {void.get('property')} {text[:40]!r}; it should be a number up to {LARGEST:g}."
        )
    return value
