"""Judging hypotheses of one photo that was framed anew: each under the camera that its outline tells, seen straight from above."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, log

import numpy as np
from folding_schemas.actions import Flip, Rotate

from folding_server.geometry.isometry import IDENTITY, turn
from folding_server.simulator import apply
from folding_server.simulator.paper import Paper
from folding_server.vision.evidence import Evidence
from folding_server.vision.pose_estimation.border_fitting import Fitted, paper_extent
from folding_server.vision.pose_estimation.crease_fitting import (
    SCANS,
    CreaseFit,
    fitted_with_crease,
    left_open,
)
from folding_server.vision.pose_estimation.estimate import (
    PoseEstimate,
    SeenFaces,
    camera_evidence,
    estimates,
    roll_evidence,
    same_sight,
    seen_faces,
)
from folding_server.vision.pose_estimation.picture_view import PictureView
from folding_server.vision.pose_estimation.pinhole import PinholeCamera, only_moved, projected, upright_camera
from folding_server.vision.registration.alignment import Freedom, align
from folding_server.vision.registration.scene import FaceStack, Views, face_stack
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.solver.creases import MovingCrease
from folding_server.vision.solver.fold_search import Effort, FoldFound, FoldSearch
from folding_server.vision.solver.hypotheses import Hypothesis
from folding_server.vision.solver.inner_edges import inner_edge_agreement
from folding_server.vision.solver.measuring import measured
from folding_server.vision.solver.photo_views import views_under
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.realise import realise
from folding_server.vision.solver.single_folds import as_plans
from folding_server.vision.solver.transition import COMPOUND_BELOW, explain
from folding_server.vision.solver.whole_moves import centered

HYPOTHESES_JUDGED = 6
"""Hypotheses that are judged as plans, the best by their outlines."""
FOLDS_REFINED, FULLY_EXPLAINED = 2, 0.995
"""So many folds of those are refined, where their line explains less than the second."""
CONTRADICTED = 0.3
"""Lines inside the paper that contradict the best plan so much decide where a crease is: of the
right first plans of ten programs at level 4, seed 41, 84 of 100 have less (``evidence_collection.py``).
"""
WHOLE_MOVES = ("none", "flip", "unfold")
"""Classes that are fitted and judged always: very many folds look nearly like each of them."""
FAR_WORSE = 0.02
"""Hypotheses whose outlines agree worse than the best by more are not."""
CAMERA_ERROR = Freedom(shift=0.02, turn=1.0, scale=0.02, halvings=4)
"""How far a fitted camera may be wrong: by 0.8 % of the size where that was looked up."""
LEAST_TURN = 20.0
"""Degrees by which the model must be turned in the photo, by a round angle, for people to call it a rotation."""
HALF_TURNED = 90.0
"""Degrees from which a model that was flipped seems turned so far that it was flipped about the other axis."""
WITHOUT_PHOTO: dict[str, Evidence] = {
    "none": Evidence(nothing_happened=1),
    "flip": Evidence(flips=1),
    "fold": Evidence(folds=1),
    "unfold": Evidence(unfolds=1),
    "compound": Evidence(unfolds=2),
}
"""What the action of a hypothesis says while hypotheses are chosen."""
AGAINST = {name: -evidence.score for name, evidence in WITHOUT_PHOTO.items()}
"""What that costs, in shares of the paper."""
PLAN_WORDS = {
    "none": "nothing changed but the camera",
    "flip": "the model was turned over",
    "fold": "a flap was folded over",
    "unfold": "a crease was unfolded",
    "compound": "two creases were folded or unfolded",
    "rotate": "the model was turned",
}
ROUND_TURNS = (45.0, 12.0)
"""Turns within the second of a multiple of the first are meant to be it, in degrees."""


@dataclass(frozen=True)
class Explained:
    """What came of some hypotheses: ``plans``, the ``likeliest`` camera, and folds that are ``undecided``: their outlines explain the
    photo, and lines inside the paper contradict them.
    """

    plans: tuple[Plan, ...]
    likeliest: PoseEstimate
    undecided: tuple[tuple[Hypothesis, PoseEstimate], ...]


@dataclass(frozen=True)
class HypothesisJudge:
    """One transition to a photo that was framed anew; ``known`` is the camera of the photo before, with ``paper``."""

    paper: Paper
    observer: SequenceObserver
    view: PictureView
    frame: int
    known: PoseEstimate | None

    @property
    def before(self) -> PinholeCamera | None:
        """The camera of the photo before, if it is known."""
        return self.known.camera if self.known else None

    @cached_property
    def grown(self) -> float:
        """How much larger the paper is in this picture than in that of the photo before, as a natural logarithm; 0 if that is not known."""
        if self.known is None:
            return 0.0
        corners = np.array([p for outline in face_stack(self.paper).outlines for p in outline])
        before = float(np.ptp(projected(self.known.camera.homography, corners), axis=0).max())
        return log(paper_extent(self.view.scene) / before)

    def likely(self, tried: Sequence[Hypothesis]) -> list[PoseEstimate]:
        """The cameras under which the photo may show what hypotheses make of the paper, the most valuable first."""
        prior = [AGAINST[h.action_class] for h in tried]
        whole = [i for i, h in enumerate(tried) if h.action_class in WHOLE_MOVES]
        found = estimates([h.stack for h in tried], self.view, self.before, prior, whole, self.grown)
        if self.observer.stands(self.frame):
            upright = upright_camera(self.observer.pose, self.view.frame)
            found = [e for e in found if only_moved(e.camera, upright)]
        return _distinct(found, tried)

    def explained(self, tried: Sequence[Hypothesis], found: Sequence[PoseEstimate]) -> Explained:
        """The hypotheses found as plans, the likeliest camera, and folds of which lines have still to say where they are."""
        tested = [
            (plan, estimate) for estimate in found for plan in self.plans(tried[estimate.index], estimate)
        ]
        plans = [plan for plan, _ in tested]
        folds = [e for e in found if tried[e.index].moving and e.agreement < FULLY_EXPLAINED]
        for estimate in folds[:FOLDS_REFINED]:
            plans += self.refined(tried[estimate.index], estimate)
        best = max(plans, key=lambda plan: plan.score, default=None)
        left = best and best.agreement >= COMPOUND_BELOW and best.noted.inner_lines > CONTRADICTED
        undecided = [(tried[e.index], e) for e in folds[:FOLDS_REFINED]] if left else []
        likeliest = max(tested, key=lambda pair: pair[0].score)[1] if tested else found[0]
        return Explained(tuple(plans), likeliest, tuple(undecided))

    def views(self, camera: PinholeCamera, stack: FaceStack) -> Views:
        """The photo from straight above."""
        expected = self.known.agreement if self.known else 1.0
        return views_under(camera, self.view, stack, self.observer, self.frame, expected)

    def plans(self, hypothesis: Hypothesis, estimate: PoseEstimate) -> Iterator[Plan]:
        """A hypothesis as plans, measured under its camera.

        The better of two agreements counts, in the picture and from above: where a straight side falls between two rows of
        pixels is chance, and worth up to 0.9 % of a small model.
        """
        views = self.views(estimate.camera, hypothesis.stack)
        for actions, after in hypothesis.ways():
            plan = Plan(
                actions,
                hypothesis.action_class,
                after,
                IDENTITY,
                estimate.agreement,
                PLAN_WORDS[hypothesis.action_class],
            ).noting(free_line=float(not hypothesis.constructed))
            plan = _settled(_under(plan, estimate.evidence), views)
            plan = replace(plan, agreement=max(plan.agreement, estimate.agreement))
            yield plan
            if hypothesis.action_class == "none":
                yield from self._turned(plan, estimate, views)
            if hypothesis.action_class == "flip":
                yield from self._flipped_otherwise(plan, estimate, views)

    def refined(self, hypothesis: Hypothesis, estimate: PoseEstimate) -> Iterator[Plan]:
        """Folds along lines near that of a hypothesis: found together with the camera, then below the pixel under it."""
        if hypothesis.moving is not None:
            crease = MovingCrease(self.paper, hypothesis.moving)
            fit = fitted_with_crease(crease.folded, self.view.scene, estimate.camera)
            search = FoldSearch(self.paper, self._views_of(crease, fit), (), Effort(), IDENTITY.scale)
            yield from self._made(crease, fit, search.near(self._found(crease, fit)))

    def decided_by_lines(self, hypothesis: Hypothesis, estimate: PoseEstimate) -> Iterator[Plan]:
        """The fold near that of a hypothesis of which the lines inside the paper say most, where its outline leaves open which it is."""
        if hypothesis.moving is None:
            return
        crease = MovingCrease(self.paper, hypothesis.moving)
        best = CreaseFit((0.0, 0.0), Fitted(estimate.camera, estimate.agreement))
        for reach in SCANS:
            places = left_open(crease.folded, self.view.scene, best, reach)
            best = max(places, key=lambda fit: self._worth(crease, fit))
        yield from self._made(crease, best, [self._found(crease, best)])

    def _worth(self, crease: MovingCrease, fit: CreaseFit) -> float:
        """What speaks for a place of a crease: agreement, the camera, and the lines inside the paper."""
        made = realise(self.paper, crease.moved(fit.ends), exact=False)
        if not made:
            return 0.0
        (_, after), *_ = made
        lines = inner_edge_agreement(after, self._views_of(crease, fit).fine, IDENTITY).contradiction
        return fit.fitted.agreement + replace(self._evidence(fit), own_camera_inner_lines=lines).score

    def _evidence(self, fit: CreaseFit) -> Evidence:
        """What speaks against the camera that was fitted with a crease."""
        return camera_evidence(fit.fitted.camera, self.before, self.grown)

    def _views_of(self, crease: MovingCrease, fit: CreaseFit) -> Views:
        """The photo under the camera that was fitted with a crease."""
        return self.views(fit.fitted.camera, crease.folded(fit.ends))

    def _found(self, crease: MovingCrease, fit: CreaseFit) -> FoldFound:
        return FoldFound(crease.moved(fit.ends), IDENTITY, fit.fitted.agreement)

    def _made(self, crease: MovingCrease, fit: CreaseFit, folds: Sequence[FoldFound]) -> Iterator[Plan]:
        """Folds as plans under the camera that was fitted with a crease."""
        evidence, views = self._evidence(fit), self._views_of(crease, fit)
        for fold in folds:
            for plan in as_plans([fold], self.paper, views, fold.motion):
                yield _under(plan, evidence)

    def _turned(self, plan: Plan, estimate: PoseEstimate, views: Views) -> Iterator[Plan]:
        """Nothing but a turn against the photo before, if people would call it a rotation."""
        angle = self._angle(estimate)
        step, reach = ROUND_TURNS
        nearest = round(angle / step) * step
        if abs(angle) < LEAST_TURN:
            return
        action = Rotate(angle=nearest if abs(nearest - angle) <= reach else float(round(angle)))
        after = apply(self.paper, action)
        stack = face_stack(after)
        start = centered(stack, views.coarse, turn(-action.angle, stack.center))
        turned = replace(
            plan,
            actions=(action,),
            action_class="rotate",
            paper=after,
            motion=start,
            explanation=PLAN_WORDS["rotate"],
        ).noting(roll=roll_evidence(angle - action.angle), own_camera_rotation=1.0)
        yield measured(turned, views, start)

    def _angle(self, estimate: PoseEstimate) -> float:
        """How far a camera sees the model turned against the photo before, in degrees from -180 to 180; 0 if that is not known."""
        if self.known is None:
            return 0.0
        return (degrees(self.known.camera.roll - estimate.camera.roll) + 180) % 360 - 180

    def _flipped_otherwise(self, plan: Plan, estimate: PoseEstimate, views: Views) -> Iterator[Plan]:
        """The model flipped about the x axis, if the photo shows it turned less so than about the y axis."""
        angle = self._angle(estimate)
        if abs(angle) <= HALF_TURNED:
            return
        action = Flip(axis="x")
        after = apply(self.paper, action)
        stack = face_stack(after)
        start = centered(stack, views.coarse, turn(-180.0, stack.center))
        flipped = replace(plan, actions=(action,), paper=after, motion=start).noting(
            roll=roll_evidence(180.0 - abs(angle))
        )
        yield measured(flipped, views, start)

    def searched(self, estimate: PoseEstimate) -> Iterator[Plan]:
        """Plans found under the camera of the best hypothesis, and the best of them under its own."""
        views = self.views(estimate.camera, face_stack(self.paper))
        plans = [_under(p, estimate.evidence) for p in explain(self.paper, IDENTITY, views)]
        best = plans[0]
        for own in estimates([face_stack(best.paper)], self.view, self.before, grown=self.grown)[:1]:
            again = measured(
                _under(replace(best, motion=IDENTITY), own.evidence),
                self.views(own.camera, face_stack(best.paper)),
                IDENTITY,
            )
            plans[0] = max(best, again, key=lambda plan: plan.score)
        yield from plans


def _distinct(found: Sequence[PoseEstimate], tried: Sequence[Hypothesis]) -> list[PoseEstimate]:
    """The best estimates, of those that are one model under other names the first; but a crease unfolded is not called a fold back."""
    kept: list[PoseEstimate] = []
    seen: list[SeenFaces] = []
    for estimate in found:
        if estimate.value < found[0].value - FAR_WORSE:
            break
        faces = seen_faces(tried[estimate.index].stack, estimate.camera)
        twin = next((i for i, other in enumerate(seen) if same_sight(faces, other)), None)
        if twin is None:
            if len(kept) == HYPOTHESES_JUDGED:
                break
            kept.append(estimate)
            seen.append(faces)
        elif (
            tried[estimate.index].action_class == "unfold" and tried[kept[twin].index].action_class == "fold"
        ):
            kept[twin] = estimate
    return [*kept, *_whole_moves(found, tried, kept)]


def _whole_moves(
    found: Sequence[PoseEstimate], tried: Sequence[Hypothesis], kept: Sequence[PoseEstimate]
) -> Iterator[PoseEstimate]:
    """The best estimates of the whole moves that are not among those kept, if they are not far worse."""
    for name in WHOLE_MOVES:
        if all(tried[e.index].action_class != name for e in kept):
            of_class = (e for e in found if tried[e.index].action_class == name)
            best = next(of_class, None)
            if best is not None and best.value >= found[0].value - FAR_WORSE:
                yield best


def _settled(plan: Plan, views: Views) -> Plan:
    """A plan measured under its own camera, of which the outline at a coarser look told place and size to a hundredth."""
    found = align(face_stack(plan.paper), views.fine, plan.motion, CAMERA_ERROR)
    return measured(replace(plan, motion=found.motion), views, found.motion)


def _under(plan: Plan, camera: Evidence) -> Plan:
    """A plan with what speaks against its camera."""
    return plan.noting(
        tilt=camera.tilt,
        steep_tilt=camera.steep_tilt,
        zoom=camera.zoom,
        nearness=camera.nearness,
        roll=camera.roll,
        own_camera_free_line=plan.noted.free_line,
    )
