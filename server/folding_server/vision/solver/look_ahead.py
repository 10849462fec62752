"""Plans that one photo cannot tell apart are told apart by those that follow: a beam as wide as the tie, as deep as it must be."""

from collections.abc import Callable, Sequence

from folding_server.simulator.paper import Paper
from folding_server.vision.any_camera import ANOTHER_BELOW
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.same_model import same_model
from folding_server.vision.solver.transition import COMPOUND_BELOW

TIE, MOST_TIED = 0.003, 4
"""Plans that score less than the best by at most the first are as good as it, if they are among so many."""
TIE_REFRAMED = 0.016
"""The same under a camera of its own: with its freedom more plans look alike, also those of one class."""
TIE_NOTHING = 0.012
"""The same where the best is that nothing happened: photos are chosen because something did, and what a hand hides the next may show.
"""
MOST_AHEAD = 3
"""Photos that are looked at beyond the one in question."""
DECIDED = 0.01
"""Shares of the paper by which one plan must be ahead of another for the other not to be followed any further."""
STRIPS_FORGIVEN = 0.7
"""Part of what is unexplained in strips narrower than WIDEST_STRIP that is not held against where a plan leads: creases and a sheet that
are 0.01 off make strips of 0.007 of the paper, more than wrong plans differ by.
"""
MANY_FACES = 24
"""From papers of more faces it takes too long to look ahead."""

Explain = Callable[[Paper, int], Plan]
"""The best explanation of a photo, by its number, from a paper."""


def tied_plans(plans: Sequence[Plan]) -> list[Plan]:
    """The plans as good as the best by this photo: all that only move the whole, and of others the best of each class. None
    if even the best is not the explanation.
    """
    if plans[0].agreement < ANOTHER_BELOW:
        return []
    tie = TIE_NOTHING if plans[0].action_class == "none" else TIE
    tie = TIE_REFRAMED if plans[0].noted.own_camera else tie
    tied: list[Plan] = []
    for plan in plans:
        alike = plan.creases and any(plan.action_class == other.action_class for other in tied)
        alike = alike and not plan.noted.own_camera
        if plan.score <= plans[0].score - tie or alike:
            continue
        if not any(alike_for_later_photos(plan, other) for other in tied):
            tied.append(plan)
    return tied[:MOST_TIED]


def alike_for_later_photos(plan: Plan, other: Plan) -> bool:
    """Whether two plans lead to one model, which a camera of its own may see from any side."""
    free = bool(plan.noted.own_camera and other.noted.own_camera)
    return same_model(plan.paper, other.paper, turned=free)


def behind(
    plans: Sequence[Plan], frame: int, last_frame: int, explain: Explain, thoroughly: Explain
) -> list[float]:
    """How far each plan for a photo falls behind the best of them, in shares of the paper, when the next photos are explained from
    where it leads, each by its own best explanation: ``thoroughly`` where none of them is explained otherwise. All 0 if there is
    nothing to look at.
    """
    papers, lost = [plan.beside or plan.paper for plan in plans], [0.0] * len(plans)
    followed = list(range(len(plans)))
    for ahead in range(frame + 1, min(frame + MOST_AHEAD, last_frame) + 1):
        if len(followed) < 2 or any(len(papers[i].faces) > MANY_FACES for i in followed):
            break
        found = {i: explain(papers[i], ahead) for i in followed}
        if max(plan.agreement for plan in found.values()) < COMPOUND_BELOW:
            found = {i: thoroughly(papers[i], ahead) for i in followed}
        best = max(_foreseen(plan) - lost[i] for i, plan in found.items())
        for i, plan in found.items():
            papers[i], lost[i] = plan.beside or plan.paper, best - (_foreseen(plan) - lost[i])
        followed = [i for i in followed if lost[i] < DECIDED]
    return lost


def _foreseen(plan: Plan) -> float:
    """The score of a plan that begins where another one led, most of the strips along its borders forgiven: how precisely that one's
    creases and the sheet itself were taken says nothing of whether it was right.
    """
    if not plan.noted.own_camera:
        return plan.score
    strips = max(0.0, 1.0 - plan.agreement - plan.noted.own_camera_residual)
    return plan.score + STRIPS_FORGIVEN * strips
