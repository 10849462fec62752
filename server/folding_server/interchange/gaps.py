"""Ends of lines that miss what they were drawn to meet, joined to it: an edge, another line, or each other."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from math import dist

import numpy as np
import shapely

from folding_server.arrays import Floats, Indices, Ints
from folding_server.geometry.line import Point
from folding_server.interchange.cutting import CutLines, lines_cut
from folding_server.interchange.drawn_line import COINCIDENT, DrawnLine
from folding_server.simulator.foldability import JoinedEnd

GAP = 0.002
"""How far, in units of the drawing's longer side, an end may miss what it is joined to: what editors of crease patterns
join by default is of that size, and creases of published patterns are at least five times as long."""
ROUNDS = 3
"""How often ends are joined: one that is moved may leave another loose."""
MARKS = "F"
"""Marks may end anywhere."""


def closed_gaps(
    lines: Sequence[DrawnLine], gap: float = GAP
) -> tuple[list[DrawnLine], tuple[JoinedEnd, ...], CutLines]:
    """The lines with loose ends moved onto the nearest vertex within ``gap``, else the nearest line; what was moved; and the
    lines as they are then, cut.

    An end that reaches beyond the line it was drawn to by less than ``gap`` is taken back to it.
    """
    changed, joined, cut = list(lines), list[JoinedEnd](), lines_cut(lines)
    for _ in range(ROUNDS if gap > COINCIDENT else 0):
        moves = _moves(changed, cut, gap)
        if not moves:
            break
        for k, end, place, size in moves:
            line = changed[k]
            before = line.end if end else line.start
            changed[k] = replace(line, end=place) if end else replace(line, start=place)
            joined.append(JoinedEnd(before, place, size))
        cut = lines_cut(changed)
    return changed, tuple(joined), cut


def _moves(lines: Sequence[DrawnLine], cut: CutLines, gap: float) -> list[tuple[int, int, Point, float]]:
    """(line, 0 start or 1 end, where to, how far in units of the longer side) of the loose ends that are joined."""
    places, passed, extent = cut.places, cut.passed, cut.near / COINCIDENT
    stretches = [(u, v, k) for k, row in enumerate(passed) for u, v in itertools.pairwise(row)]
    if not stretches:
        return []
    table = np.array(stretches, int)
    met = np.bincount(_distinct(table[:, :2]).reshape(-1), minlength=len(places))
    loose = [
        (k, end, row[-1] if end else row[0])
        for k, row in enumerate(passed)
        for end in (0, 1)
        if lines[k].assignment != MARKS and len(row) > 1 and met[row[-1] if end else row[0]] == 1
    ]
    beside = _within_reach(places, table, [v for _, _, v in loose], gap * extent)
    found = []
    for (k, end, v), near in zip(loose, beside, strict=True):
        place = _target(places, table[near], k, passed[k], end, gap * extent)
        if place is not None:
            found.append((k, end, v, place, dist(places[v], place) / extent))
    return _each_once(found, places)


def _within_reach(places: Floats, table: Ints, ends: Sequence[int], reach: float) -> list[Indices]:
    """For each loose end the stretches within reach of it."""
    tree = shapely.STRtree(np.asarray(shapely.linestrings(places[table[:, :2]])))
    points = np.asarray(shapely.points(places[np.array(ends, int)].reshape(-1, 2)))
    end, stretch = tree.query(points, predicate="dwithin", distance=reach)
    return [stretch[end == number] for number in range(len(ends))]


def _each_once(
    moves: list[tuple[int, int, int, Point, float]], places: Floats
) -> list[tuple[int, int, Point, float]]:
    """Without moves of an end onto one that was itself moved."""
    kept, left = [], set[Point]()
    for k, end, v, place, size in moves:
        if place not in left:
            kept.append((k, end, place, size))
            left.add(_point(places[v]))
    return kept


def _distinct(edges: Ints) -> Ints:
    distinct: Ints = np.unique(np.sort(edges, axis=1), axis=0)
    return distinct


def _target(places: Floats, table: Ints, line: int, row: list[int], end: int, reach: float) -> Point | None:
    """Where a loose end belongs: its line's last vertex before it, if that is within reach; else the nearest vertex, else
    the nearest line, that is not its own.
    """
    v, before = (row[-1], row[-2]) if end else (row[0], row[1])
    here = places[v]
    if len(row) > 2 and dist(here, places[before]) <= reach:
        return _point(places[before])
    others = table[(table[:, 2] != line) & (table[:, 0] != v) & (table[:, 1] != v)]
    if not len(others):
        return None
    near = np.unique(others[:, :2])
    apart = np.hypot(*(places[near] - here).T)
    if apart.min() <= reach:
        return _point(places[near[apart.argmin()]])
    segments = np.asarray(shapely.linestrings(places[others[:, :2]]))
    distances = shapely.distance(segments, shapely.Point(here))
    nearest = int(distances.argmin())
    if distances[nearest] > reach:
        return None
    return _meeting(places[before], here, places[others[nearest, :2]], segments[nearest], 2 * reach)


def _meeting(start: Floats, here: Floats, other: Floats, segment: shapely.LineString, reach: float) -> Point:
    """Where a line goes on to meet a segment, if that is within reach of its end; else the nearest point of the segment."""
    run, theirs, arm = here - start, other[1] - other[0], other[0] - start
    across = run[0] * theirs[1] - run[1] * theirs[0]
    if across:
        t, s = (
            (arm[0] * theirs[1] - arm[1] * theirs[0]) / across,
            (arm[0] * run[1] - arm[1] * run[0]) / across,
        )
        place = start + t * run
        if 0 <= s <= 1 and dist(place, here) <= reach:
            return _point(place)
    x, y = shapely.shortest_line(segment, shapely.Point(here)).coords[0]
    return float(x), float(y)


def _point(place: Floats) -> Point:
    return float(place[0]), float(place[1])
