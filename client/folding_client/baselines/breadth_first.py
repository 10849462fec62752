"""The model ``search``: breadth-first search over actions, each state compared with the photo. It asks for no proposal.

The states of a frame are tried within one attempt: it opens with a turn by 360 degrees, which changes nothing, so that
undoing a trial never comes back to the checkpoint, which would end the attempt. What is found is carried out in a second one.
"""

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass

from folding_schemas.results import Comparison, RunInfo, StateView
from folding_schemas.state import FoldedState

from folding_client.baselines.search_moves import SearchMove, carried_out, look_of, moves_from
from folding_client.baselines.stepwise import FrameWork, compare_call, save_call
from folding_client.messages import ToolResult
from folding_client.search.frame_search import Calls

SEARCH = "search"
"""The id of the model."""
_OPENING = SearchMove("rotate", {"angle": 360})


@dataclass(frozen=True)
class SearchBounds:
    """How far a frame is searched: moves in a row, states of each depth that are gone on from (those that agree best with
    the photo), moves that are tried, refused ones included, and seconds, None for no bound.
    """

    depth: int
    width: int
    tries: int
    seconds: float | None = None


@dataclass(frozen=True)
class FoundState:
    """Moves from the checkpoint, and how well what they come to agrees with the photo."""

    moves: tuple[SearchMove, ...]
    agreement: float = -1.0
    matches: bool = False


SearchWork = Generator[Calls, list[ToolResult], None]


class BreadthFirst:
    """The search for one frame. It ends at the first state that matches, or at a bound, with the one that agrees best.

    ``best`` is what was found so far, ``compared`` counts the comparisons.
    """

    def __init__(self, bounds: SearchBounds) -> None:
        self._bounds = bounds
        self._until = None if bounds.seconds is None else time.monotonic() + bounds.seconds
        self._seen: set[frozenset[object]] = set()
        self._tries = self.compared = 0
        self._depth = 0
        self._frame = 0
        self.best = FoundState(())

    def search(self, frame: int) -> SearchWork:
        """Try states, breadth first; ``best`` is what was found."""
        self._frame = frame
        yield from carried_out(_OPENING)
        yield from self._compare(FoundState(()))
        level: Sequence[FoundState] = [FoundState(())]
        for _ in range(self._bounds.depth):
            found: list[FoundState] = []
            for start in level:
                yield from self._expand(start, found)
            level = sorted(found, key=lambda each: -each.agreement)[: self._bounds.width]

    @property
    def _over(self) -> bool:
        late = self._until is not None and time.monotonic() >= self._until
        return self.best.matches or late or self._tries >= self._bounds.tries

    def _expand(self, start: FoundState, found: list[FoundState]) -> SearchWork:
        """Try every move from a state that was found."""
        if self._over:
            return
        yield from self._back(self._depth)
        for move in start.moves:
            self._depth += (yield from carried_out(move)).actions
        (answer,) = yield [("get_current_state", {})]
        for move in moves_from(StateView.model_validate(answer.data).state):
            if self._over:
                return
            yield from self._try(start, move, found)

    def _try(self, start: FoundState, move: SearchMove, found: list[FoundState]) -> SearchWork:
        """Carry a move out, compare if it looks new, and take it back."""
        self._tries += 1
        carried = yield from carried_out(move)
        self._depth += carried.actions
        if not carried.answer.is_error and self._is_new(carried.answer):
            trial = yield from self._compare(FoundState((*start.moves, move)))
            found.append(trial)
        if not self._over:
            yield from self._back(carried.actions)

    def _is_new(self, answer: ToolResult) -> bool:
        look = look_of(FoldedState.model_validate((answer.data or {})["state"]))
        new = look not in self._seen
        self._seen.add(look)
        return new

    def _compare(self, trial: FoundState) -> Generator[Calls, list[ToolResult], FoundState]:
        (answer,) = yield [compare_call(self._frame)]
        self.compared += 1
        if answer.is_error:
            return trial
        comparison = Comparison.model_validate(answer.data)
        trial = FoundState(trial.moves, comparison.agreement, comparison.verdict == "MATCH")
        if trial.agreement > self.best.agreement or trial.matches:
            self.best = trial
        return trial

    def back_to_opening(self) -> SearchWork:
        """Take back all but the turn that opened the attempt."""
        yield from self._back(self._depth)

    def _back(self, actions: int) -> SearchWork:
        """Take back the last actions."""
        if actions:
            yield [("undo", {})] * actions
            self._depth -= actions


def searched_frame(bounds: SearchBounds, info: RunInfo, frame: int) -> FrameWork:
    """One frame by search."""
    search = BreadthFirst(bounds)
    yield from search.search(frame)
    yield from _carry_out_best(search, info, frame)


def _carry_out_best(search: BreadthFirst, info: RunInfo, frame: int) -> SearchWork:
    """Carry out what was found from the checkpoint, or where no further attempt is left from the opening, and save it."""
    if info.attempts_left is None or info.attempts_left > 1:
        yield [("restore_checkpoint", {"frame": frame - 1})]
    else:
        yield from search.back_to_opening()
    for move in search.best.moves:
        yield from carried_out(move)
    yield [compare_call(frame)]
    found = "a match" if search.best.matches else "not a match, the best of what was tried"
    yield [
        save_call(
            frame, f"agreement {search.best.agreement:.4f} after {search.compared} comparisons, {found}"
        )
    ]
