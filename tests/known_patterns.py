"""Crease patterns whose answers are known, drawn by small generators: pleats, maps, bases, Miura, twists, and broken ones.

Points are complex numbers on the unit square. The numbers of layer orders in ``KNOWN`` are those that ``plain_layers``
counts by trying.
"""

import json
from cmath import rect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi, tan
from random import Random

import shapely
from folding_server.simulator.foldability import CreasePattern

Crease = tuple[complex, complex, str]
CORNERS = (0j, 1 + 0j, 1 + 1j, 1j)
STRIPS = {0: 3, 1: 2, 4: 1, 5: 0, 6: 0, 7: 0, 8: 1, 10: 0, 11: 2}
MAPS = {
    (2, 2, 0): 1,
    (2, 3, 0): 2,
    (2, 3, 2): 4,
    (2, 4, 1): 3,
    (2, 4, 3): 5,
    (2, 4, 17): 7,
    (3, 3, 1): 20,
    (3, 3, 2): 1,
    (3, 3, 11): 40,
    (3, 3, 46): 0,
    (3, 3, 154): 0,
    (3, 4, 3): 0,
}
"""Layer orders of ``random_strip`` and ``random_map``."""


@dataclass(frozen=True)
class Known:
    """A pattern whose vertices all fold flat, and the number of its layer orders; 0 if it does not fold."""

    name: str
    pattern: CreasePattern
    orders: int


def on_square(creases: Iterable[Crease]) -> CreasePattern:
    """Creases that meet at their ends alone, on the unit square, whose boundary is cut where they reach it."""
    creases = list(creases)
    ends = [end for p, q, _ in creases for end in (p, q)]
    rim = _distinct([*CORNERS, *(z for z in ends if _on_rim(z))])
    rim.sort(key=_around)
    outline = [(p, q, "B") for p, q in pairwise([*rim, rim[0]])]
    return drawn([*outline, *creases])


def drawn(lines: Sequence[Crease]) -> CreasePattern:
    """Lettered lines as a pattern that lists its faces; ends nearer than a billionth are one vertex."""
    points = _distinct(end for p, q, _ in lines for end in (p, q))
    vertices = tuple((z.real, z.imag) for z in points)

    def index(z: complex) -> int:
        return min(range(len(points)), key=lambda i: abs(points[i] - z))

    edges = tuple((index(p), index(q)) for p, q, _ in lines)
    cells = shapely.polygonize([shapely.LineString([vertices[u], vertices[v]]) for u, v in edges]).geoms
    faces = tuple(tuple(vertices.index(corner) for corner in cell.exterior.coords[:-1]) for cell in cells)
    return CreasePattern(vertices, edges, tuple(letter for _, _, letter in lines), faces)


def strip(widths: Sequence[float], letters: str) -> CreasePattern:
    """Panels side by side, a letter for each crease between two."""
    edges = [sum(widths[:i]) / sum(widths) for i in range(1, len(widths))]
    return on_square((x + 0j, x + 1j, letter) for x, letter in zip(edges, letters, strict=True))


def map_of(columns: int, rows: int, letters: str) -> CreasePattern:
    """A map of equal panels: letters for the upright creases column line by column line, then for the others."""
    upright = [
        (complex(i / columns, j / rows), complex(i / columns, (j + 1) / rows))
        for i in range(1, columns)
        for j in range(rows)
    ]
    level = [
        (complex(i / columns, j / rows), complex((i + 1) / columns, j / rows))
        for j in range(1, rows)
        for i in range(columns)
    ]
    return on_square((p, q, letter) for (p, q), letter in zip([*upright, *level], letters, strict=True))


def miura(columns: int, rows: int, lean: float) -> CreasePattern:
    """Miura's map: straight level lines whose creases alternate, and upright zigzags, mountains and valleys in turn."""

    def at(i: int, j: int) -> complex:
        shift = lean * (-1) ** j if 0 < i < columns else 0
        return complex(i / columns + shift, j / rows)

    zigzags = [(at(i, j), at(i, j + 1), "MV"[i % 2]) for i in range(1, columns) for j in range(rows)]
    level = [(at(i, j), at(i + 1, j), "MV"[(i + j) % 2]) for j in range(1, rows) for i in range(columns)]
    return on_square([*zigzags, *level])


def twist(corners: int, lean: float, letters: str = "MV") -> CreasePattern:
    """A twist: a regular polygon of mountains in the middle, and from each of its sides a pleat to the rim.

    ``lean`` is how far a pleat leans from the normal of its side, in radians; ``letters`` are those of its two creases.
    """
    middle = [0.5 + 0.5j + rect(0.17, 2 * pi * k / corners + 0.1) for k in range(corners)]
    sides = [(p, q, "M") for p, q in pairwise([*middle, middle[0]])]
    pleats = []
    for p, q, _ in sides:
        along = (q - p) / abs(q - p) * -1j * rect(1, lean)
        pleats += [(p, _to_rim(p, along), letters[0]), (q, _to_rim(q, along), letters[1])]
    return on_square([*sides, *pleats])


def waterbomb() -> CreasePattern:
    """The waterbomb base: both diagonals valleys, one line through the middle a mountain."""
    middle = 0.5 + 0.5j
    return on_square(
        [*((middle, corner, "V") for corner in CORNERS), (middle, 0.5j, "M"), (middle, 1 + 0.5j, "M")]
    )


def kite() -> CreasePattern:
    """Two sides folded onto the diagonal."""
    reach = tan(pi / 8)
    return on_square([(0j, complex(1, reach), "V"), (0j, complex(reach, 1), "V")])


def blintz(letters: str = "VVVV") -> CreasePattern:
    """All four corners folded to the middle, or behind."""
    halves = [0.5 + 0j, 1 + 0.5j, 0.5 + 1j, 0.5j]
    return on_square(
        (p, q, letter) for (p, q), letter in zip(pairwise([*halves, halves[0]]), letters, strict=True)
    )


def moved(pattern: CreasePattern, by: complex, which: int = 0) -> CreasePattern:
    """A pattern with one of its inner vertices out of place."""
    v = inner(pattern)[which]
    x, y = pattern.vertices_coords[v]
    at = (x + by.real, y + by.imag)
    return replace(
        pattern, vertices_coords=(*pattern.vertices_coords[:v], at, *pattern.vertices_coords[v + 1 :])
    )


def flipped(pattern: CreasePattern, which: int = 0) -> CreasePattern:
    """A pattern with the other letter at one of the creases that end at an inner vertex."""
    inside = set(inner(pattern))
    creases = [i for i, edge in enumerate(pattern.edges_vertices) if inside & set(edge)]
    k = creases[which]
    letters = list(pattern.edges_assignment)
    letters[k] = "M" if letters[k] == "V" else "V"
    return replace(pattern, edges_assignment=tuple(letters))


def inner(pattern: CreasePattern) -> list[int]:
    """The vertices that do not lie on the boundary."""
    rim = {
        v
        for edge, letter in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
        if letter == "B"
        for v in edge
    }
    return [v for v in range(len(pattern.vertices_coords)) if v not in rim]


def random_strip(seed: int) -> CreasePattern:
    """Four to seven panels of widths that differ, with any letters."""
    chance = Random(seed)
    count = chance.randint(4, 7)
    widths = [chance.uniform(0.3, 1.0) for _ in range(count)]
    return strip(widths, "".join(chance.choice("MV") for _ in range(count - 1)))


def random_map(columns: int, rows: int, seed: int) -> CreasePattern:
    """A map with letters that satisfy Maekawa at every vertex, found by trying."""
    chance = Random(seed)
    count = (columns - 1) * rows + (rows - 1) * columns
    while True:
        pattern = map_of(columns, rows, "".join(chance.choice("MV") for _ in range(count)))
        if all(_mountains(pattern, v) in (1, 3) for v in inner(pattern)):
            return pattern


def fold_file(pattern: CreasePattern) -> str:
    """The FOLD file of a pattern, its faces listed."""
    document = {
        "file_spec": 1.2,
        "frame_classes": ["creasePattern"],
        "vertices_coords": [list(vertex) for vertex in pattern.vertices_coords],
        "edges_vertices": [list(edge) for edge in pattern.edges_vertices],
        "edges_assignment": list(pattern.edges_assignment),
        "faces_vertices": [list(cycle) for cycle in pattern.faces_vertices],
    }
    return json.dumps(document)


def _mountains(pattern: CreasePattern, vertex: int) -> int:
    letters = zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
    return sum(letter == "M" for edge, letter in letters if vertex in edge)


def _to_rim(start: complex, along: complex) -> complex:
    """Where a ray from inside the square leaves it."""
    walls = [
        ((1.0 if step > 0 else 0.0) - at) / step
        for at, step in ((start.real, along.real), (start.imag, along.imag))
        if abs(step) > 1e-12
    ]
    return start + min(walls) * along


def _on_rim(z: complex) -> bool:
    return min(abs(z.real), abs(z.imag), abs(1 - z.real), abs(1 - z.imag)) < 1e-9


def _around(z: complex) -> float:
    """How far along the square's outline a point of it lies, from the lower left corner."""
    x, y = z.real, z.imag
    if y < 1e-9:
        return x
    if x > 1 - 1e-9:
        return 1 + y
    return 3 - x if y > 1 - 1e-9 else 4 - y


def _distinct(points: Iterable[complex]) -> list[complex]:
    found: list[complex] = []
    for z in points:
        if all(abs(z - other) > 1e-9 for other in found):
            found.append(z)
    return found


KNOWN = [
    Known("book", strip((0.6, 0.4), "V"), 1),
    Known("slanted book", on_square([(0.3 + 0j, 0.6 + 1j, "M")]), 1),
    Known("even pleats", strip((1,) * 6, "MVMVM"), 1),
    Known("short panel rolled up", strip((1, 0.5, 1), "VV"), 0),
    Known("long panel rolled up", strip((1, 2, 1), "VV"), 1),
    Known("slanted panels rolled up", on_square([(0.4 + 0j, 0.3 + 1j, "V"), (0.55 + 0j, 0.5 + 1j, "V")]), 0),
    Known("kite", kite(), 1),
    Known("blintz", blintz(), 1),
    Known("blintz behind at two corners", blintz("MVMV"), 1),
    Known("waterbomb", waterbomb(), 1),
    Known("Miura 3x3", miura(3, 3, 0.05), 1),
    Known("Miura 4x3", miura(4, 3, 0.05), 1),
    Known("Miura leaning against its letters", miura(4, 3, -0.05), 0),
    Known("Miura 5x5", miura(5, 5, 0.04), 1),
    Known("twist of four, wide", twist(4, 1.0, "VM"), 1),
    Known("twist of four, wide the other way", twist(4, -1.0), 1),
    Known("twist of four, too tight", twist(4, 0.4, "VM"), 0),
    Known("twist of four, small angle between mountains", twist(4, 1.0), 0),
    Known("twist of six, wide", twist(6, 0.8, "VM"), 1),
    Known("twist of six, too tight", twist(6, 0.2, "VM"), 0),
    *(Known(f"strip {seed}", random_strip(seed), orders) for seed, orders in STRIPS.items()),
    *(Known(f"map {c}x{r} {seed}", random_map(c, r, seed), orders) for (c, r, seed), orders in MAPS.items()),
]
TWISTS = {known.name: known.pattern for known in KNOWN if "wide" in known.name}
"""They fold flat, but each pleat lies under the next all the way round."""
