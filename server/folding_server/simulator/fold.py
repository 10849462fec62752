"""The action ``fold``: crease along a line and turn one side over, on top of everything.

Which faces move is DESIGN's rule: start from the seeds, take along every face joined by an edge off the line and every
face that lies over a moving part (paper cannot pass through the paper above it). See paper, section "Simulator".
"""

from dataclasses import replace

from folding_server.errors import ActionRefused
from folding_server.geometry.graph import Edge
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, line_through
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.flat_vertices import DRIFT, torn_vertex, unflat_vertex
from folding_server.simulator.fold_builder import FoldBuilder
from folding_server.simulator.paper import FoldedCrease, Paper
from folding_server.simulator.planes import planes
from folding_server.simulator.vertices import known_vertices


def fold(paper: Paper, edge: Edge, direction: int) -> Paper:
    """Fold along the line through two vertices, the moving side towards the viewer.

    Direction +1 moves the upper side (the right side if the line is vertical), -1 the other. Raises ActionRefused for
    an unknown vertex or direction, two vertices whose folded coordinates are the same, a side without paper, and a fold that would turn the
    whole model over.
    """
    line = fold_line(paper, edge, direction)
    cutting = FoldBuilder(paper, line)
    cutting.move_with(_seeds(paper, edge, direction, cutting))
    if len(cutting.moving) == len(cutting.faces):
        raise ActionRefused(
            f"Folding along [{edge[0]}, {edge[1]}] in direction {direction:+d} would turn the whole model over; "
            "use flip for that, or the other direction."
        )
    folded, creased = _turned_over(paper, cutting, edge)
    _check(folded, creased, edge)
    return folded


def _check(folded: Paper, creased: list[Edge], edge: Edge) -> None:
    """ActionRefused if a vertex at the new creases would not lie flat, or its faces would disagree on its coordinates."""
    blunt = unflat_vertex(folded, creased)
    if blunt is not None:
        raise ActionRefused(
            f"The line through [{edge[0]}, {edge[1]}] runs along an older crease within {TOLERANCE:g} and leaves it at "
            f"vertex {blunt}, where the fold would end inside the paper; fold along that crease or clear of it."
        )
    torn = torn_vertex(folded, creased)
    if torn is not None:
        raise ActionRefused(
            f"The fold through [{edge[0]}, {edge[1]}] would put the layers that meet at vertex {torn} more than {DRIFT:g} "
            "apart, since it passes that vertex where earlier folds just missed it; fold along a line clear of it."
        )


def fold_line(paper: Paper, edge: Edge, direction: int) -> Line:
    """The line through two vertices with its normal to the side that moves; ActionRefused if there is none."""
    known_vertices(paper, edge)
    if direction not in (1, -1):
        raise ActionRefused(
            f"Direction {direction!r} is unknown; give +1 (upper or right side moves) or -1 (the other)."
        )
    u, v = edge
    p, q = paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]
    dx, dy = q[0] - p[0], q[1] - p[1]
    if max(abs(dx), abs(dy)) <= TOLERANCE:
        raise ActionRefused(
            f"Vertices {u} and {v} lie at one place ({p[0]:.4f}, {p[1]:.4f}), so no line is given; "
            "name two vertices at different places."
        )
    line = line_through(p, q)
    vertical = abs(dx) <= TOLERANCE * abs(dy)
    upwards = line.nx > 0 if vertical else line.ny > 0
    if upwards != (direction == 1):
        line = line.opposite()
    return line


def _seeds(paper: Paper, edge: Edge, direction: int, cutting: "FoldBuilder") -> list[int]:
    """The faces that start the moving set: the first rule of three that names any."""
    u, v = edge
    for face in reversed(paper.order):
        cycle = paper.faces[face]
        if u in cycle and v in cycle and cutting.reaches(face):
            return [face]
    crossed = _plane_through(paper, edge, cutting)
    if crossed:
        return crossed
    for face in reversed(paper.order):
        if cutting.straddles(face):
            return [face]
    raise ActionRefused(
        f"The line through [{u}, {v}] has no paper to turn on the side that direction {direction:+d} moves; "
        "use the other direction or other vertices."
    )


def _plane_through(paper: Paper, edge: Edge, cutting: "FoldBuilder") -> list[int]:
    """The faces with area on the moving side of the topmost plane that has both vertices and is crossed by the line."""
    rank = paper.rank
    best: list[int] = []
    for plane in planes(paper):
        corners = {v for face in plane for v in paper.faces[face]}
        sides = {cutting.side[v] for v in corners}
        higher = not best or max(rank[f] for f in plane) > max(rank[f] for f in best)
        if set(edge) <= corners and {1, -1} <= sides and higher:
            best = plane
    touching = [f for f in best if cutting.reaches(f) and cutting.touches(f)]
    return sorted(touching, key=rank.__getitem__)


def _turned_over(paper: Paper, cutting: "FoldBuilder", edge: Edge) -> tuple[Paper, list[Edge]]:
    """The paper with the moving faces mirrored, in reversed order on top, and the edges that turned, put on record."""
    number = paper.folds + 1
    reflection = mirror(cutting.line)
    moving = cutting.moving
    isometries = {f: reflection.after(t) if f in moving else t for f, t in cutting.isometries.items()}
    creases = dict(cutting.creases)
    turned: list[Edge] = []
    for crease, beside in cutting.beside.items():
        if len(beside) == 2 and (beside[0] in moving) != (beside[1] in moving):
            mover = beside[0] if beside[0] in moving else beside[1]
            creases[crease] = FoldedCrease(number, mover, creases.get(crease))
            turned.append(crease)
    stays, turns = cutting.stacks(paper.order)
    folded = replace(
        paper,
        vertices_coords=cutting.vertices_coords,
        faces=cutting.faces,
        isometries=isometries,
        order=(*stays, *reversed(turns)),
        creases=creases,
        folds=number,
        fold_edges={**paper.fold_edges, number: edge},
    )
    return folded, turned
