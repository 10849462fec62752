"""Explaining one transition: every class of action tried, the best refined, compound plans if no single one will do."""

from collections.abc import Sequence
from dataclasses import replace

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.any_camera import ANOTHER_BELOW
from folding_server.vision.registration.alignment import Freedom, align
from folding_server.vision.registration.chamfer_matching import (
    HANDHELD_DRIFT,
    SLIGHT_DRIFT,
    DriftRange,
    drifts,
)
from folding_server.vision.registration.edge_icp import snapped_to_edges
from folding_server.vision.registration.scene import Views, face_stack
from folding_server.vision.solver.fold_search import Effort
from folding_server.vision.solver.measuring import measured
from folding_server.vision.solver.plan import Plan, best_first
from folding_server.vision.solver.same_colour_folds import same_colour_folds
from folding_server.vision.solver.sheet_motions import likely_motions
from folding_server.vision.solver.single_folds import as_plans, fold_search, line_plans
from folding_server.vision.solver.two_actions import fold_after, two_folds
from folding_server.vision.solver.visible_change import against_nothing
from folding_server.vision.solver.whole_moves import flip_plans, turned_plans, unfold_plans

EXPLAINED = 0.985
"""A plan of one action with this agreement ends the search for compound ones."""
STANDS_OUT = 0.01
"""How much better than doing nothing a flip or unfold must be for folds not to be looked for. They are after a turn: some
folds make a shape that only seems turned.
"""
AGREEMENT_NOISE = 0.003
"""A photo that the state before explains this nearly as well as its own shows a change by lines at most; and a flip or unfolding
that explains it so well ends the search: half a sheet folded over may look turned over, but for a hundredth.
"""
PROMISING = 0.08
"""Plans this much worse than the best of their kind on the coarse view are dropped."""
OF_A_KIND = 4
"""Turns, flips, unfolds and compound moves measured in full: those of one kind often look alike but for their lines."""
OFTEN_RIGHT = 2
"""As many of each kind are laid on the photo's borders first."""
COMPOUND_BELOW = 0.975
"""If no single action explains this much, two are tried."""
WORSE = 0.01
"""Unless the photo before was explained better than this by no more: no photo is explained better than its noise lets it."""
FEW_FACES = 12
"""On papers of more faces there are too many folds for lines alone to tell one."""
LOST = 0.9
"""If the state before explained its own photo less than this it was wrong, and what takes long to find puts nothing right."""


def explain(paper: Paper, last: Similarity, views: Views, effort: Effort = Effort()) -> list[Plan]:
    """Plans that lead from ``paper``, seen under the motion ``last`` in the photo before, to the photo, best first; of two folds
    where one action does not explain enough.
    """
    plans = single_actions(paper, last, views, effort)
    if worth_pairs(plans, views):
        plans += pairs_of_actions(plans, paper, last, views, effort)
    return judged(plans)


def judged(plans: Sequence[Plan]) -> list[Plan]:
    """Plans of one photo weighed against nothing, the first of them; best first."""
    return best_first([against_nothing(plan, plans[0]) for plan in plans])


def enough_explained(views: Views) -> float:
    """The agreement that ends a search: COMPOUND_BELOW, or all that can be hoped for in these photos."""
    return min(COMPOUND_BELOW, max(ANOTHER_BELOW, views.expected - WORSE))


def worth_pairs(plans: Sequence[Plan], views: Views) -> bool:
    """Whether two actions are worth the search: no plan explains enough, and the paper was known in the photo before."""
    return views.expected >= LOST and max(p.agreement for p in plans) < enough_explained(views)


def single_actions(paper: Paper, last: Similarity, views: Views, effort: Effort = Effort()) -> list[Plan]:
    """Plans of one action, the first of them none, not yet :func:`judged`."""
    motions = likely_motions(paper, last, views)
    nothing = measured(_nothing(paper, motions, views), views, last)
    plans = [nothing, *_whole_moves(paper, last, motions, views)]
    best = max(plans, key=lambda p: p.looks)
    if not _clear(best, nothing, views.expected):
        search = fold_search(paper, motions, views, effort)
        plans += as_plans(search.run(), paper, views, motions[0])
        if nothing.agreement > views.expected - AGREEMENT_NOISE or search.calm:
            plans = _within_a_colour(plans, paper, nothing.motion, views, last)
    if views.handheld and max(p.agreement for p in plans) < enough_explained(views):
        moved = drifts(face_stack(paper), views.coarse, last, HANDHELD_DRIFT)
        found = fold_search(paper, moved, views, replace(effort, share=0.6)).run()
        plans += as_plans(found, paper, views, moved[0])
    return plans


def pairs_of_actions(
    plans: Sequence[Plan], paper: Paper, last: Similarity, views: Views, effort: Effort = Effort()
) -> list[Plan]:
    """Plans of two folds at once, and where those explain too little of a fold after the best of the plans of one action."""
    begun = [plan for plan in best_first(plans) if plan.actions][:1]
    motions = likely_motions(paper, last, views, (SLIGHT_DRIFT, DriftRange()))
    found = list(two_folds(paper, motions, views, effort))
    if max((p.agreement for p in found), default=0.0) < enough_explained(views):
        found += [plan for start in begun for plan in fold_after(start, views, effort)]
    return found


def _within_a_colour(
    plans: list[Plan], paper: Paper, motion: Similarity, views: Views, last: Similarity
) -> list[Plan]:
    """The plans, weighed by what looks different between the photos within one colour, and folds found by that; or by the
    lines in this photo, where no fold explains what looks different.
    """
    search = same_colour_folds(paper, motion, views, last)
    if search is None:
        return [*plans, *line_plans(paper, motion, views)]
    found = [search.judged(measured(plan, views, last)) for plan in search.plans()]
    if not found and len(paper.faces) <= FEW_FACES:
        plans = [*plans, *line_plans(paper, motion, views)]
    return [*search.weighed(plans), *found]


def _clear(best: Plan, nothing: Plan, expected: float) -> bool:
    """Whether a flip or unfold explains the photo so well that no fold need be looked for: at the size that the sheet had, by
    its classes and by its lines, and nearly as well as the photo before was explained.
    """
    return (
        not best.scaled
        and best.action_class != "rotate"
        and best.looks >= max(EXPLAINED, nothing.looks + STANDS_OUT)
        and best.agreement >= max(nothing.agreement + STANDS_OUT, expected - AGREEMENT_NOISE)
    )


def _whole_moves(paper: Paper, last: Similarity, motions: Sequence[Similarity], views: Views) -> list[Plan]:
    """Rotations, flips and unfolds; the promising ones measured on the fine view."""
    plans = [
        *turned_plans(paper, views.coarse, (), last),
        *flip_plans(paper, views.coarse, last),
        *unfold_plans(paper, views.coarse, motions),
    ]
    top = max((p.agreement for p in plans), default=0.0)
    promising = [p for p in best_first(plans) if p.agreement > top - PROMISING]
    kinds = {p.action_class: [q for q in promising if q.action_class == p.action_class] for p in promising}
    return [
        measured(_held(p, views) if i < OFTEN_RIGHT else p, views, last)
        for kind in kinds.values()
        for i, p in enumerate(kind[:OF_A_KIND])
    ]


def _held(plan: Plan, views: Views) -> Plan:
    """A plan with the paper's borders laid on those of the photo: a climb from afar may end a degree beside."""
    return replace(plan, motion=snapped_to_edges(face_stack(plan.paper), views.fine, plan.motion))


def _nothing(paper: Paper, motions: Sequence[Similarity], views: Views) -> Plan:
    """The plan without actions."""
    stack = face_stack(paper)
    start = max(motions, key=lambda m: views.coarse.agreement(stack, m))
    settled = align(stack, views.coarse, start, Freedom(shift=0.02, turn=2.0, halvings=4))
    return Plan((), "none", paper, settled.motion, settled.agreement, "nothing changed")
