"""Validators of a folded sheet. They share no code with the folding functions: only the record's fields are read."""

from folding_server.simulator.paper import Paper
from folding_server.simulator.validity.folded_form import (
    agreement_violations,
    assignment_violations,
    isometry_violations,
    vertex_violations,
)
from folding_server.simulator.validity.layers import crossing_violations
from folding_server.simulator.validity.measures import SLACK, measure
from folding_server.simulator.validity.sheet import (
    area_violations,
    planar_violations,
    record_violations,
    tiling_violations,
)
from folding_server.simulator.validity.violation import Kind, Violation

__all__ = ["SLACK", "Kind", "Violation", "violations"]


def violations(paper: Paper) -> list[Violation]:
    """Everything that makes a paper impossible; empty if it is a valid flat-folded sheet.

    A record that does not hang together, or a face that is stretched, is reported alone, since nothing else can be
    measured on it. Tolerances are ``measures.EXACT`` on the sheet and ``measures.SLACK`` on the folded paper.
    """
    found = [*record_violations(paper)] or [*isometry_violations(paper)]
    if found:
        return found
    sheet = measure(paper)
    found = [*area_violations(sheet), *planar_violations(sheet), *tiling_violations(sheet)]
    if found:
        return found
    return [
        *agreement_violations(sheet),
        *assignment_violations(sheet),
        *vertex_violations(sheet),
        *crossing_violations(sheet),
    ]
