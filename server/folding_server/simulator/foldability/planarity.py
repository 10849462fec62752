"""What makes a graph no crease pattern of one sheet, each fault with its places."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import shapely

from folding_server.geometry.graph import Edge
from folding_server.geometry.planar import all_crossings
from folding_server.simulator.foldability.fault import Fault, said
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.local import longer_side
from folding_server.simulator.foldability.pattern import FOLDED_ASSIGNMENTS, CreasePattern


def not_a_pattern(pattern: CreasePattern) -> list[Fault]:
    """Why a graph is no crease pattern: it encloses nothing, edges cross, creases lie between no two faces, or end loose."""
    if not pattern.edges_vertices or not pattern.cycles:
        return [Fault("no face", "The pattern has no face: its edges enclose nothing.")]
    crossing = [
        _crossing(pattern, *edges) for edges in all_crossings(pattern.vertices_coords, pattern.edges_vertices)
    ]
    return crossing or [*_loose_ends(pattern), *_without_two_faces(pattern)]


def edge_words(pattern: CreasePattern, edge: Edge) -> str:
    """An edge in words: the names of its ends, and where the file has them."""
    u, v = edge
    return f"{pattern.name(u)}-{pattern.name(v)} from {said(pattern.place(u))} to {said(pattern.place(v))}"


def _edge_fault(pattern: CreasePattern, edge: Edge, detail: str) -> Fault:
    ends = pattern.place(edge[0]), pattern.place(edge[1])
    return Fault("one face", detail, tuple(map(pattern.name, edge)), ends, (ends,))


def _crossing(pattern: CreasePattern, i: int, j: int) -> Fault:
    first, second = pattern.edges_vertices[i], pattern.edges_vertices[j]
    names = [f"{pattern.name(u)}-{pattern.name(v)}" for u, v in (first, second)]
    lines = tuple((pattern.place(u), pattern.place(v)) for u, v in (first, second))
    one, other = (shapely.LineString([pattern.vertices_coords[v] for v in edge]) for edge in (first, second))
    common = shapely.intersection(one, other)
    at = shapely.point_on_surface(common)
    place = pattern.place_of((at.x, at.y))
    detail = f"Edges {names[0]} and {names[1]} meet without a common vertex at {said(place)}, so the pattern is not planar."
    return Fault("crossing", detail, tuple(map(pattern.name, (*first, *second))), (place,), lines)


def _folded_alone(pattern: CreasePattern) -> list[tuple[Edge, str]]:
    """The folded creases that do not lie between two faces, with their letters."""
    joined = {crease.edge for crease in pattern.creases}
    return [
        (edge, assignment)
        for edge, assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
        if assignment in FOLDED_ASSIGNMENTS and edge not in joined
    ]


def _loose_vertices(pattern: CreasePattern) -> set[int]:
    met = Counter(v for edge in pattern.edges_vertices for v in edge)
    return {v for v, count in met.items() if count == 1}


def _loose_ends(pattern: CreasePattern) -> Iterator[Fault]:
    """The ends of folded creases that no other edge meets, and how far they are from the nearest edge or vertex."""
    loose = _loose_vertices(pattern)
    alone = _folded_alone(pattern)
    for edge, assignment in alone:
        for v in sorted(set(edge) & loose):
            yield _loose_end(pattern, edge, assignment, v)


def _loose_end(pattern: CreasePattern, edge: Edge, assignment: str, vertex: int) -> Fault:
    point = shapely.Point(pattern.vertices_coords[vertex])
    ends_of = np.array(pattern.edges_vertices, int)
    others = ends_of[(ends_of != vertex).all(axis=1)]
    lines = shapely.linestrings(np.array(pattern.vertices_coords, float)[others])
    apart = shapely.distance(lines, point)
    nearest = int(apart.argmin())
    at = shapely.shortest_line(lines[nearest], point).coords[0]
    size = float(apart[nearest])
    place, ends = pattern.place(vertex), (pattern.place(edge[0]), pattern.place(edge[1]))
    detail = (
        f"Crease {edge_words(pattern, edge)} ({assignment}) does not lie between two faces, so it cannot be folded: its end at "
        f"{said(place)} is loose, {size:.4g} ({size / longer_side(pattern):.3g} of the side) from {said(pattern.place_of(at))}."
    )
    return Fault("loose end", detail, (pattern.name(vertex),), (place,), (ends,))


def _without_two_faces(pattern: CreasePattern) -> Iterator[Fault]:
    loose = _loose_vertices(pattern)
    for edge, assignment in _folded_alone(pattern):
        if not set(edge) & loose:
            yield _edge_fault(
                pattern,
                edge,
                f"Crease {edge_words(pattern, edge)} ({assignment}) does not lie between two faces, so it cannot be folded.",
            )


def does_not_close(flat: FlatFaces, closing: float) -> Iterator[Fault]:
    """Why the faces cannot all lie flat without tearing."""
    pattern = flat.pattern
    for face in flat.loose:
        cycle = pattern.cycles[face]
        names, places = [pattern.name(v) for v in cycle], tuple(pattern.place(v) for v in cycle)
        yield Fault(
            "not joined",
            f"The face {names} with corners {', '.join(map(said, places))} is not joined to the rest, so this is more than one "
            "sheet.",
            tuple(names),
            places,
            tuple(zip(places, (*places[1:], places[0]), strict=True)),
        )
    if flat.odd is not None:
        yield Fault(
            "not closed",
            f"Around vertex {pattern.name(flat.odd)} at {said(pattern.place(flat.odd))} an odd number of creases is folded, so "
            "faces meet wrong side up.",
            (pattern.name(flat.odd),),
            (pattern.place(flat.odd),),
        )
    if flat.spread > closing:
        yield Fault(
            "not closed",
            f"The faces do not close up: folded, they are {flat.spread:.3g} of the sheet's side apart at vertex "
            f"{pattern.name(flat.worst)} at {said(pattern.place(flat.worst))} (allowed {closing:g}).",
            (pattern.name(flat.worst),),
            (pattern.place(flat.worst),),
        )
