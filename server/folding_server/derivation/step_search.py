"""The fewest actions from one state to the next, searched breadth first."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import cast

from folding_schemas.actions import Action, Actions, AddVertex, Direction, Flip, FlipAxis, Fold

from folding_server.derivation.fold_candidates import fold_candidates, unfold_candidates
from folding_server.derivation.given_states import GivenState
from folding_server.derivation.pose_matching import origins_of, pose_between
from folding_server.derivation.turning import leads_to, rotation, turnings
from folding_server.errors import ActionRefused
from folding_server.simulator import Paper, apply
from folding_server.simulator.motions import FLIP_AXES

MOST_FOLDS = 4
"""Folds and unfolds in one step: photos are taken after each finished step, and few books put more into one."""
MOST_PAPERS = 400
"""Papers that are looked at for one step, some seconds of work."""
OTHER_SIDE = Flip(axis="x")
"""How the model is turned over to be folded from behind; about which axis is settled when the folds are known."""


@dataclass(frozen=True)
class DerivedStep:
    """Actions from one state to the next and the paper they lead to, or why they are not known."""

    actions: Actions | None
    paper: Paper | None
    reason: str = ""


@dataclass(frozen=True)
class _Node:
    actions: Actions
    paper: Paper
    folds: int = 0


@dataclass(frozen=True)
class _Solution:
    actions: Actions
    paper: Paper
    cost: tuple[int, int, int]
    """Actions without added vertices; vertices that the state has not, or more; vertices added."""


def derive_step(paper: Paper, given: GivenState) -> DerivedStep:
    """The fewest folds, unfolds, rotations and flips that make a paper the given state: first of all the fewest folds."""
    found: list[_Solution] = []
    reached: list[_Node] = []
    for node in _reached(paper, given):
        if (found or (reached and not given.posed)) and node.folds > reached[0].folds:
            break
        reached.append(node)
        posed = _posed(paper, node, given) if given.posed else ()
        found.extend(_solution(paper, actions, given) for actions in posed)
        if any(each.cost[:2] == (node.folds, 0) for each in found):
            break
    if found:
        best = min(found, key=lambda each: each.cost)
        return DerivedStep(best.actions, best.paper)
    if reached and not given.posed:
        return _without_pose(reached[0], given)
    reason = f"no {MOST_FOLDS} folds and unfolds along the creases of the state lead to it"
    if reached:
        reason = "the folds are found, but no rotation or flip puts the model where it is"
    return DerivedStep(None, None, reason)


def _solution(paper: Paper, actions: Actions, given: GivenState) -> _Solution:
    added = sum(isinstance(action, AddVertex) for action in actions)
    after = _after(paper, actions)
    spare = abs(len(after.vertices_coords) - len(given.pattern.vertices_coords))
    return _Solution(actions, after, (len(actions) - added, spare, added))


def _reached(paper: Paper, given: GivenState) -> Iterator[_Node]:
    """The papers that are the given state but for where the model lies, the fewest folds first."""
    waiting, seen, looked = deque([_Node((), paper)]), {_signature(paper)}, 0
    while waiting and looked < MOST_PAPERS:
        node = waiting.popleft()
        looked += 1
        if pose_between(node.paper, given) is not None:
            yield node
        if node.folds < MOST_FOLDS:
            for child in _children(node, given):
                if (signature := _signature(child.paper)) not in seen:
                    seen.add(signature)
                    waiting.append(child)


def _children(node: _Node, given: GivenState) -> Iterator[_Node]:
    """The papers one fold or unfold further, folded from in front or from behind, whose creases the state has too."""
    origins = origins_of(given, node.paper)
    if origins is None:
        return
    for actions, folded in (
        *unfold_candidates(node.paper, given, origins),
        *fold_candidates(node.paper, given, origins),
    ):
        yield _Node((*node.actions, *actions), folded, node.folds + 1)
    behind = apply(node.paper, OTHER_SIDE)
    for actions, folded in fold_candidates(behind, given, origins):
        yield _Node((*node.actions, OTHER_SIDE, *actions), folded, node.folds + 1)


def _signature(paper: Paper) -> tuple[object, ...]:
    """The same for papers that are one but for where the model lies."""
    first = paper.isometries[paper.order[0]].inverse()
    motions = tuple(
        tuple(round(value, 3) + 0.0 for value in first.after(paper.isometries[f]))
        for f in sorted(paper.faces)
    )
    return paper.back_up(paper.order[0]), motions, paper.order, len(paper.vertices_coords)


def _posed(paper: Paper, node: _Node, given: GivenState) -> Iterator[Actions]:
    """The actions of a node with the rotations and flips that put the model where the state has it."""
    for axes in _flip_axes(node.actions):
        actions = _with_axes(node.actions, axes)
        for before in ((), *_first_turns(paper, actions, given)):
            for whole in _both_ways((*before, *actions)):
                try:
                    turned = _after(paper, whole)
                except ActionRefused:
                    continue
                after = () if before else next(turnings(turned, given), None)
                if after is not None and leads_to(turned, after, given):
                    yield (*whole, *after)


def _first_turns(paper: Paper, actions: Actions, given: GivenState) -> Iterator[Actions]:
    """The rotation that has to come before the folds if the one that is missing after them comes first."""
    try:
        pose = pose_between(_after(paper, actions), given)
    except ActionRefused:
        return
    if pose is not None and not pose.mirrors and actions:
        turn = rotation(pose)
        flips = sum(isinstance(action, Flip) for action in actions)
        yield (turn.model_copy(update={"angle": -turn.angle if flips % 2 else turn.angle}),)


def _both_ways(actions: Actions) -> Iterator[Actions]:
    """The actions with their folds either way, as they are first: a model that lies otherwise has its upper side elsewhere."""
    places = [i for i, action in enumerate(actions) if isinstance(action, Fold)]
    for signs in product((1, -1), repeat=len(places)):
        changed = list(actions)
        for place, sign in zip(places, signs, strict=True):
            fold = cast("Fold", actions[place])
            changed[place] = Fold(edge=fold.edge, direction=cast("Direction", sign * fold.direction))
        yield tuple(changed)


def _flip_axes(actions: Actions) -> Iterator[tuple[FlipAxis, ...]]:
    """Axes for the flips among actions: all about one axis, each axis in turn."""
    flips = sum(isinstance(action, Flip) for action in actions)
    for axis in FLIP_AXES if flips else FLIP_AXES[:1]:
        yield (cast("FlipAxis", axis),) * flips


def _with_axes(actions: Actions, axes: tuple[FlipAxis, ...]) -> Actions:
    left = iter(axes)
    changed: list[Action] = [
        Flip(axis=next(left)) if isinstance(action, Flip) else action for action in actions
    ]
    return tuple(changed)


def _without_pose(node: _Node, given: GivenState) -> DerivedStep:
    """What can be said where the file does not tell where the model lies: folds as far as no turn is needed."""
    pose = pose_between(node.paper, given)
    if any(isinstance(action, Flip) for action in node.actions) or pose is None or pose.mirrors:
        return DerivedStep(
            None,
            None,
            "the model is turned over, and the file does not say where it lies, so not about which axis",
        )
    if all(isinstance(action, AddVertex) for action in node.actions):
        return DerivedStep(
            None, None, "only the whole model can have been turned, and the file does not say where it lies"
        )
    return DerivedStep(node.actions, node.paper)


def _after(paper: Paper, actions: Actions) -> Paper:
    """The paper after actions. ActionRefused if one is."""
    for action in actions:
        paper = apply(paper, action)
    return paper
