"""Explaining a photo that was framed anew: what the action was, and where the camera stood, found together.

Every hypothesis is fitted to the photo under a camera of its own, by its outline; those that fit best are then seen
straight from above under that camera, and judged as plans are that a standing camera shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator.paper import Paper
from folding_server.vision.pose_estimation.estimate import PoseEstimate
from folding_server.vision.registration.scene import face_stack
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.solver.hypotheses import Hypothesis, further_hypotheses, hypotheses
from folding_server.vision.solver.hypothesis_judge import CONTRADICTED, HypothesisJudge
from folding_server.vision.solver.lines_beside import with_lines_beside
from folding_server.vision.solver.photo_views import likeliest_view
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.transition import COMPOUND_BELOW
from folding_server.vision.solver.visible_change import against_nothing

DENIED = 0.6
"""Lines inside the paper that contradict the best plan so much say that something else happened."""
PATCH = 0.002
"""Share of the paper from which what is left unexplained in one place is searched for a fold: the tip of a flap."""
USUAL_KEPT = 8
"""Answers to the usual hypotheses that are kept: two for each plan that is followed."""


def explain_reframed(
    paper: Paper, observer: SequenceObserver, frame: int, known: PoseEstimate | None, *, further: bool = True
) -> list[Plan]:
    """Plans that lead from a paper to a photo from any camera, best first; empty if the photo shows no paper. ``known`` is the
    :func:`known_camera` of the photo before; without ``further`` no more than the usual hypotheses are tried.
    """
    tried = _usually(paper, observer, frame, known)
    if further:
        tried = tried.decided()
        tried = tried if enough(tried.plans) else tried.and_then(further_hypotheses(paper)).decided()
    plans = list(tried.plans)
    if tried.likeliest is not None and _leaves_something(plans, further=further):
        judge, best = tried.likeliest
        plans += judge.searched(best)
    return _against_nothing(plans, paper)


@dataclass(frozen=True)
class _Tried:
    """What came of hypotheses for a photo: plans, the likeliest camera with its judge, one for each piece that may be the paper, and
    the folds of which lines have still to say where they are.
    """

    judges: tuple[HypothesisJudge, ...]
    plans: tuple[Plan, ...] = ()
    likeliest: tuple[HypothesisJudge, PoseEstimate] | None = None
    undecided: tuple[tuple[HypothesisJudge, Hypothesis, PoseEstimate], ...] = ()

    def and_then(self, tried: Sequence[Hypothesis]) -> "_Tried":
        """With what comes of more of them."""
        found = [(judge, ways) for judge in self.judges if (ways := judge.likely(tried))]
        if not found:
            return self
        judge, ways = max(found, key=lambda pair: pair[1][0].value)
        new = judge.explained(tried, ways)
        better = self.likeliest is None or new.likeliest.value > self.likeliest[1].value
        return _Tried(
            self.judges,
            (*self.plans, *new.plans),
            (judge, new.likeliest) if better else self.likeliest,
            (*self.undecided, *((judge, *fold) for fold in new.undecided)),
        )

    def decided(self) -> "_Tried":
        """With the undecided folds where lines inside the paper say they are."""
        more = [p for judge, fold, estimate in self.undecided for p in judge.decided_by_lines(fold, estimate)]
        return replace(self, plans=(*self.plans, *more), undecided=())


def _usually(paper: Paper, observer: SequenceObserver, frame: int, known: PoseEstimate | None) -> _Tried:
    """What comes of the usual hypotheses; the last few answers are remembered, for a photo is looked at thoroughly after that."""
    known_tried: Sequence[tuple[Paper, int, _Tried]] = observer.begun
    for known_paper, known_frame, tried in known_tried:
        if (known_frame, known_paper) == (frame, paper):
            return tried
    judges = tuple(HypothesisJudge(paper, observer, view, frame, known) for view in observer.pictures(frame))
    found = _Tried(judges).and_then(hypotheses(paper))
    observer.begun[:] = [*observer.begun[1 - USUAL_KEPT :], (paper, frame, found)]
    return found


def enough(plans: Sequence[Plan]) -> bool:
    """Whether the best plan explains so much that nothing further need be tried: lines inside the paper do not deny it, and it is not
    two unfoldings, beside which two folds would have to be tried.
    """
    best = max(plans, key=lambda plan: plan.score, default=None)
    return (
        best is not None
        and best.agreement >= COMPOUND_BELOW
        and best.action_class != "compound"
        and _denied(best) < DENIED
    )


def nothing_open(plans: Sequence[Plan]) -> bool:
    """Whether plans found without looking any further, best first, are those that would be found so: where none has a camera of its own,
    no more is tried for so much agreement.
    """
    if not any(plan.noted.own_camera for plan in plans):
        return max(plan.agreement for plan in plans) >= COMPOUND_BELOW
    return enough(plans) and _denied(plans[0]) <= CONTRADICTED


def _denied(plan: Plan) -> float:
    """How far lines inside the paper contradict a plan, 0 to 2, before it is weighed and after."""
    return plan.noted.inner_lines + plan.noted.own_camera_inner_lines


def _leaves_something(plans: Sequence[Plan], *, further: bool) -> bool:
    """Whether the best plan leaves a patch of the photo unexplained; or, ``further`` on, too much of it in all."""
    if further and max((p.agreement for p in plans), default=0.0) < COMPOUND_BELOW:
        return True
    return bool(plans) and max(plans, key=lambda plan: plan.score).noted.own_camera_residual > PATCH


def _against_nothing(plans: Sequence[Plan], paper: Paper) -> list[Plan]:
    """Plans as they count beside the one that nothing happened, best first."""
    nothing = next((p for p in plans if p.action_class == "none"), Plan((), "none", paper, IDENTITY, 0.0, ""))
    return with_lines_beside([_weighed(against_nothing(plan, nothing)) for plan in plans])


def _weighed(plan: Plan) -> Plan:
    """A plan as it counts under a free camera: that a fold shows nothing is not known, and lines count otherwise."""
    return plan.noting(
        unseen_fold=0.0,
        inner_lines=0.0,
        own_camera_inner_lines=plan.noted.inner_lines,
        own_camera_new_crease=plan.noted.new_crease,
    )


def known_camera(paper: Paper, observer: SequenceObserver, frame: int) -> PoseEstimate | None:
    """The camera under which a photo shows the paper that it is known to show; None if there is no such photo."""
    found = likeliest_view(face_stack(paper), observer, frame) if frame > 0 else None
    return None if found is None else found[1]
