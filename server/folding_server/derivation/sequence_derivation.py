"""The actions of a whole sequence of given states, each step replayed to its state before the next is looked at."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from folding_schemas.actions import Actions, Program, Unfold

from folding_server.derivation.fold_candidates import fold_candidates, missing_creases
from folding_server.derivation.given_states import GivenState, given_state
from folding_server.derivation.pose_matching import origins_of, pose_between
from folding_server.derivation.step_search import DerivedStep, derive_step
from folding_server.derivation.turning import turnings
from folding_server.errors import ActionRefused, ProgramError
from folding_server.interchange.fold_reading import FaceOrders
from folding_server.simulator import Paper, apply, new_paper
from folding_server.simulator.unfold import unfold

UNREAD = "the state before it cannot be read"
RESTART = "its vertex ids are those of the state in the file"


@dataclass(frozen=True)
class SequenceStep:
    """What leads to a frame from the one before; ``actions`` None with the ``reason`` if that is not known.

    A ``restarted`` step was derived from the state in the file, since the actions before it do not lead there exactly.
    """

    frame: int
    actions: Actions | None
    reason: str
    restarted: bool


@dataclass(frozen=True)
class DerivedSequence:
    """``papers`` are the state of each frame from 1 on: replayed where its step is derived, else as the file has it, None where
    that cannot be read.

    ``start`` are the actions from a flat, uncreased sheet to frame 1, None if they are not known; ``creases`` how many marks
    frame 1 has.
    """

    papers: tuple[Paper | None, ...]
    start: Actions | None
    creases: int
    steps: tuple[SequenceStep, ...]

    def program(self, name: str) -> Program | None:
        """The program from the flat sheet; None unless every step is derived without a restart.

        What frame 1 has of creases already is made in the first step.
        """
        known = [step.actions for step in self.steps if step.actions is not None and not step.restarted]
        if self.start is None or len(known) < len(self.steps) or not known:
            return None
        comment = "The first step begins with the creases that frame 1 has already." if self.start else None
        return Program(name=name, steps=((*self.start, *known[0]), *known[1:]), comment=comment)


def derive_sequence(documents: Sequence[Mapping[str, Any]], face_orders: FaceOrders) -> DerivedSequence:
    """The steps between the states in FOLD documents, the first of which is the flat sheet. A later state that cannot be read
    is told as its step's reason. ProgramError if there is none, or the first cannot be read.
    """
    if not documents:
        raise ProgramError(
            "There is no state to derive actions from; name a folder of FOLD files, or one with frames."
        )
    states = [_state(document, face_orders) for document in documents]
    if isinstance(states[0], ProgramError):
        raise ProgramError(f"Frame 1: {states[0]}")
    start, first = _start(states[0])
    papers: list[Paper | None] = [first]
    steps: list[SequenceStep] = []
    for frame, (before, given) in enumerate(pairwise(states), start=2):
        step, paper = _step(frame, papers[-1], before, given)
        papers.append(paper)
        steps.append(step)
    creases = sum(letter != "B" for letter in states[0].pattern.edges_assignment)
    return DerivedSequence(tuple(papers), start, creases, tuple(steps))


def _state(document: Mapping[str, Any], face_orders: FaceOrders) -> GivenState | ProgramError:
    """The state in a document, or why it cannot be read."""
    try:
        state = given_state(document, face_orders)
        state.paper()
    except ProgramError as error:
        return error
    return state


def _start(first: GivenState) -> tuple[Actions | None, Paper]:
    """How frame 1 is made of a flat sheet, and its paper."""
    marked = _with_marks(first)
    if marked is not None:
        actions, paper = marked
        if not first.posed and pose_between(paper, first) is not None:
            return actions, paper
        for turns in turnings(paper, first):
            for action in turns:
                paper = apply(paper, action)
            return (*actions, *turns), paper
    return None, first.paper()


def _with_marks(first: GivenState) -> tuple[Actions, Paper] | None:
    """The sheet with the marks of a flat state, each folded and unfolded; None if one cannot be made so."""
    paper = new_paper()
    actions: Actions = ()
    if len({motion.mirrors for motion in first.motions}) > 1:
        return None
    while True:
        origins = origins_of(first, paper)
        if origins is None:
            return None
        if not missing_creases(paper, first, origins):
            return actions, paper
        made = next(_marks(paper, first, origins), None)
        if made is None:
            return None
        actions, paper = (*actions, *made[0]), made[1]


def _marks(paper: Paper, first: GivenState, origins: list[int]) -> Iterator[tuple[Actions, Paper]]:
    """A fold that is undone, whose marks the state has."""
    for done, folded in fold_candidates(paper, first, origins):
        try:
            opened = unfold(folded)
        except ActionRefused:
            continue
        flat = all(opened.back_up(face) == opened.back_up(opened.order[0]) for face in opened.faces)
        if (
            flat
            and opened.isometries[opened.order[0]].mirrors is False
            and origins_of(first, opened) is not None
        ):
            yield (*done, Unfold()), opened


def _step(
    frame: int, paper: Paper | None, before: GivenState | ProgramError, given: GivenState | ProgramError
) -> tuple[SequenceStep, Paper | None]:
    """A step from the paper so far; if it leads nowhere, from the state in the file."""
    if isinstance(given, ProgramError):
        return SequenceStep(frame, None, f"the state cannot be read: {given}", restarted=False), None
    if paper is None or isinstance(before, ProgramError):
        return SequenceStep(frame, None, UNREAD, restarted=False), given.paper()
    derived = derive_step(paper, given)
    if derived.actions is not None and derived.paper is not None:
        return SequenceStep(frame, derived.actions, "", restarted=False), derived.paper
    again: DerivedStep = derive_step(before.paper(), given)
    if again.actions is not None and again.paper is not None:
        return SequenceStep(frame, again.actions, RESTART, restarted=True), again.paper
    return SequenceStep(frame, None, derived.reason, restarted=False), given.paper()
