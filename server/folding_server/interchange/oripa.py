"""The crease pattern in the ``.cp`` text form of ORIPA and Oriedita: one line ``type x1 y1 x2 y2`` a crease.

Types: 1 edge of the sheet, 2 mountain, 3 valley, and any other an auxiliary line that is not folded, of which 4 is
written. Those programs write the coordinates of their canvas: y runs down (both turn it over when they write DXF, whose
y runs up), the sheet lies front up, and ORIPA's own sheet runs from -200 to 200.
"""

from folding_server.errors import ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.interchange.fold_frames import LARGEST
from folding_server.interchange.gaps import GAP
from folding_server.interchange.line_files import drawn_downwards
from folding_server.simulator.foldability import Assignment, CreasePattern

LINE_TYPES: dict[Assignment, int] = {"B": 1, "M": 2, "V": 3, "F": 4, "U": 4}
LINE_ASSIGNMENTS: dict[int, Assignment] = {1: "B", 2: "M", 3: "V"}
SPAN = 400.0


def oripa_text(pattern: CreasePattern) -> str:
    """The ``.cp`` file of a crease pattern, in full double precision; the longer side of the sheet runs from -200 to 200.

    Marks and unassigned creases are auxiliary lines: the format has no others.
    """
    xs, ys = zip(*pattern.vertices_coords, strict=True)
    middle = (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2
    scale = SPAN / max(max(xs) - min(xs), max(ys) - min(ys))

    def point(coords: Point) -> str:
        return f"{_plain((coords[0] - middle[0]) * scale)} {_plain((middle[1] - coords[1]) * scale)}"

    return "".join(
        f"{LINE_TYPES[assignment]} {point(pattern.vertices_coords[u])} {point(pattern.vertices_coords[v])}\n"
        for (u, v), assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
    )


def read_oripa(text: str, gap: float = GAP) -> CreasePattern:
    """The crease pattern of a ``.cp`` file, y turned up and otherwise in the file's units.

    Lines may cross, touch and repeat each other: they are cut where they meet, and vertices are numbered in the order
    in which the file comes to them. Auxiliary lines are marks (F). Ends that miss by up to ``gap``, in units of the longer side,
    are joined. ProgramError names the line that cannot be read.
    """
    lines = [_drawn(number, row.split()) for number, row in enumerate(text.splitlines(), 1) if row.strip()]
    if not lines:
        raise ProgramError("The .cp file has no lines; each should read: type x1 y1 x2 y2.")
    return drawn_downwards(lines, gap)


def _drawn(number: int, fields: list[str]) -> DrawnLine:
    try:
        kind, (x1, y1, x2, y2) = int(fields[0]), map(float, fields[1:])
    except ValueError:
        kind, x1, y1, x2, y2 = 0, *(float("nan"),) * 4
    if not all(abs(c) <= LARGEST for c in (x1, y1, x2, y2)):
        raise ProgramError(
            f"Line {number} of the .cp file reads {' '.join(fields)[:60]!r}; it should be a whole number, the type, and "
            f"four numbers up to {LARGEST:g}: x1 y1 x2 y2."
        )
    return DrawnLine((x1, y1), (x2, y2), LINE_ASSIGNMENTS.get(kind, "F"))


def _plain(value: float) -> str:
    """The shortest decimal text that reads back as the same number, without an exponent."""
    text = repr(value + 0.0)
    return format(value, ".20f").rstrip("0") if "e" in text else text
