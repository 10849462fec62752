"""Plans of one fold, found by what changed or, where only lines changed, by the lines."""

from collections.abc import Iterator, Sequence

from folding_schemas.actions import Actions
from folding_schemas.results import ActionClass

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.scene import FaceStack, Views, face_stack
from folding_server.vision.solver.fold_search import Effort, FoldFound, FoldSearch
from folding_server.vision.solver.inner_edges import inner_edge_agreement
from folding_server.vision.solver.lines import (
    ChangedPoints,
    as_line,
    both_ways,
    changed_points,
    landmark_lines,
)
from folding_server.vision.solver.measuring import measured
from folding_server.vision.solver.movable_layers import MovableLayers, is_thin
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.realise import realise

NEARLY_BEST = 0.02
"""Folds along landmarks that look worse than the best by more are not compared by their lines."""
MISPLACED = 0.02
"""A motion under which the paper agrees worse than under another by more is not where it lies: a rim all around it is
wrong, however thin.
"""
MOST_LANDMARK_LINES, MOST_SETTLED = 80, 6
"""Folds along landmarks compared by their inner lines, and measured in full, when only those changed."""


def fold_search(paper: Paper, motions: Sequence[Similarity], views: Views, effort: Effort) -> FoldSearch:
    """The search for a fold after what changed under each of the motions; the first is the likeliest."""
    changed = _changes(face_stack(paper), motions, views)
    return FoldSearch(paper, views, changed, effort, motions[0].scale)


def _changes(drawn: FaceStack, motions: Sequence[Similarity], views: Views) -> list[ChangedPoints]:
    """What changed on the coarse view. Motions under which that shows nothing are looked at on the fine one, and then
    they alone: the tip of a flap is small.
    """
    coarse = [changed_points(views.coarse.draw(drawn, m), views.coarse, m) for m in motions]
    return [changed_points(views.fine.draw(drawn, m), views.fine, m) for m in _calm(coarse)] or coarse


def _calm(changed: Sequence[ChangedPoints]) -> list[Similarity]:
    """The motions under which nothing changed, of those that put the paper where it is."""
    agreements = [change.scene.agreement_of(change.before) for change in changed]
    least = max(agreements, default=0.0) - MISPLACED
    return [c.motion for c, fits in zip(changed, agreements, strict=True) if fits >= least and not c.shows]


def as_plans(
    found: Sequence[FoldFound], paper: Paper, views: Views, last: Similarity, before: Actions = ()
) -> Iterator[Plan]:
    """Found folds as plans, measured on the fine view."""
    for fold in found:
        for plan in _realised(paper, fold, before):
            yield measured(plan, views, last)


def line_plans(paper: Paper, motion: Similarity, views: Views) -> Iterator[Plan]:
    """Folds along landmarks, for photos that show a change by the lines inside the paper only."""
    layers = MovableLayers(paper)
    found = [
        FoldFound(moving, motion, views.coarse.agreement(layers.folded(moving), motion), exact=True)
        for row in both_ways(landmark_lines(paper))
        for moving in layers.moving_sets(as_line(row))
    ]
    top = max((f.agreement for f in found), default=0.0)
    near = [f for f in sorted(found, key=lambda f: -f.agreement) if f.agreement > top - NEARLY_BEST]
    plans = [plan for fold in near[:MOST_LANDMARK_LINES] for plan in _realised(paper, fold, ())]
    plans.sort(key=lambda plan: inner_edge_agreement(plan.paper, views.fine, motion).contradiction)
    return (measured(plan, views, motion) for plan in plans[:MOST_SETTLED])


def _realised(paper: Paper, found: FoldFound, before: Actions) -> list[Plan]:
    """A found fold as plans of real actions."""
    words = f"{len(found.moving.faces)} of {len(paper.faces)} faces were folded over"
    kind: ActionClass = "compound" if before else "fold"
    thin = is_thin(paper, found.moving)
    return [
        Plan(
            (*before, *actions),
            kind,
            folded,
            found.motion,
            found.agreement,
            words,
        ).noting(narrow_strip=float(thin), free_line=float(not found.exact))
        for actions, folded in realise(paper, found.moving, exact=found.exact)
    ]
