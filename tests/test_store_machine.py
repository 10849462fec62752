"""The store against a plain model of the rules, driven by random calls."""

from dataclasses import dataclass, field

import hypothesis.strategies as st
import pytest
from direct_store import DirectStore
from folding_schemas.actions import Rotate
from folding_server.errors import RunError
from folding_server.store.views import BUDGETS_PER_FRAME, RunView, fold_events
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

FRAMES = 3
BUDGET = 2

Steps = list[list[int]]


@dataclass
class Tried:
    """An attempt of the model: the steps of the chain it grew from, its own, and whether it has ended.

    ``states`` are all that it came to, ``counted`` whether it costs an attempt.
    """

    chain: Steps
    actions: list[int]
    ended: bool = False
    counted: bool = True
    states: Steps = field(default_factory=list)

    def reach(self, actions: list[int]) -> None:
        """Come to a state."""
        self.actions = list(actions)
        self.states = [*(each for each in self.states if each != actions), self.actions]

    def end(self) -> None:
        self.ended = True
        if self.actions not in self.states:
            self.states.append(self.actions)


@dataclass
class Model:
    """The rules once more, with numbers for actions: ``chain`` holds the actions of each saved frame."""

    chain: Steps = field(default_factory=list)
    base: int = 0
    pending: list[int] = field(default_factory=list)
    tried: dict[int, list[Tried]] = field(default_factory=lambda: {n: [] for n in range(1, FRAMES + 1)})
    restores: dict[int, int] = field(default_factory=dict)
    locked: int = 0
    commitments: list[int] = field(default_factory=list)

    def open(self) -> Tried | None:
        tried = self.tried.get(self.base + 1, [])
        return tried[-1] if tried and not tried[-1].ended else None

    def choosable(self, tried: Tried) -> bool:
        return tried.chain[: self.locked] == self.chain[: self.locked]

    def may_try(self) -> bool:
        """Whether an attempt is open or another may begin."""
        if self.base + 1 > FRAMES:
            return False
        if self.open():
            return True
        made = [each for each in self.tried[self.base + 1] if each.counted]
        here = [each for each in made if path(each.chain) == path(self.chain[: self.base])]
        if here:
            return len(here) < BUDGET
        starts = {tuple(path(each.chain)) for each in made}
        return len(starts) < BUDGETS_PER_FRAME or not any(map(self.choosable, made))

    def begin(self) -> Tried:
        if not self.open():
            self.tried[self.base + 1].append(Tried(self.chain[: self.base], []))
        return self.tried[self.base + 1][-1]

    def end(self, *, counted: bool = True) -> None:
        if tried := self.open():
            tried.end()
            tried.counted = counted

    def stand_on(self, chain: Steps) -> None:
        if self.chain[: len(chain)] != chain:
            self.chain = chain
        self.base, self.pending = len(chain), []


class StoreMachine(RuleBasedStateMachine):
    """Every call answers as the model says, and refuses exactly when the model does."""

    def __init__(self) -> None:
        super().__init__()
        self.store = DirectStore("sqlite://")
        self.run_id = self.store.create(sequence="cat", frames=FRAMES, budget=BUDGET).run_id
        self.model = Model()

    def teardown(self) -> None:
        self.store.close()

    @initialize(first=st.integers(0, 1), second=st.integers(0, 1), tries=st.integers(0, BUDGET))
    def explore(self, first: int, second: int, tries: int) -> None:
        """One solution of frame 2, some attempts from it at frame 3, and another attempt at frame 2."""
        self.save(1)
        self.solve(first)
        for angle in range(tries):
            self.act(angle)
            self.go_back_to(2)
        self.go_back_to(1)
        self.act(second)

    @rule(angle=st.integers(0, 1))
    def act(self, angle: int) -> None:
        if not self.model.base or not self.model.may_try():
            with pytest.raises(RunError):
                self.store.act(self.run_id, Rotate(angle=angle))
            return
        self.store.act(self.run_id, Rotate(angle=angle))
        tried = self.model.begin()
        self.model.pending.append(angle)
        tried.reach(self.model.pending)

    @rule()
    def undo(self) -> None:
        if not self.model.pending:
            with pytest.raises(RunError):
                self.store.undo(self.run_id)
            return
        self.store.undo(self.run_id)
        self.model.pending.pop()
        tried = self.model.begin()
        if self.model.pending:
            tried.actions = list(self.model.pending)
        else:
            tried.actions = tried.states[-1]
            tried.end()

    @rule(offset=st.sampled_from([1, 1, 1, 0, -1, 2]))
    def save(self, offset: int) -> None:
        model, frame = self.model, self.model.base + offset
        if offset != 1 or frame > FRAMES or (frame > 1 and not model.may_try()):
            with pytest.raises(RunError):
                self.store.save(self.run_id, frame)
            return
        self.store.save(self.run_id, frame)
        if frame > 1:
            model.begin().end()
        model.stand_on([*model.chain[: model.base], model.pending])

    @rule(angle=st.integers(0, 1))
    def solve(self, angle: int) -> None:
        """Go one frame further, so that the random walk gets far."""
        self.act(angle)
        self.save(1)

    @rule(choice=st.integers(0, 99), technical=st.sampled_from([False, False, True]))
    def restore(self, choice: int, technical: bool) -> None:
        """Any saved frame, or one too low or too high."""
        self.go_back_to(choice % (len(self.model.chain) + 2), technical=technical)

    @rule(first=st.integers(0, 1), other=st.integers(2, 9))
    def mend(self, first: int, other: int) -> None:
        """Make frame 2 another, and use up frame 3 from there."""
        self.go_back_to(1)
        self.act(first)
        self.act(other)
        self.save(1)
        for angle in range(BUDGET):
            self.act(angle)
            self.undo()

    def go_back_to(self, frame: int, *, technical: bool = False) -> None:
        model = self.model
        if not 1 <= frame <= len(model.chain) or frame < model.locked:
            with pytest.raises(RunError):
                self.store.restore(self.run_id, frame, technical=technical)
            return
        self.store.restore(self.run_id, frame, technical=technical)
        model.end(counted=not technical)
        model.base, model.pending = frame, []
        model.restores[frame] = model.restores.get(frame, 0) + 1

    @precondition(lambda self: any(self.model.tried.values()))
    @rule(choice=st.integers(0, 99), offset=st.sampled_from([0, 0, 0, 0, -1, 1]), state=st.integers(0, 3))
    def commit(self, choice: int, offset: int, state: int) -> None:
        """Any attempt there is, or one beside it; any of its states (0: the last), or one beside them."""
        model = self.model
        known = [(frame, number + 1) for frame, tried in model.tried.items() for number in range(len(tried))]
        frame, number = known[choice % len(known)]
        number += offset
        tried = model.tried[frame]
        allowed = frame > model.locked and 1 <= number <= len(tried) and model.choosable(tried[number - 1])
        if not allowed or state > len(tried[number - 1].states):
            with pytest.raises(RunError):
                self.store.commit(self.run_id, frame, number, state or None)
            return
        before = self.store.load(self.run_id)
        after = self.store.commit(self.run_id, frame, number, state or None)
        assert_says_what_it_overwrites(before, after, frame, number)
        chosen = tried[number - 1]
        model.end()
        chosen.actions = chosen.states[state - 1] if state else chosen.actions
        model.stand_on([*chosen.chain, chosen.actions])
        model.locked = frame
        model.commitments.append(frame)

    @rule()
    def forget(self) -> None:
        self.store.forget()

    @invariant()
    def agrees_with_the_model(self) -> None:
        view, model = self.store.load(self.run_id), self.model
        assert [angles(view.checkpoints[f].actions) for f in sorted(view.checkpoints)] == model.chain
        assert sorted(view.checkpoints) == list(range(1, len(model.chain) + 1))
        assert (view.base, angles(view.pending), view.locked_to) == (model.base, model.pending, model.locked)
        assert view.restores == model.restores
        assert view.complete == (len(model.chain) == FRAMES)
        for frame, tried in model.tried.items():
            made = view.attempts.get(frame, ())
            assert [angles(each.actions) for each in made] == [each.actions for each in tried]
            assert [each.outcome != "open" for each in made] == [each.ended for each in tried]
            assert [each.counted for each in made] == [each.counted for each in tried]
            assert [[angles(each) for each in attempt.states] for attempt in made] == [
                each.states for each in tried
            ]

    @invariant()
    def no_frame_is_tried_more_often_than_allowed(self) -> None:
        view = self.store.load(self.run_id)
        for frame, made in view.attempts.items():
            below = sum(each < frame for each in self.model.commitments)
            counted = sum(each.counted for each in made)
            assert counted <= BUDGET * (BUDGETS_PER_FRAME + below)
            assert view.used(frame) <= BUDGET

    @invariant()
    def how_many_attempts_are_left_is_told(self) -> None:
        view, model = self.store.load(self.run_id), self.model
        if view.attempts_left is None:
            assert not view.base or model.base == FRAMES
        else:
            assert (view.attempts_left > 0) == model.may_try()

    @invariant()
    def paths_are_the_sums_of_their_steps(self) -> None:
        view = self.store.load(self.run_id)
        path: tuple[object, ...] = ()
        for frame in sorted(view.checkpoints):
            path += view.checkpoints[frame].actions
            assert view.checkpoints[frame].path == path

    @invariant()
    def the_view_is_a_function_of_the_events_alone(self) -> None:
        assert fold_events(self.run_id, self.store.history(self.run_id)) == self.store.load(self.run_id)

    @invariant()
    def there_is_always_a_way_on(self) -> None:
        assert can_go_on(self.store.load(self.run_id), self.model)


def assert_says_what_it_overwrites(before: RunView, after: RunView, frame: int, number: int) -> None:
    """What a commitment changed beside its own frame is what was told of it before."""
    chosen = after.attempts[frame][number - 1]
    changed = {
        each
        for each, saved in before.checkpoints.items()
        if each != frame and (each not in after.checkpoints or after.checkpoints[each].path != saved.path)
    }
    assert changed == {*before.rewritten_by(chosen), *before.dropped_by(chosen)}


def path(chain: Steps) -> list[int]:
    """All actions of a chain."""
    return [angle for step in chain for angle in step]


def angles(actions: tuple[object, ...]) -> list[int]:
    return [int(action.angle) for action in actions if isinstance(action, Rotate)]


def can_go_on(view: RunView, model: Model) -> bool:
    """A run is never stuck: it is at its end, or can act, or has an attempt at the next frame to commit."""
    if view.next_frame is None or not view.base or model.may_try():
        return True
    return any(view.committable(attempt) for attempt in view.attempts[view.next_frame])


StoreMachine.TestCase.settings = settings(max_examples=80, stateful_step_count=20, deadline=None)
TestStoreMachine = StoreMachine.TestCase
