"""What the other packages found out, as hosts see it."""

from typing import TYPE_CHECKING

from folding_schemas.foldability_results import Foldability, LocalViolation, PatternFault
from folding_schemas.results import (
    Comparison,
    Proposal,
    SeenOutline,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from folding_server.interchange.pattern_files import ReadPattern
    from folding_server.simulator.foldability import Fault, FoldabilityReport
    from folding_server.vision.comparison import Match
    from folding_server.vision.outline import Outline
    from folding_server.vision.seeing import Observation
    from folding_server.vision.solver import Plan

LARGEST_INTEGER = 2**53 - 1
"""The largest number that every reader of JSON keeps exactly."""


def comparison(
    seen: "Observation", match: "Match", outlines: "Sequence[Outline]", warnings: list[str]
) -> Comparison:
    """How well a state explains a photo, whose paper has these ``outlines``."""
    dx, dy, turn = match.alignment.shift
    return Comparison(
        frame=seen.frame,
        verdict=match.verdict,
        agreement=round(match.agreement, 4),
        iou={name: round(value, 4) for name, value in match.iou.items()},
        outline_distance=round(match.outline_distance, 4),
        shift=(round(dx, 4), round(dy, 4), round(turn, 2)),
        discrepancies=match.words,
        outline_worst=round(match.outline_worst, 4),
        lines=round(match.lines, 4),
        confidence=round(seen.paper_confidence, 3),
        outlines=[_outline(outline) for outline in outlines],
        warnings=warnings,
    )


def _outline(outline: "Outline") -> SeenOutline:
    return SeenOutline(
        corners=[(round(x, 3), round(y, 3)) for x, y in outline.corners], hidden=outline.hidden
    )


def proposals(plans: "Sequence[Plan]") -> list[Proposal]:
    """Plans, best first, numbered from 1."""
    return [
        Proposal(
            rank=rank,
            action_class=plan.action_class,
            actions=list(plan.actions),
            agreement=round(plan.agreement, 4),
            score=round(plan.score, 4),
            explanation=plan.explanation,
            evidence={name: round(value, 4) for name, value in plan.evidence.contributions.items()},
        )
        for rank, plan in enumerate(plans, start=1)
    ]


def foldability(report: "FoldabilityReport", read: "ReadPattern | None" = None) -> Foldability:
    """Whether a crease pattern folds flat; ``read`` is the pattern of a file that it is about."""
    return Foldability(
        foldable=report.foldable,
        reason=(read.prefix if read else "") + report.reason,
        violations=[
            LocalViolation(vertex=each.vertex, condition=each.condition, detail=each.detail)
            for each in report.violations
        ],
        states=min(report.states, LARGEST_INTEGER),
        capped=report.capped or report.states > LARGEST_INTEGER,
        exact="" if report.capped else str(report.states),
        faults=[_fault(each) for each in report.faults],
        notes=notes_of(read) if read else [],
        frame=read.frame if read else 1,
    )


def notes_of(read: "ReadPattern") -> list[str]:
    """What was read otherwise than it stands in a file, one sentence each."""
    from folding_server.simulator.foldability import said

    place = read.pattern.place_of
    moved = [
        f"An end at {said(place(end.before))} was joined to {said(place(end.after))}, {end.gap:.3g} of the side away."
        for end in read.pattern.joined
    ]
    return [*moved, *read.pattern.notes]


def _fault(fault: "Fault") -> PatternFault:
    places = [[round(c, 9) + 0.0 for c in place] for place in fault.places]
    return PatternFault(kind=fault.kind, detail=fault.detail, vertices=list(fault.vertices), places=places)
