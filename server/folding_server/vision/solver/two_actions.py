"""Plans of two actions in one keyframe, the second of them a fold."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.scene import Views
from folding_server.vision.solver.fold_search import Effort
from folding_server.vision.solver.joint import FoldMade, TwoFolds
from folding_server.vision.solver.measuring import measured
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.realise import realise
from folding_server.vision.solver.sheet_motions import likely_motions
from folding_server.vision.solver.single_folds import as_plans, fold_search

EASY_FACES = 12
"""Papers with more faces are searched with fewer lines where several searches are needed."""
SAME_LINE = 0.02
"""Lines whose normals and offsets differ by less are the same line with other layers."""
NEARLY = 0.9
"""Two folds that explain less are none that need but be moved a little."""
MOST_FIRST, FEWER_FIRST = 3, 2
"""First folds of two tried, and on papers of more faces."""


def two_folds(paper: Paper, motions: Sequence[Similarity], views: Views, effort: Effort) -> Iterator[Plan]:
    """Two folds at once: one that explains a part of the change, then one for the rest."""
    most = MOST_FIRST if len(paper.faces) <= EASY_FACES else FEWER_FIRST
    for first in _partial_folds(paper, motions, views, effort)[:most]:
        start = Plan(first.actions, "fold", first.paper, first.found.motion, 0.0, "")
        yield measured(start, views, motions[0])
        yield from _second_folds(paper, first, views, effort)


def fold_after(start: Plan, views: Views, effort: Effort) -> Iterator[Plan]:
    """A fold after a plan that explains the photo in part."""
    motions = likely_motions(start.paper, start.motion, views)
    found = fold_search(start.paper, motions, views, _lighter(effort, start.paper)).run()
    return as_plans(found, start.paper, views, motions[0], start.actions)


def _second_folds(paper: Paper, first: FoldMade, views: Views, effort: Effort) -> Iterator[Plan]:
    """Folds after a first one; where the line of that is not exact, both are refined together as well."""
    motions = likely_motions(first.paper, first.found.motion, views)
    lighter = _lighter(effort, first.paper)
    found = fold_search(first.paper, motions, views, lighter).run()
    if found and found[0].agreement > NEARLY and not first.found.exact:
        yield from _refined_pair(TwoFolds(paper, views, first, found[0]), motions, lighter)
    yield from as_plans(found, first.paper, views, motions[0], first.actions)


def _refined_pair(pair: TwoFolds, motions: Sequence[Similarity], effort: Effort) -> Iterator[Plan]:
    """Both folds of a pair where they belong, the second snapped to what is simple."""
    refined = pair.refined()
    if refined is not None:
        first, second = refined
        again = fold_search(first.paper, motions, pair.views, effort)
        yield from as_plans(again.snapped(second), first.paper, pair.views, motions[0], first.actions)


def _partial_folds(
    paper: Paper, motions: Sequence[Similarity], views: Views, effort: Effort
) -> list[FoldMade]:
    """Folds that explain a part of the change, under the drift of what nothing was done to: one of each line first."""
    partial = replace(_lighter(effort, paper), share=0.3, polished=3, partial=True)
    found = fold_search(paper, motions, views, partial).run()
    made = [FoldMade(f, *actions) for f in found for actions in realise(paper, f.moving, exact=f.exact)]
    leaders = [m for i, m in enumerate(made) if not any(_along_one_line(m, other) for other in made[:i])]
    return leaders + [m for m in made if all(m is not leader for leader in leaders)]


def _along_one_line(a: FoldMade, b: FoldMade) -> bool:
    """Whether two folds have the same line and moving side, to two hundredths of the sheet."""
    return all(abs(x - y) < SAME_LINE for x, y in zip(a.found.moving.line, b.found.moving.line, strict=True))


def _lighter(effort: Effort, paper: Paper) -> Effort:
    """An effort for one of several searches: less of it, the more faces there are to draw each time."""
    share = min(1.0, EASY_FACES / len(paper.faces))
    lines, refined = int(effort.most_lines * share), max(3, int(effort.refined * share))
    return replace(effort, most_lines=lines, refined=refined, polished=2)
