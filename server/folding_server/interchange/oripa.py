"""The crease pattern in the ``.cp`` text form of ORIPA and Oriedita: one line ``type x1 y1 x2 y2`` a crease.

Types: 1 edge of the sheet, 2 mountain, 3 valley, 4 auxiliary (marks and unassigned creases). The longer side
of the sheet runs from -200 to 200, x to the right and y down, as those programs draw it.
"""

from folding_server.simulator.foldability import CreasePattern
from folding_server.simulator.plane_geometry import Point

LINE_TYPES = {"B": 1, "M": 2, "V": 3, "F": 4, "U": 4}
SPAN = 400.0


def oripa_text(pattern: CreasePattern) -> str:
    """The ``.cp`` file of a crease pattern, in full double precision."""
    xs, ys = zip(*pattern.vertices, strict=True)
    middle = (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2
    scale = SPAN / max(max(xs) - min(xs), max(ys) - min(ys))

    def point(place: Point) -> str:
        return f"{_plain((place[0] - middle[0]) * scale)} {_plain((middle[1] - place[1]) * scale)}"

    return "".join(
        f"{LINE_TYPES[letter]} {point(pattern.vertices[u])} {point(pattern.vertices[v])}\n"
        for (u, v), letter in zip(pattern.edges, pattern.letters, strict=True)
    )


def _plain(value: float) -> str:
    """The shortest decimal text that reads back as the same number, without an exponent."""
    text = repr(value + 0.0)
    return format(value, ".20f").rstrip("0") if "e" in text else text
