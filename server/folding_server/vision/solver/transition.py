"""Explaining one transition: every class of action tried, the best refined, compound plans if no single one will do."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import dist

from folding_schemas.results import ActionClass

from folding_server.simulator.paper import Paper
from folding_server.simulator.plane_geometry import IDENTITY, Isometry, Point
from folding_server.vision.solver.alignment import Aligned, Freedom, align, scale_of, turned_between
from folding_server.vision.solver.drift import HANDHELD, SLIGHT, Range, drifts
from folding_server.vision.solver.fold_search import Effort, FoldFound, FoldSearch
from folding_server.vision.solver.holding import held
from folding_server.vision.solver.inner_edges import inner_lines
from folding_server.vision.solver.joint import FoldMade, TwoFolds
from folding_server.vision.solver.leaves import Leaves
from folding_server.vision.solver.lines import as_line, both_ways, evidence, landmark_lines
from folding_server.vision.solver.plan import Plan, best_first, zoom_cost
from folding_server.vision.solver.realise import Actions, realise
from folding_server.vision.solver.scene import Scene, Views, stack_of
from folding_server.vision.solver.whole_moves import (
    best_turns,
    centered,
    flip_plans,
    turned_plans,
    unfold_plans,
)

EXPLAINED = 0.985
"""A plan of one action with this agreement ends the search for compound ones."""
STANDS_OUT = 0.01
"""How much better than doing nothing a turn, flip or unfold must be for folds not to be looked for."""
PROMISING = 0.08
"""Plans this much worse than the best of their kind on the coarse view are dropped."""
OF_A_KIND = 4
"""Turns, flips, unfolds and compound moves measured in full: those of one kind often look alike but for their lines."""
EASY_FACES = 12
"""Papers with more faces are searched with fewer lines where several searches are needed."""
LOCATED = 0.96
"""A paper that explains its photo less well where it was last put is looked for at all angles."""
SAME_DRIFT = 0.008
"""Motions that differ by less (sheet units) are tried once."""
VISIBLE = 0.003
"""How much better than nothing a fold or unfold must look to count as seen."""
MOST_LINES, MOST_SETTLED = 80, 6
"""Folds along landmarks compared by their inner lines, and measured in full, when only those changed."""
MOST_FIRST = 3
"""First folds of two tried."""
COMPOUND_BELOW = 0.975
"""If no single action explains this much, two are tried."""
WORSE, SURELY_WRONG = 0.01, 0.95
"""Unless the photo before was explained little better than this: no photo is explained better than its noise lets it;
but what explains less than the second figure is not the explanation.
"""


def locate(paper: Paper, scene: Scene) -> Aligned:
    """The motion under which a paper explains the photo it was made from, and how well it does."""
    stack = stack_of(paper)
    freedom = Freedom(shift=0.04, turn=4.0, scale=0.04, halvings=5)
    starts = (IDENTITY, centered(stack, scene))
    best = max((align(stack, scene, start, freedom) for start in starts), key=lambda a: a.agreement)
    if best.agreement < LOCATED:
        best = max((best, *best_turns(stack, scene)), key=lambda a: a.agreement)
    return best


def explain(paper: Paper, last: Isometry, views: Views, effort: Effort = Effort()) -> list[Plan]:
    """Plans that lead from ``paper``, seen under the motion ``last`` in the photo before, to the photo, best first."""
    motions = _drifts(paper, last, views)
    nothing = _settled(_nothing(paper, motions, views), views, last)
    plans = [nothing, *_whole_moves(paper, last, motions, views)]
    best = max(p.agreement for p in plans)
    if best < EXPLAINED or best < nothing.agreement + STANDS_OUT:
        plans += fold_plans(paper, motions, views, effort)
        if _quiet(paper, motions, views):
            plans += line_plans(paper, nothing.motion, views)
    enough = min(COMPOUND_BELOW, max(SURELY_WRONG, views.expected - WORSE))
    if views.handheld and max(p.agreement for p in plans) < enough:
        moved = drifts(stack_of(paper), views.coarse, last, HANDHELD)
        plans += fold_plans(paper, moved, views, replace(effort, share=0.6))
    if max(p.agreement for p in plans) < enough:
        plans += _compound_plans(paper, _drifts(paper, last, views, (SLIGHT, Range())), views, plans, effort)
    return best_first([_unseen(plan, nothing) for plan in plans])


def _unseen(plan: Plan, nothing: Plan) -> Plan:
    """A plan that creases, marked if the photo shows no more of it than of nothing at all."""
    return replace(plan, unseen=plan.creases and plan.looks < nothing.looks + VISIBLE)


def _whole_moves(paper: Paper, last: Isometry, motions: Sequence[Isometry], views: Views) -> list[Plan]:
    """Rotations, flips and unfolds; the promising ones measured on the fine view."""
    plans = [
        *turned_plans(paper, views.coarse, (), last),
        *flip_plans(paper, views.coarse, last),
        *unfold_plans(paper, views.coarse, motions),
    ]
    top = max((p.agreement for p in plans), default=0.0)
    promising = [p for p in best_first(plans) if p.agreement > top - PROMISING]
    kinds = {p.action_class: [q for q in promising if q.action_class == p.action_class] for p in promising}
    return [_settled(p, views, last) for kind in kinds.values() for p in kind[:OF_A_KIND]]


def _compound_plans(
    paper: Paper, motions: Sequence[Isometry], views: Views, plans: Sequence[Plan], effort: Effort
) -> Iterator[Plan]:
    """Two folds at once, and a fold after the best incomplete plan."""
    best = 0.0
    for first in _partial_folds(paper, motions, views, effort)[:MOST_FIRST]:
        start = Plan(first.actions, "fold", first.paper, first.found.motion, 0.0, "")
        yield _settled(start, views, motions[0])
        for plan in _after(start, views, effort, first if not first.found.exact else None, paper):
            best = max(best, plan.agreement)
            yield plan
        if best > EXPLAINED:
            return
    for start in [p for p in best_first(plans) if p.actions][:1]:
        yield from _after(start, views, effort)


def _after(
    start: Plan, views: Views, effort: Effort, inexact: FoldMade | None = None, paper: Paper | None = None
) -> Iterator[Plan]:
    """Folds after a plan. A first fold that is ``inexact``, of ``paper``, is refined together with the second."""
    motions = _drifts(start.paper, start.motion, views)
    lighter = _lighter(effort, start.paper)
    found = _search(start.paper, motions, views, lighter).run()
    if inexact and paper and found and (pair := TwoFolds(paper, views, inexact, found[0]).refined()):
        first, second = pair
        again = _search(first.paper, motions, views, lighter)
        yield from _as_plans(again.snapped(second), first.paper, views, motions[0], first.actions)
    yield from _as_plans(found, start.paper, views, motions[0], start.actions)


def _partial_folds(paper: Paper, motions: Sequence[Isometry], views: Views, effort: Effort) -> list[FoldMade]:
    """Folds that explain a part of the change, under the drift of what nothing was done to."""
    partial = replace(_lighter(effort, paper), share=0.3, polished=3, partial=True)
    found = _search(paper, motions, views, partial).run()
    return [FoldMade(f, *made) for f in found for made in realise(paper, f.moving, exact=f.exact)]


def _lighter(effort: Effort, paper: Paper) -> Effort:
    """An effort for one of several searches: less of it, the more faces there are to draw each time."""
    share = min(1.0, EASY_FACES / len(paper.faces))
    lines, refined = int(effort.most_lines * share), max(3, int(effort.refined * share))
    return replace(effort, most_lines=lines, refined=refined, polished=2)


def _drifts(
    paper: Paper, last: Isometry, views: Views, ranges: Sequence[Range] = (Range(),)
) -> list[Isometry]:
    """Motions under which what has not moved may be found: near the last, and with the most edges in common."""
    stack = stack_of(paper)
    found = [last, *(motion for reach in ranges for motion in drifts(stack, views.coarse, last, reach))]
    kept: list[Isometry] = []
    for motion in [*(held(stack, views.fine, m) for m in found), last]:
        if all(_apart(motion, other, stack.center) > SAME_DRIFT for other in kept):
            kept.append(motion)
    return kept


def _apart(first: Isometry, second: Isometry, center: Point) -> float:
    """How far apart two motions put the middle of the paper and points half a sheet beside it, at most."""
    x, y = center
    return max(dist(first(p), second(p)) for p in (center, (x + 0.5, y), (x, y + 0.5)))


def _nothing(paper: Paper, motions: Sequence[Isometry], views: Views) -> Plan:
    """The plan without actions."""
    stack = stack_of(paper)
    start = max(motions, key=lambda m: views.coarse.agreement(stack, m))
    settled = align(stack, views.coarse, start, Freedom(shift=0.02, turn=2.0, halvings=4))
    return Plan((), "none", paper, settled.motion, settled.agreement, "nothing changed")


def _settled(plan: Plan, views: Views, last: Isometry) -> Plan:
    """A plan with its motion and agreement measured on the fine view."""
    freedom = Freedom(shift=0.01, turn=1.0, scale=0.01, halvings=3)
    settled = align(stack_of(plan.paper), views.fine, plan.motion, freedom)
    zoom = zoom_cost(scale_of(settled.motion) / scale_of(last), views.handheld)
    turned = turned_between(last, settled.motion)
    lines = inner_lines(plan.paper, views.fine, settled.motion).contradiction
    return replace(
        plan, motion=settled.motion, agreement=settled.agreement, zoom=zoom, turned=turned, contradiction=lines
    )


def fold_plans(paper: Paper, motions: Sequence[Isometry], views: Views, effort: Effort) -> Iterator[Plan]:
    """Single folds that explain the photo, as actions."""
    return _as_plans(_search(paper, motions, views, effort).run(), paper, views, motions[0])


def _search(paper: Paper, motions: Sequence[Isometry], views: Views, effort: Effort) -> FoldSearch:
    drawn = stack_of(paper)
    changed = [evidence(views.coarse.draw(drawn, m), views.coarse, m) for m in motions]
    return FoldSearch(paper, views, changed, effort, scale_of(motions[0]))


def _as_plans(
    found: Sequence[FoldFound], paper: Paper, views: Views, last: Isometry, before: Actions = ()
) -> Iterator[Plan]:
    """Found folds as plans, measured on the fine view."""
    for fold in found:
        for plan in _realised(paper, fold, before):
            yield _settled(plan, views, last)


def line_plans(paper: Paper, motion: Isometry, views: Views) -> Iterator[Plan]:
    """Folds along landmarks, for photos that show a change by the lines inside the paper only."""
    leaves = Leaves(paper)
    found = [
        FoldFound(moving, motion, views.coarse.agreement(leaves.folded(moving), motion), exact=True)
        for row in both_ways(landmark_lines(paper))
        for moving in leaves.moving_sets(as_line(row))
    ]
    top = max((f.agreement for f in found), default=0.0)
    near = [f for f in sorted(found, key=lambda f: -f.agreement) if f.agreement > top - PROMISING / 4]
    plans = [plan for fold in near[:MOST_LINES] for plan in _realised(paper, fold, ())]
    plans.sort(key=lambda plan: inner_lines(plan.paper, views.fine, motion).contradiction)
    return (_settled(plan, views, motion) for plan in plans[:MOST_SETTLED])


def _quiet(paper: Paper, motions: Sequence[Isometry], views: Views) -> bool:
    """Whether the photo's classes show no change at all under some drift."""
    drawn = stack_of(paper)
    return any(not evidence(views.coarse.draw(drawn, m), views.coarse, m).shows for m in motions)


def _realised(paper: Paper, found: FoldFound, before: Actions) -> list[Plan]:
    """A found fold as plans of real actions."""
    words = f"{len(found.moving.faces)} of {len(paper.faces)} faces were folded over"
    kind: ActionClass = "compound" if before else "fold"
    return [
        Plan((*before, *actions), kind, folded, found.motion, found.agreement, words)
        for actions, folded in realise(paper, found.moving, exact=found.exact)
    ]
