"""What the other packages found out, as hosts see it."""

from typing import TYPE_CHECKING

from folding_schemas.results import Comparison, Foldability, LocalViolation, Proposal, SeenOutline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from folding_server.simulator.foldability import FoldabilityReport
    from folding_server.vision.comparison import Match
    from folding_server.vision.outline import Outline
    from folding_server.vision.seeing import SeenFrame
    from folding_server.vision.solver import Plan


def comparison(seen: "SeenFrame", match: "Match", outlines: "Sequence[Outline]") -> Comparison:
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
        )
        for rank, plan in enumerate(plans, start=1)
    ]


def foldability(report: "FoldabilityReport") -> Foldability:
    """Whether a crease pattern folds flat."""
    return Foldability(
        foldable=report.foldable,
        reason=report.reason,
        violations=[
            LocalViolation(vertex=each.vertex, condition=each.condition, detail=each.detail)
            for each in report.violations
        ],
        states=report.states,
        capped=report.capped,
    )
