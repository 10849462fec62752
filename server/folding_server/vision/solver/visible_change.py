"""What speaks against a plan besides the photo: that it shows nothing, or creases paper where nobody would."""

from collections.abc import Sequence
from math import dist

from folding_server.geometry.convex import area
from folding_server.geometry.line import Point
from folding_server.simulator.paper import Paper
from folding_server.simulator.state_diff import origins
from folding_server.vision.solver.plan import Plan

VISIBLE = 0.003
"""How much better than nothing a fold, an unfolding or a turn must look to count as seen for sure."""
LONG, HAIR = 0.2, 0.012
"""Faces longer than the first and narrower than the second (sheet units, in the mean) come of creases beside others."""


def against_nothing(plan: Plan, nothing: Plan) -> Plan:
    """A plan, marked with how far the photo shows no more of its fold, or of its turn, than ``nothing`` does, and with
    whether it makes new creases and cuts a sliver off a face.
    """
    gain = max(plan.agreement - nothing.agreement, plan.looks - nothing.looks) + nothing.drift - plan.drift
    hidden = min(1.0, max(0.0, 1.0 - gain / VISIBLE))
    before, after = nothing.paper, plan.paper
    fresh = len(after.faces) > len(before.faces)
    return plan.noting(
        unseen_fold=hidden if plan.creases and not plan.noted.explained_change else 0.0,
        unseen_turn=hidden if plan.action_class == "rotate" else 0.0,
        new_crease=float(fresh),
        sliver=float(fresh and not plan.noted.narrow_strip and _makes_sliver(before, after)),
    )


def _makes_sliver(before: Paper, after: Paper) -> bool:
    """Whether a long sliver is cut off a face."""
    slivers = [face for face in after.faces if _is_sliver(after.sheet_polygon(face))]
    if not slivers:
        return False
    cut_from = origins(before, after)
    return any(not _is_sliver(before.sheet_polygon(cut_from[face])) for face in slivers)


def _is_sliver(outline: Sequence[Point]) -> bool:
    """Whether a face is long and hardly has any width."""
    length = max(dist(p, q) for p in outline for q in outline)
    return length > LONG and abs(area(outline)) < HAIR * length
