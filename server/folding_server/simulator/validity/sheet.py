"""The unfolded sheet: a sound record, area, a planar crease pattern that tiles the sheet."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import shapely

from folding_server.arrays import Floats
from folding_server.simulator.paper import Paper
from folding_server.simulator.validity.measures import EXACT, EdgeKey, Measured, signed_area
from folding_server.simulator.validity.violation import Violation, listed


def record_violations(paper: Paper) -> Iterator[Violation]:
    """Whether the record hangs together: known vertices, a motion for each face, each face once in the stack."""
    for face, cycle in paper.faces.items():
        unknown = [v for v in cycle if v not in paper.vertices_coords]
        if unknown:
            yield Violation("record", f"Face {face} has unknown vertices {listed(unknown)}.", (face,))
        if len(cycle) < 3 or len(set(cycle)) < len(cycle):
            yield Violation("record", f"Face {face} is no polygon: its boundary is {list(cycle)}.", (face,))
    if set(paper.isometries) != set(paper.faces):
        odd = tuple(sorted(set(paper.isometries) ^ set(paper.faces)))
        yield Violation("record", f"Faces {listed(odd)} are not both faces and moved by a motion.", odd)
    if Counter(paper.order) != Counter(paper.faces.keys()):
        odd = tuple(sorted(set(paper.order) ^ set(paper.faces)))
        yield Violation(
            "record", f"The stack does not list every face once; look at faces {listed(odd)}.", odd
        )
    idle = tuple(sorted(set(paper.vertices_coords) - {v for cycle in paper.faces.values() for v in cycle}))
    if idle:
        yield Violation("record", f"Vertices {listed(idle)} are on no face.", vertices=idle)


def area_violations(sheet: Measured) -> Iterator[Violation]:
    """Whether every face has area, all run the same way round, are convex, and add up to the sheet."""
    areas = {face: signed_area(outline) for face, outline in sheet.flat.items()}
    way = np.sign(sum(areas.values()))
    for face, area in areas.items():
        if way * area <= 0:
            yield Violation(
                "area", f"Face {face} has no area or runs the wrong way round ({area:.3g}).", (face,)
            )
        if _deepest_dent(sheet.flat[face] * [way, 1.0]) > EXACT:
            yield Violation("area", f"Face {face} is not convex.", (face,))
    width, height = sheet.paper.sheet
    total = abs(sum(areas.values()))
    if abs(total - width * height) > EXACT:
        yield Violation("area", f"The faces cover {total:.9f} instead of {width * height:.9f}.")


def _deepest_dent(outline: Floats) -> float:
    """How far a corner of a counter-clockwise outline is pushed inwards of its neighbours' chord, 0 if convex."""
    ahead, behind = np.roll(outline, -1, axis=0), np.roll(outline, 1, axis=0)
    chord, arm = ahead - behind, outline - behind
    length = np.maximum(np.hypot(*chord.T), EXACT)
    return float(np.max((chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / length, initial=0.0))


def tiling_violations(sheet: Measured) -> Iterator[Violation]:
    """Whether the faces tile the sheet.

    Faces that all run the same way round, meet in pairs along their inner edges and leave exactly the sheet's outline
    as single edges wind once round every point of the sheet: they cover it without gap or overlap.
    """
    way: dict[EdgeKey, int] = {}
    for face, cycle in sheet.paper.faces.items():
        for u, v in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            if (u, v) in way:
                faces = (way[u, v], face)
                yield Violation(
                    "tiling", f"Faces {listed(faces)} lie on the same side of edge {u}-{v}.", faces, ((u, v),)
                )
            way[u, v] = face
    yield from _outline_violations(sheet)


def _outline_violations(sheet: Measured) -> Iterator[Violation]:
    width, height = sheet.paper.sheet
    outline = shapely.linearrings([(0, 0), (width, 0), (width, height), (0, height)])
    single = [edge for edge, beside in sheet.edges.items() if len(beside) == 1]
    ends = np.array(
        [[sheet.paper.vertices_coords[u], sheet.paper.vertices_coords[v]] for u, v in single]
    ).reshape(-1, 2, 2)
    probes = np.concatenate([ends, ends.mean(axis=1, keepdims=True)], axis=1)
    away = shapely.distance(shapely.points(probes), outline).max(axis=1)
    for index in np.flatnonzero(away > EXACT):
        edge = single[index]
        yield Violation(
            "tiling",
            f"Edge {edge[0]}-{edge[1]} has one face but is not on the sheet's outline.",
            sheet.edges[edge],
            (edge,),
        )
    length = float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum())
    if abs(length - 2 * (width + height)) > EXACT:
        yield Violation("tiling", f"The outline is {length:.9f} long instead of {2 * (width + height):.9f}.")


def planar_violations(sheet: Measured) -> Iterator[Violation]:
    """Whether edges of the crease pattern meet in common vertices only, and at most two faces share an edge."""
    for edge, beside in sheet.edges.items():
        if len(beside) > 2:
            yield Violation(
                "planar", f"Edge {edge[0]}-{edge[1]} lies between {len(beside)} faces.", beside, (edge,)
            )
    edges = list(sheet.edges)
    segments = shapely.linestrings(
        [[sheet.paper.vertices_coords[u], sheet.paper.vertices_coords[v]] for u, v in edges]
    )
    for first, second in shapely.STRtree(segments).query(segments, predicate="intersects").T:
        if first < second and not set(edges[first]) & set(edges[second]):
            yield Violation(
                "planar",
                f"Edges {edges[first]} and {edges[second]} meet outside their vertices.",
                edges=(edges[first], edges[second]),
            )
    parts = len(sheet.corners) - len(edges) + len(sheet.paper.faces)
    if parts != 1:
        yield Violation("planar", f"The crease pattern is not one disc: vertices - edges + faces is {parts}.")
