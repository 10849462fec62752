"""Proposals for the transition to a frame: from photos and a folded paper to ranked plans."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.any_camera import ANOTHER_BELOW, BETTER_BY
from folding_server.vision.motion import movement
from folding_server.vision.pose_estimation.estimate import PoseEstimate
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.solver.look_ahead import alike_for_later_photos, behind, tied_plans
from folding_server.vision.solver.motion_evidence import contradiction, watched_places
from folding_server.vision.solver.photo_views import SeenBefore, seen_before, views_after
from folding_server.vision.solver.plan import Plan, best_first
from folding_server.vision.solver.refinement import Steps, carried_back, refined
from folding_server.vision.solver.reframing import explain_reframed, known_camera, nothing_open
from folding_server.vision.solver.transition import (
    COMPOUND_BELOW,
    EXPLAINED,
    judged,
    pairs_of_actions,
    single_actions,
    worth_pairs,
)

CLEAR_LEAD = 0.004
"""How much better than every plan to another state the best one must score to be called clearly best."""
WELL_EXPLAINED, STILL_EXPLAINED = 0.985, 0.93
"""A paper that explains its own photo so well under the first photo's camera was seen by that; one that explains it less well than the
second by another; and between the two it was if another explains BETTER_BY more.
"""
REMEMBERED = 24
"""Explanations kept: the next photo's are needed again."""


def propose(
    paper: Paper, observer: SequenceObserver, frame: int, count: int = 3, steps: Steps = ()
) -> tuple[Plan, ...]:
    """At most ``count`` plans, best first, that lead from ``paper`` (the state at the frame before) to a frame.

    Plans that this photo cannot tell apart are ranked by how well the next one can be explained from where they lead. With
    the ``steps`` that led to the paper from the flat sheet, one for each photo, the photo is explained from where all
    photos before show its creases. Raises PhotoError if there is no such frame. Deterministic.
    """
    known = refined(steps, observer) if steps and len(steps) == frame - 2 else None
    if known is not None and known.told:
        carried = tuple(
            replace(plan, actions=back[0], paper=back[1])
            for plan in _proposed(known.paper, observer, frame, count)
            if (back := carried_back(plan.actions, known, paper)) is not None
        )
        if carried:
            return carried
    return _proposed(paper, observer, frame, count)


def _proposed(paper: Paper, observer: SequenceObserver, frame: int, count: int) -> tuple[Plan, ...]:
    """:func:`propose` from the paper alone."""
    plans: Sequence[Plan] = explained(paper, observer, frame)
    tied = tied_plans(plans)
    if len(tied) > 1 and len(paper.faces) > 1:
        lost = behind(
            tied,
            frame,
            observer.photos.frame_count,
            lambda after, ahead: explained(after, observer, ahead, pairs=False, further=False)[0],
            lambda after, ahead: explained(after, observer, ahead, pairs=False)[0],
        )
        plans = best_first([plan.noting(look_ahead=_lost(plan, tied, lost)) for plan in plans])
    return tuple(plans[:count])


def _lost(plan: Plan, tied: Sequence[Plan], lost: Sequence[float]) -> float:
    """What was lost by a plan, or by the tied one that leads to the same model; 0 if the next photos were not asked about it."""
    return next(
        (loss for other, loss in zip(tied, lost, strict=True) if alike_for_later_photos(plan, other)), 0.0
    )


def explained(
    paper: Paper, observer: SequenceObserver, frame: int, *, pairs: bool = True, further: bool = True
) -> tuple[Plan, ...]:
    """The plans that this photo alone suggests, best first; the last few are remembered.

    What is tried last takes long, and can be left out: two folds at once without ``pairs``, and under a camera of its own all but
    the usual hypotheses without ``further``.
    """
    plans: tuple[Plan, ...]
    for known_paper, known_frame, with_pairs, with_further, plans in observer.notes:
        if (known_frame, known_paper) == (frame, paper) and (
            (with_pairs >= pairs and with_further >= further) or nothing_open(plans)
        ):
            return plans
    plans = _ranked(paper, observer, frame, pairs=pairs, further=further)
    observer.notes[:] = [*observer.notes[1 - REMEMBERED :], (paper, frame, pairs, further, plans)]
    return plans


def _ranked(
    paper: Paper, observer: SequenceObserver, frame: int, *, pairs: bool, further: bool
) -> tuple[Plan, ...]:
    """Every class of action tried under the first photo's camera, and under any camera where that one explains too little; best first.
    Two folds at once come before another camera if the photo before was seen by the first photo's, else after it.
    """
    before = seen_before(paper, observer, frame)
    camera = cache(lambda: known_camera(paper, observer, frame - 1))
    moved = frame > 2 and _moved(observer, before, camera)
    plans = _framed_anew(paper, observer, frame, camera(), further=further) if moved else []
    if plans and plans[0].agreement >= ANOTHER_BELOW:
        return tuple(_distinct(plans))
    last, views = before.motion, views_after(paper, observer, before)
    standing = single_actions(paper, last, views)
    stood = frame > 2 and not moved
    if pairs and stood and worth_pairs(standing, views):
        standing += pairs_of_actions(standing, paper, last, views)
    lost = ANOTHER_BELOW if observer.stands(frame) else EXPLAINED
    if not moved and _at_its_size(judged(standing)[0]) < lost:
        plans = _framed_anew(paper, observer, frame, camera(), further=further)
    if pairs and not stood and not _explains(plans) and worth_pairs(standing, views):
        standing += pairs_of_actions(standing, paper, last, views)
    standing = _not_contradicted(judged(standing), paper, observer, frame, last)
    return tuple(_distinct(best_first([*plans, *standing])))


def _moved(observer: SequenceObserver, before: SeenBefore, camera: Callable[[], PoseEstimate | None]) -> bool:
    """Whether the photo before a frame was taken by another camera than the first photo; ``camera`` finds the one it may be."""
    if before.agreement >= WELL_EXPLAINED or observer.stands(before.frame):
        return before.agreement < STILL_EXPLAINED
    known = camera()
    return known is not None and known.agreement > before.agreement + BETTER_BY


def _at_its_size(plan: Plan) -> float:
    """The agreement of a plan less what it costs that the sheet looks larger or smaller: then the camera came nearer or went away."""
    return plan.agreement + plan.evidence.of("scale_change_standing", "scale_change_held")


def _explains(plans: Sequence[Plan]) -> bool:
    """Whether the best plan explains so much that nothing else need be tried."""
    return bool(plans) and plans[0].agreement >= COMPOUND_BELOW


def _framed_anew(
    paper: Paper, observer: SequenceObserver, frame: int, known: PoseEstimate | None, *, further: bool
) -> list[Plan]:
    """Plans under cameras that this photo tells; they count less for it, since the first photo's may be right."""
    plans = explain_reframed(paper, observer, frame, known, further=further)
    return [plan.noting(own_camera=1.0) for plan in plans]


def _not_contradicted(
    plans: list[Plan], paper: Paper, observer: SequenceObserver, frame: int, last: Similarity
) -> list[Plan]:
    """Plans under the first photo's camera, held against the images in between; best first."""
    between = movement(observer, frame) if frame > 1 else None
    if between is None:
        return plans
    seen = watched_places(between, last)
    return best_first([p.noting(moved_otherwise=contradiction(paper, p.paper, seen)) for p in plans])


def clearly_best(plans: tuple[Plan, ...]) -> bool:
    """Whether the first plan explains the photo and stands clear of all others."""
    return bool(plans) and (len(plans) == 1 or plans[0].score - plans[1].score > CLEAR_LEAD)


def _distinct(plans: list[Plan]) -> list[Plan]:
    """Plans without those that lead to the same folded shape as a better one."""
    kept: list[Plan] = []
    seen: set[frozenset[tuple[object, ...]]] = set()
    for plan in plans:
        key = _shape(plan.paper)
        if key not in seen:
            seen.add(key)
            kept.append(plan)
    return kept


def _shape(paper: Paper) -> frozenset[tuple[object, ...]]:
    """What is folded how, whatever the vertices are called: each face's middle on the sheet, its motion and rank."""
    rows = []
    for rank, face in enumerate(paper.order):
        outline = paper.sheet_polygon(face)
        middle = tuple(round(sum(p[i] for p in outline) / len(outline), 2) for i in (0, 1))
        rows.append((rank, middle, tuple(round(x, 2) + 0.0 for x in paper.isometries[face])))
    return frozenset(rows)
