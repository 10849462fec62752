"""Measuring a plan on the fine view of a photo."""

from dataclasses import replace

from folding_server.geometry.similarity import Similarity, turned_between
from folding_server.vision.registration.alignment import Freedom, align
from folding_server.vision.registration.scene import Views, face_stack
from folding_server.vision.solver.inner_edges import InnerLines, inner_edge_agreement
from folding_server.vision.solver.plan import FREE_TURN, Plan, scale_change


def measured(plan: Plan, views: Views, last: Similarity) -> Plan:
    """A plan with its motion, agreement and lines as the fine view has them; ``last`` is the motion before."""
    freedom = Freedom(shift=0.01, turn=1.0, scale=0.01, halvings=3)
    settled = align(face_stack(plan.paper), views.fine, plan.motion, freedom)
    lines = inner_edge_agreement(plan.paper, views.fine, settled.motion)
    return replace(plan, motion=settled.motion, agreement=settled.agreement).noting(
        **scale_change(settled.motion.scale / last.scale, views.handheld),
        drift_turn=max(0.0, turned_between(last, settled.motion) - FREE_TURN),
        inner_lines=lines.contradiction,
        **_under_own_camera(plan, views, settled.motion, lines),
    )


def _under_own_camera(plan: Plan, views: Views, motion: Similarity, lines: InnerLines) -> dict[str, float]:
    """What counts besides where the camera is free and outlines say less."""
    if not views.own_camera:
        return {}
    drawn = views.fine.draw(face_stack(plan.paper), motion)
    return {"own_camera_lines_shown": lines.shown, "own_camera_residual": views.fine.residual_of(drawn)}
