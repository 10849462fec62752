"""The folded sheet: rigid faces that agree along their edges, orientations and edge assignments, vertex conditions."""

from collections.abc import Iterator
from math import atan2, hypot, pi, tau

import numpy as np

from folding_server.simulator.paper import Paper
from folding_server.simulator.validity.measures import EXACT, SLACK, TILT, EdgeKey, Measured
from folding_server.simulator.validity.violation import Violation, listed

MOUNTAIN_OR_VALLEY = frozenset("MV")


def isometry_violations(paper: Paper) -> Iterator[Violation]:
    """Whether every face moves as a rigid body, turned over or not."""
    for face, motion in paper.isometries.items():
        a, b, c, d, _, _ = motion
        error = np.abs(np.array([a * a + c * c - 1, b * b + d * d - 1, a * b + c * d])).max()
        if not (np.isfinite(motion).all() and error <= EXACT):
            yield Violation(
                "isometry", f"Face {face} is stretched: its motion is off by {error:.3g}.", (face,)
            )


def agreement_violations(sheet: Measured) -> Iterator[Violation]:
    """Whether all faces at a vertex give it the same folded coordinates, to within the slack."""
    for vertex, corners in sheet.corners.items():
        coords = np.array([sheet.folded[face][index] for face, index in corners])
        spread = hypot(*np.ptp(coords, axis=0))
        if spread > SLACK:
            faces = tuple(face for face, _ in corners)
            yield Violation(
                "agreement",
                f"Faces {listed(faces)} disagree by {spread:.3g} on vertex {vertex}.",
                faces,
                vertices=(vertex,),
            )


def assignment_violations(sheet: Measured) -> Iterator[Violation]:
    """Whether the paper's assignments follow from the stack, and orientations from the assignments along any path.

    A crease is a valley if the lower of its two faces shows the front, a mountain if it shows the back.
    """
    given = dict(sheet.paper.edges())
    for edge in sheet.edges:
        expected = assignment(sheet, edge)
        if given.get(edge) != expected:
            yield Violation(
                "letter",
                f"Edge {edge[0]}-{edge[1]} is called {given.get(edge)}; the stack makes it {expected}.",
                sheet.edges[edge],
                (edge,),
            )
    yield from _parity_violations(sheet, given)


def assignment(sheet: Measured, edge: EdgeKey) -> str:
    """The assignment of an edge by the stack and the two orientations."""
    beside = sheet.edges[edge]
    if len(beside) != 2:
        return "B"
    if not sheet.turned(edge):
        return "F"
    lower = min(beside, key=sheet.rank.__getitem__)
    return "M" if sheet.mirrored[lower] else "V"


def _parity_violations(sheet: Measured, assignments: dict[EdgeKey, str]) -> Iterator[Violation]:
    """Walk from face to face counting folded creases; every face must be reached with one parity, its orientation."""
    beside: dict[int, list[tuple[int, EdgeKey]]] = {face: [] for face in sheet.paper.faces}
    for edge in sheet.inner:
        first, second = sheet.edges[edge]
        beside[first].append((second, edge))
        beside[second].append((first, edge))
    start = next(iter(beside))
    parity, queue = {start: sheet.mirrored[start]}, [start]
    while queue:
        face = queue.pop()
        for other, edge in beside[face]:
            reached = parity[face] != (assignments.get(edge) in MOUNTAIN_OR_VALLEY)
            if other not in parity:
                parity[other] = reached
                queue.append(other)
            if parity[other] != reached or reached != sheet.mirrored[other]:
                yield Violation(
                    "parity",
                    f"Face {other} shows the wrong side for the creases that lead to it over "
                    f"edge {edge[0]}-{edge[1]}.",
                    (face, other),
                    (edge,),
                )
    if len(parity) < len(beside):
        lost = tuple(sorted(set(beside) - set(parity)))
        yield Violation("parity", f"No path leads to faces {listed(lost)}.", lost)


def vertex_violations(sheet: Measured) -> Iterator[Violation]:
    """Maekawa and Kawasaki at every vertex inside the sheet that has folded creases."""
    around: dict[int, list[EdgeKey]] = {vertex: [] for vertex in sheet.corners}
    for edge in sheet.edges:
        for vertex in edge:
            around[vertex].append(edge)
    for vertex, edges in around.items():
        if any(len(sheet.edges[edge]) != 2 for edge in edges):
            continue
        creases = [edge for edge in edges if sheet.turned(edge)]
        mountains = sum(assignment(sheet, edge) == "M" for edge in creases)
        difference = 2 * mountains - len(creases)
        if creases and abs(difference) != 2:
            yield Violation(
                "Maekawa",
                f"Vertex {vertex} has {mountains} mountains and {len(creases) - mountains} "
                "valleys; they must differ by two.",
                edges=tuple(creases),
                vertices=(vertex,),
            )
        yield from _kawasaki_violations(sheet, vertex, creases)


def _kawasaki_violations(sheet: Measured, vertex: int, creases: list[EdgeKey]) -> Iterator[Violation]:
    """Alternate angles must add up to half a turn, to within what the tilt turns the shortest crease by."""
    if not creases:
        return
    x, y = sheet.paper.vertices_coords[vertex]
    arms = [sheet.paper.vertices_coords[u if v == vertex else v] for u, v in creases]
    directions = sorted(atan2(v - y, u - x) for u, v in arms)
    angles = np.diff([*directions, directions[0] + tau])
    allowed = EXACT + len(creases) * TILT / min(hypot(u - x, v - y) for u, v in arms)
    error = abs(float(angles[::2].sum()) - pi)
    if len(creases) % 2 or error > allowed:
        yield Violation(
            "Kawasaki",
            f"The alternate angles at vertex {vertex} are off half a turn by {error:.3g}.",
            edges=tuple(creases),
            vertices=(vertex,),
        )
