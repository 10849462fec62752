"""Compilation validity (paper, section "Metrics"): whether a stated model is a flat-folded square sheet."""

from collections.abc import Iterator
from math import dist

import networkx as nx

from folding_server.geometry.convex import area
from folding_server.interchange.flat_motions import best_motion
from folding_server.measuring.stated_model import StatedModel
from folding_server.simulator.foldability import CreasePattern, FoldabilityReport, check_pattern
from folding_server.simulator.foldability.report import CLOSING

UNIT_SHEET = (1.0, 1.0)
"""Width and height of the sheet of every run."""


def compiled(model: StatedModel, sheet: tuple[float, float] = UNIT_SHEET) -> FoldabilityReport:
    """Whether the pattern is one planar piece that covers the sheet (width and height), closes up when folded and has an order of its
    layers that agrees with its letters, and whether every face keeps its shape in the folded form that is stated.
    The reason says what fails first.
    """
    problem = next(_misfits(model, sheet), None)
    if problem is not None:
        return FoldabilityReport(foldable=False, reason=problem)
    return check_pattern(model.pattern, cap=1)


def _misfits(model: StatedModel, sheet: tuple[float, float]) -> Iterator[str]:
    pattern = model.pattern
    pieces = nx.number_connected_components(nx.Graph(pattern.edges_vertices))
    if pieces != 1:
        yield f"The crease pattern is in {pieces} pieces that no edge joins."
    yield from _uncovered(pattern, *sheet)
    if model.folded_coords is None:
        return
    for i, cycle in enumerate(pattern.cycles):
        flat = [pattern.vertices_coords[v] for v in cycle]
        lies = [model.folded_coords[v] for v in cycle]
        motion = best_motion(flat, lies)
        worst = max(dist(motion(p), q) for p, q in zip(flat, lies, strict=True))
        if worst > CLOSING:
            yield f"Face {i} does not keep its shape: folded, a corner is out by {worst:.3g} of the sheet's side."


def _uncovered(pattern: CreasePattern, width: float, height: float) -> Iterator[str]:
    """Whether the faces cover the sheet and nothing else."""
    xs, ys = zip(*pattern.vertices_coords, strict=True)
    box = min(xs), min(ys), max(xs), max(ys)
    if any(abs(found - wanted) > CLOSING for found, wanted in zip(box, (0, 0, width, height), strict=True)):
        yield (
            f"The crease pattern reaches from ({box[0]:.4g}, {box[1]:.4g}) to ({box[2]:.4g}, {box[3]:.4g}), not from (0, 0) to "
            f"({width:.4g}, {height:.4g})."
        )
    covered = sum(abs(area([pattern.vertices_coords[v] for v in cycle])) for cycle in pattern.cycles)
    if abs(covered - width * height) > 2 * CLOSING:
        yield f"The faces cover an area of {covered:.4g}, not of {width * height:.4g}, that of the sheet."
