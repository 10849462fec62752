"""All that evaluation is told of a state."""

from folding_schemas.state_measures import StateMeasures

from folding_server.geometry.line import Point
from folding_server.interchange.fold_format import fold_document
from folding_server.measuring.compiling import UNIT_SHEET, compiled
from folding_server.measuring.constraint_counts import NO_CONSTRAINTS, constraint_counts, locally_flat_share
from folding_server.measuring.stated_model import StatedModel, mirrored_faces, stated_model
from folding_server.simulator import Paper
from folding_server.simulator.foldability import FoldabilityReport
from folding_server.simulator.foldability.equations import FacePair
from folding_server.simulator.foldability.flat_faces import FlatFaces, lay_flat

DECIMALS = 9
"""Of the coordinates that are told: far below the tolerance, and the same on every machine."""


def measured_paper(paper: Paper) -> StateMeasures:
    """What is measured of a paper."""
    return measured_model(stated_model(fold_document(paper)), paper.sheet)


def measured_model(model: StatedModel, sheet: tuple[float, float] = UNIT_SHEET) -> StateMeasures:
    """What is measured of a stated model, folded of a sheet of this width and height. Where it says nothing of how it lies folded, it lies as its first face does on
    the sheet, its layers in an order that agrees with its letters.
    """
    pattern, report = model.pattern, compiled(model, sheet)
    flat = lay_flat(pattern) if report.foldable else None
    folded = model.folded_coords or (None if flat is None else _laid(flat))
    return StateMeasures(
        compiles=report.foldable,
        problem="" if report.foldable else report.reason,
        vertices_coords=[_rounded(point) for point in pattern.vertices_coords],
        folded_coords=None if folded is None else [_rounded(point) for point in folded],
        edges_vertices=list(pattern.edges_vertices),
        edges_assignment=list(pattern.edges_assignment),
        faces_vertices=[list(cycle) for cycle in pattern.cycles],
        over=sorted(_orders(model, report)),
        constraints=NO_CONSTRAINTS if flat is None else constraint_counts(flat),
        locally_flat=locally_flat_share(pattern),
    )


def _laid(flat: FlatFaces) -> list[Point]:
    """Where each vertex lies when the pattern is folded, the first face as on the sheet."""
    laid: dict[int, Point] = {}
    for cycle, outline in zip(flat.pattern.cycles, flat.outlines, strict=True):
        laid |= {v: (float(x), float(y)) for v, (x, y) in zip(cycle, outline, strict=True)}
    return [laid.get(v, point) for v, point in enumerate(flat.pattern.vertices_coords)]


def _orders(model: StatedModel, report: FoldabilityReport) -> set[FacePair]:
    """The pairs (upper, lower): as stated, else as the check found one order of the layers."""
    if model.over is not None:
        return set(model.over)
    turned = model.folded_coords is not None and mirrored_faces(model.pattern, model.folded_coords)[0]
    return {(low, high) if turned else (high, low) for low, high in report.lying}


def _rounded(point: Point) -> Point:
    return round(point[0], DECIMALS) + 0.0, round(point[1], DECIMALS) + 0.0
