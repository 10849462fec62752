"""The sectors of paper around the vertices of a crease pattern, and the folded creases between them."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, hypot, tau

from folding_server.geometry.graph import Edge, sides
from folding_server.simulator.foldability.pattern import FOLDED_ASSIGNMENTS, Assignment, CreasePattern


@dataclass(frozen=True)
class VertexSectors:
    """The paper around a vertex, cut into sectors by the folded creases there, counter-clockwise.

    ``angles``    of the sectors, in radians
    ``letters``   M, V or U of the creases: crease k lies between sectors k and k + 1, the last one of a closed circle between
                  the last sector and the first
    ``closed``    whether the paper goes all around; else sectors begin and end at edges of the sheet
    ``corners``   for each sector the faces that have a corner in it: several where marks divide it
    ``shortest``  the length of the shortest crease or edge there
    """

    vertex: int
    angles: tuple[float, ...]
    letters: tuple[Assignment, ...]
    closed: bool
    corners: tuple[tuple[int, ...], ...]
    shortest: float


@dataclass(frozen=True)
class _Ray:
    """An edge as seen from one of its ends: its direction, length and letter, and the face counter-clockwise of it."""

    turn: float
    length: float
    letter: Assignment
    face: int | None


def sectors_around(pattern: CreasePattern, fewest: int) -> Iterator[VertexSectors]:
    """The sectors around each vertex, by ascending vertex, where they have at least so many folded creases between them.

    Where several stretches of paper meet in one vertex, each is given apart.
    """
    ends: dict[int, list[tuple[int, Assignment]]] = {}
    folded: dict[int, int] = {}
    for (u, v), letter in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True):
        for here, there in ((u, v), (v, u)):
            ends.setdefault(here, []).append((there, letter))
            folded[here] = folded.get(here, 0) + (letter in FOLDED_ASSIGNMENTS)
    left_of = {side: face for face, cycle in enumerate(pattern.cycles) for side in sides(cycle)}
    for vertex in sorted(v for v, count in folded.items() if count >= fewest):
        rays = sorted(_rays(pattern, vertex, ends[vertex], left_of), key=lambda ray: ray.turn)
        yield from (found for found in _stretches(vertex, rays) if len(found.letters) >= fewest)


def _rays(
    pattern: CreasePattern, vertex: int, ends: list[tuple[int, Assignment]], left_of: dict[Edge, int]
) -> Iterator[_Ray]:
    x, y = pattern.vertices_coords[vertex]
    for there, letter in ends:
        u, v = pattern.vertices_coords[there]
        yield _Ray(atan2(v - y, u - x), hypot(u - x, v - y), letter, left_of.get((vertex, there)))


def _stretches(vertex: int, rays: list[_Ray]) -> Iterator[VertexSectors]:
    """The stretches of paper between edges of the sheet; the whole circle if there is none."""
    starts = [k for k, ray in enumerate(rays) if ray.letter == "B"]
    if not starts:
        start = next(k for k, ray in enumerate(rays) if ray.letter in FOLDED_ASSIGNMENTS)
        yield _stretch(vertex, [*rays[start:], *rays[: start + 1]], closed=True)
    for start, end in zip(starts, [*starts[1:], starts[0] + len(rays)] if starts else (), strict=True):
        stretch = [rays[k % len(rays)] for k in range(start, end + 1)]
        if all(ray.face is not None for ray in stretch[:-1]):
            yield _stretch(vertex, stretch, closed=False)


def _stretch(vertex: int, rays: list[_Ray], *, closed: bool) -> VertexSectors:
    """The sectors from the first ray to the last, which is the first once more if closed."""
    angles: list[float] = []
    letters: list[Assignment] = []
    corners: list[list[int]] = []
    for here, after in pairwise(rays):
        if not angles or here.letter in FOLDED_ASSIGNMENTS:
            angles.append(0.0)
            corners.append([])
        angles[-1] += (after.turn - here.turn) % tau or (tau if len(rays) == 2 else 0.0)
        corners[-1] += [here.face] if here.face is not None else []
        if after.letter in FOLDED_ASSIGNMENTS:
            letters.append(after.letter)
    shortest = min(ray.length for ray in rays)
    return VertexSectors(vertex, tuple(angles), tuple(letters), closed, tuple(map(tuple, corners)), shortest)
