"""How a run behaves: checkpoints, attempts, the budget, commitments, and what is refused in which words."""

from collections.abc import Callable, Iterator
from uuid import UUID

import pytest
from direct_store import DirectStore
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate
from folding_server.errors import ActionRefused, RunError
from folding_server.store import rules, run_store
from folding_server.store.rules import MOST_TECHNICAL_RETURNS
from folding_server.store.views import RunView

TURN, FLIP, FOLD = Rotate(angle=30), Flip(axis="x"), Fold(edge=(1, 3), direction=1)


@pytest.fixture
def store() -> Iterator[DirectStore]:
    with DirectStore("sqlite://") as opened:
        yield opened


@pytest.fixture
def run_id(store: DirectStore) -> str:
    """A run of a sequence of four frames, frame 1 saved."""
    view = store.create(sequence="cat", frames=4, fingerprint="abc", front_color="red", back_color="white")
    return store.save(view.run_id, 1).run_id


def act(store: DirectStore, run_id: str, *actions: Action) -> RunView:
    return [store.act(run_id, action) for action in actions][-1]


def use_up(store: DirectStore, run_id: str, frame: int) -> RunView:
    """Make five attempts at the frame: turns by 1 to 5 degrees, each given up."""
    for degrees in range(1, 6):
        store.act(run_id, Rotate(angle=degrees))
        view = store.restore(run_id, frame - 1)
    return view


def test_a_run_grows_frame_by_frame_into_a_program(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN, FOLD)
    store.save(run_id, 2, notes="first fold")
    store.save(run_id, 3)
    act(store, run_id, FLIP)
    view = store.save(run_id, 4)
    assert view.complete
    assert view.next_frame is None
    assert view.checkpoints[2].notes == "first fold"
    assert view.program().steps == ((TURN, FOLD), (), (FLIP,))
    assert view.program().name == "cat"
    assert view.actions == (TURN, FOLD, FLIP)


def test_a_reopened_run_is_what_was_answered_last(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN)
    use_up(store, run_id, 2)
    answered = store.commit(run_id, 2, 3)
    store.forget()
    assert store.load(run_id) == answered


def test_nothing_is_folded_before_frame_1_is_saved(store: DirectStore) -> None:
    run_id = store.create(sequence="cat", frames=4).run_id
    with pytest.raises(RunError, match=r"save_checkpoint\(1\) first"):
        store.act(run_id, TURN)
    with pytest.raises(RunError, match="before frame 1"):
        store.save(run_id, 2)
    assert store.load(run_id).seq == 1


def test_undo_takes_back_actions_down_to_the_checkpoint(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN, FLIP)
    assert store.undo(run_id).pending == (TURN,)
    assert store.undo(run_id).pending == ()
    with pytest.raises(RunError, match="no action to undo: the current state is checkpoint 1 itself"):
        store.undo(run_id)


def test_an_undo_back_to_the_checkpoint_ends_the_attempt_at_the_state_it_took_back(
    store: DirectStore, run_id: str
) -> None:
    act(store, run_id, TURN, FLIP)
    store.undo(run_id)
    view = store.undo(run_id)
    assert (view.used(2), view.open_attempt, view.next_attempt) == (1, None, 2)
    (attempt,) = view.attempts[2]
    assert (attempt.actions, attempt.outcome) == ((TURN, FLIP), "restored")
    assert act(store, run_id, FLIP).used(2) == 2


def test_in_runs_of_earlier_versions_an_undo_ended_no_attempt(
    store: DirectStore, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_store, "RULES", 1)
    old = store.create(sequence="cat", frames=4).run_id
    for each in (old, run_id):
        store.save(old, 1) if each == old else None
        act(store, each, TURN)
        store.undo(each)
        act(store, each, FLIP)
        store.undo(each)
    assert [attempt.outcome for attempt in store.load(old).attempts[2]] == ["open"]
    assert [attempt.outcome for attempt in store.load(run_id).attempts[2]] == ["restored", "restored"]
    store.forget()
    assert store.commit(old, 2, 1, 2).actions == (FLIP,)


def test_every_state_of_an_attempt_can_be_chosen(store: DirectStore, run_id: str) -> None:
    act(store, run_id, AddVertex(edge=(1, 2), position=0.5), FOLD, FLIP)
    store.undo(run_id)
    act(store, run_id, TURN)
    view = store.restore(run_id, 1)
    begun = (AddVertex(edge=(1, 2), position=0.5), FOLD)
    (attempt,) = view.attempts[2]
    assert attempt.states == (begun, (*begun, FLIP), (*begun, TURN))
    assert attempt.actions == (*begun, TURN)
    with pytest.raises(RunError, match="there is no state 4 of attempt 1 at frame 2; choose one from 1 to 3"):
        store.commit(run_id, 2, 1, 4)
    view = store.commit(run_id, 2, 1, 2)
    assert view.checkpoints[2].actions == (*begun, FLIP)
    assert view.attempts[2][0].actions == (*begun, FLIP)


def test_a_technical_return_costs_no_attempt_and_what_was_done_can_still_be_chosen(
    store: DirectStore, run_id: str
) -> None:
    for _ in range(7):
        act(store, run_id, TURN)
        view = store.restore(run_id, 1, technical=True)
    assert (view.used(2), view.attempts_left, len(view.attempts[2])) == (0, 5, 7)
    act(store, run_id, FLIP)
    view = store.restore(run_id, 1)
    assert (view.used(2), view.attempts_left) == (1, 4)
    assert store.commit(run_id, 2, 3).actions == (TURN,)


def test_technical_returns_are_taken_so_often_at_a_frame_and_then_cost_an_attempt(
    store: DirectStore, run_id: str
) -> None:
    for _ in range(MOST_TECHNICAL_RETURNS):
        act(store, run_id, TURN)
        store.restore(run_id, 1, technical=True)
    act(store, run_id, TURN)
    with pytest.raises(
        RunError, match=f"{MOST_TECHNICAL_RETURNS} attempts at frame 2 have ended for technical"
    ):
        store.restore(run_id, 1, technical=True)
    view = store.restore(run_id, 1)
    assert (view.used(2), view.attempts_left) == (1, 4)
    assert store.restore(run_id, 1, technical=True).used(2) == 1


def test_a_frame_is_tried_anew_after_an_earlier_one_was_changed_but_from_three_states_at_most(
    store: DirectStore, run_id: str
) -> None:
    for angle in (1, 2, 3):
        act(store, run_id, Rotate(angle=angle))
        assert store.save(run_id, 2).attempts_left == 5
        assert use_up(store, run_id, 3).attempts_left == 0
        store.restore(run_id, 1)
    act(store, run_id, Rotate(angle=4))
    view = store.save(run_id, 2)
    assert (view.used(3), view.attempts_left, len(view.attempts[3])) == (0, 0, 15)
    refusal = r"frame 3 has been tried from 3 states of frame 2, which is all; call list_attempts\(3\)"
    with pytest.raises(RunError, match=refusal):
        store.act(run_id, TURN)
    assert view.rewritten_by(view.attempts[3][0]) == [2]
    assert store.commit(run_id, 3, 1).checkpoints[2].actions == (Rotate(angle=1),)


def test_after_a_commitment_there_is_always_an_attempt_to_make_or_one_to_choose(
    store: DirectStore, run_id: str
) -> None:
    for angle in (1, 2, 3):
        act(store, run_id, Rotate(angle=angle))
        store.save(run_id, 2)
        use_up(store, run_id, 3)
        store.restore(run_id, 1)
    act(store, run_id, Rotate(angle=4))
    view = store.commit(run_id, 2, 4)
    assert view.attempts_left == 5
    assert not any(map(view.committable, view.attempts[3]))
    act(store, run_id, TURN)
    assert store.save(run_id, 3).base == 3


def test_a_restore_without_an_action_before_it_is_no_attempt(store: DirectStore, run_id: str) -> None:
    store.restore(run_id, 1)
    view = store.restore(run_id, 1)
    assert view.restores == {1: 2}
    assert view.used(2) == 0


def test_saving_an_unchanged_state_is_an_attempt_without_actions(store: DirectStore, run_id: str) -> None:
    view = store.save(run_id, 2)
    (attempt,) = view.attempts[2]
    assert (attempt.actions, attempt.outcome, attempt.label) == ((), "saved", "B1")


def test_looking_back_loses_nothing(store: DirectStore, run_id: str) -> None:
    for frame in (2, 3, 4):
        act(store, run_id, TURN)
        finished = store.save(run_id, frame)
    view = act(store, store.restore(run_id, 2).run_id, FLIP)
    assert view.complete
    assert view.program() == finished.program()
    assert view.current_program().steps == ((TURN,), (FLIP,))
    assert store.restore(run_id, 4).actions == finished.actions


def test_saving_another_solution_drops_what_grew_from_the_old_one(store: DirectStore, run_id: str) -> None:
    for frame in (2, 3, 4):
        act(store, run_id, TURN)
        store.save(run_id, frame)
    act(store, store.restore(run_id, 2).run_id, FLIP)
    view = store.save(run_id, 3)
    assert list(view.checkpoints) == [1, 2, 3]
    assert not view.complete
    assert view.program().steps == ((TURN,), (FLIP,))


def test_saving_the_same_solution_again_keeps_what_grew_from_it(store: DirectStore, run_id: str) -> None:
    for frame in (2, 3, 4):
        act(store, run_id, TURN)
        store.save(run_id, frame)
    act(store, store.restore(run_id, 2).run_id, TURN)
    view = store.save(run_id, 3, notes="checked")
    assert view.complete
    assert view.checkpoints[3].notes == "checked"
    assert view.next_frame == 4


def test_a_sixth_attempt_is_refused_until_one_is_committed(store: DirectStore, run_id: str) -> None:
    view = use_up(store, run_id, 2)
    assert [attempt.outcome for attempt in view.attempts[2]] == ["restored"] * 5
    refusal = r"the 5 attempts at frame 2 are used up; call list_attempts\(2\), then commit_attempt\(2, k\)"
    for refused in (lambda: store.act(run_id, TURN), lambda: store.save(run_id, 2)):
        with pytest.raises(RunError, match=refusal):
            refused()
    with pytest.raises(RunError, match=refusal):
        rules.check_may_act(view)
    view = store.commit(run_id, 2, 4)
    assert view.checkpoints[2].actions == (Rotate(angle=4),)
    assert (view.base, view.next_frame, view.locked_to) == (2, 3, 2)
    assert view.attempts[2][3].outcome == "committed"
    assert act(store, run_id, FLIP).actions == (Rotate(angle=4), FLIP)


def test_the_fifth_attempt_may_go_on(store: DirectStore, run_id: str) -> None:
    for _ in range(4):
        act(store, run_id, TURN)
        store.restore(run_id, 1)
    assert act(store, run_id, TURN, FLIP, FOLD).used(2) == 5
    assert store.save(run_id, 2).base == 2


def test_an_open_attempt_can_be_committed_and_is_given_up_for_another(
    store: DirectStore, run_id: str
) -> None:
    act(store, run_id, TURN)
    store.restore(run_id, 1)
    act(store, run_id, FLIP)
    other = store.create(sequence="cat", frames=4).run_id
    act(store, store.save(other, 1).run_id, FLIP)
    assert store.commit(other, 2, 1).actions == (FLIP,)
    view = store.commit(run_id, 2, 1)
    assert view.actions == (TURN,)
    assert [attempt.outcome for attempt in view.attempts[2]] == ["committed", "restored"]


def test_attempts_count_for_the_state_that_they_grew_from(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN)
    store.save(run_id, 2)
    act(store, run_id, FOLD)
    store.restore(run_id, 1)
    act(store, run_id, FLIP)
    store.save(run_id, 2)
    view = act(store, run_id, FOLD)
    assert (view.used(3), view.next_attempt) == (1, 2)
    assert [attempt.base_path for attempt in view.attempts[3]] == [(TURN,), (FLIP,)]


def test_committing_saves_the_chain_that_the_attempt_grew_from(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN)
    store.save(run_id, 2, notes="turned")
    act(store, run_id, FOLD)
    store.restore(run_id, 1)
    act(store, run_id, FLIP)
    store.save(run_id, 2, notes="flipped")
    view = store.commit(run_id, 3, 1)
    assert view.program().steps == ((TURN,), (FOLD,))
    assert view.checkpoints[2].notes == "turned"
    assert view.locked_to == 3


def test_a_commitment_closes_the_frames_before_it_but_not_the_way_on(store: DirectStore, run_id: str) -> None:
    act(store, run_id, TURN)
    store.save(run_id, 2)
    act(store, run_id, FLIP)
    store.commit(run_id, 3, 1)
    with pytest.raises(RunError, match="frame 2 cannot be restored: frames up to 3 are committed for good"):
        store.restore(run_id, 2)
    with pytest.raises(RunError, match="frame 3 cannot be saved: frames up to 3 are committed for good"):
        store.save(run_id, 3)
    with pytest.raises(RunError, match="no attempt at frame 3 can be committed"):
        store.commit(run_id, 3, 1)
    act(store, run_id, FOLD)
    assert store.restore(run_id, 3).pending == ()
    act(store, run_id, TURN)
    assert store.save(run_id, 4).complete
    assert store.restore(run_id, 3).base == 3


def test_attempts_from_a_replaced_chain_neither_count_nor_can_be_chosen(
    store: DirectStore, run_id: str
) -> None:
    act(store, run_id, TURN)
    store.save(run_id, 2)
    use_up(store, run_id, 3)
    store.restore(run_id, 1)
    act(store, run_id, FLIP)
    store.commit(run_id, 2, 2)
    with pytest.raises(RunError, match="attempt 1 at frame 3 grew from frames that a later commit"):
        store.commit(run_id, 3, 1)
    view = act(store, run_id, FOLD)
    assert (view.used(3), view.next_attempt, len(view.attempts[3])) == (1, 6, 6)


def test_the_last_frame_ends_the_run(store: DirectStore, run_id: str) -> None:
    for frame in (2, 3, 4):
        store.save(run_id, frame)
    with pytest.raises(RunError, match=r"frame 4 is the last one.*restore_checkpoint\(3\)"):
        store.act(run_id, TURN)
    with pytest.raises(RunError, match="there is no frame 5 in this sequence; its frames are 1 to 4"):
        store.save(run_id, 5)


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (0, "there is no frame 0 in this sequence; its frames are 1 to 4"),
        (99, "there is no frame 99 in this sequence"),
        (1, "frame 1 is the flat sheet and is saved already; the next to save is 3"),
        (
            2,
            r"frame 2 cannot be saved over checkpoint 2.*restore_checkpoint\(1\) to replace.* next to save is 3",
        ),
        (4, "frame 4 cannot be saved yet: the current state grew from checkpoint 2; the next to save is 3"),
    ],
)
def test_only_the_next_frame_can_be_saved(store: DirectStore, run_id: str, frame: int, words: str) -> None:
    before = store.save(run_id, 2)
    with pytest.raises(RunError, match=words):
        store.save(run_id, frame)
    assert store.load(run_id) == before


def test_refusals_name_what_there_is(store: DirectStore, run_id: str) -> None:
    with pytest.raises(RunError, match="frame 3 has no checkpoint to restore; saved frames: 1"):
        store.restore(run_id, 3)
    with pytest.raises(RunError, match="there is no attempt at frame 2; frames with attempts: none"):
        store.commit(run_id, 2, 1)
    act(store, run_id, TURN)
    with pytest.raises(RunError, match="there is no attempt 0 at frame 2; choose one from 1 to 1"):
        store.commit(run_id, 2, 0)


def test_a_free_fold_has_bookmarks_without_limit_and_no_attempts(store: DirectStore) -> None:
    view = store.create(sheet=(2.0, 1.0))
    run_id = view.run_id
    assert (view.base, view.budget, view.next_frame) == (1, None, 2)
    for _ in range(7):
        act(store, run_id, TURN)
        store.restore(run_id, 1)
    for frame in range(2, 9):
        act(store, run_id, FLIP)
        view = store.save(run_id, frame)
    assert (len(view.checkpoints), view.complete, dict(view.attempts)) == (8, False, {})
    view = act(store, run_id, FOLD)
    assert view.program().steps == ((FLIP,),) * 7
    assert view.current_program().steps == ((FLIP,),) * 7 + ((FOLD,),)
    assert view.program().sheet == (2.0, 1.0)
    with pytest.raises(RunError, match="a free fold has no attempts to commit"):
        store.commit(run_id, 2, 1)


def test_what_is_refused_after_it_was_recorded_is_taken_back(store: DirectStore, run_id: str) -> None:
    def act_and_refuse() -> None:
        with store.change(run_id) as change:
            assert change.act(TURN).pending == (TURN,)
            raise ActionRefused("the paper is too small for this")

    before = store.load(run_id)
    with pytest.raises(ActionRefused):
        act_and_refuse()
    assert store.load(run_id) == before
    assert act(store, run_id, FLIP).pending == (FLIP,)


def test_a_change_that_is_only_looked_at_changes_nothing(store: DirectStore, run_id: str) -> None:
    with store.change(run_id) as change:
        assert change.view.base == 1
    assert store.load(run_id).seq == change.view.seq


class TestRequestIds:
    """A call that was carried out and is sent again with its request id."""

    def test_every_change_is_carried_out_once_and_answered_alike(self, store: DirectStore) -> None:
        opened = store.create(sequence="cat", frames=3, request_id=request(0))
        run_id = opened.run_id
        calls: list[Callable[[], RunView]] = [
            lambda: store.save(run_id, 1, request_id=request(1)),
            lambda: store.act(run_id, TURN, request(2)),
            lambda: store.act(run_id, FOLD, request(3)),
            lambda: store.undo(run_id, request(4)),
            lambda: store.save(run_id, 2, "turned", request(5)),
            lambda: store.restore(run_id, 1, request(6)),
            lambda: store.commit(run_id, 2, 1, request_id=request(7)),
        ]
        answers = []
        for call in calls:
            answers.append(call())
            assert call() == answers[-1]
        store.forget()
        assert [call() for call in calls] == answers
        assert store.create(sequence="cat", frames=3, request_id=request(0)) == opened
        assert [each.seq for each in store.history(run_id)] == list(range(1, 9))
        assert len(store.list_runs()) == 1
        assert store.load(run_id) == answers[-1]

    def test_a_request_id_belongs_to_one_call(self, store: DirectStore, run_id: str) -> None:
        store.act(run_id, TURN, request(1))
        other = store.create(request_id=request(2)).run_id
        before = store.load(run_id)
        for call in (
            lambda: store.act(run_id, FLIP, request(1)),
            lambda: store.undo(run_id, request(1)),
            lambda: store.act(other, TURN, request(1)),
            lambda: store.create(request_id=request(1)),
            lambda: store.undo(other, request(2)),
            lambda: store.create(sequence="cat", frames=4, request_id=request(2)),
        ):
            with pytest.raises(RunError, match="was used by an earlier call with another tool or other arg"):
                call()
        assert store.load(run_id) == before
        assert len(store.list_runs()) == 2

    def test_a_refused_call_leaves_its_request_id_free(self, store: DirectStore, run_id: str) -> None:
        with pytest.raises(RunError, match="no action to undo"):
            store.undo(run_id, request(1))
        assert store.act(run_id, TURN, request(1)).pending == (TURN,)


def request(number: int) -> str:
    return str(UUID(int=number))


def test_a_changed_sequence_is_not_resumed(store: DirectStore, run_id: str) -> None:
    view = store.load(run_id)
    rules.check_same_sequence(view, "abc")
    with pytest.raises(RunError, match="its sequence 'cat' has changed"):
        rules.check_same_sequence(view, "abd")


@pytest.mark.parametrize(
    "bad", ["", "nothing", "../../etc/passwd", "20260101-000000-aaaaaaaaaa", "x" * 5000, "١" * 8]
)
def test_an_unknown_run_is_refused_in_one_short_sentence(store: DirectStore, bad: str) -> None:
    assert not store.exists(bad)
    for call in (store.load, store.undo, store.history):
        with pytest.raises(RunError, match="there is no run .* call open_run without run_id") as refusal:
            call(bad)
        assert len(str(refusal.value)) < 200


def test_values_that_could_not_be_read_back_are_refused(store: DirectStore, run_id: str) -> None:
    for action in (AddVertex(edge=(1, 2), position=float("nan")), Rotate(angle=float("inf"))):
        with pytest.raises(RunError, match="is not a finite number"):
            store.act(run_id, action)
    for notes in ("x" * 10_001, "\ud800"):
        with pytest.raises(RunError, match="the notes"):
            store.save(run_id, 2, notes=notes)
    assert store.save(run_id, 2, notes="a\x00b\n'\"é漢🦢").checkpoints[2].notes == "a\x00b\n'\"é漢🦢"
    store.forget()
    assert store.load(run_id).checkpoints[2].notes == "a\x00b\n'\"é漢🦢"


@pytest.mark.parametrize(
    "opening",
    [
        {"frames": 3},
        {"sequence": "cat", "frames": 0},
        {"sheet": (0.0, 1.0)},
        {"sheet": (1.0, float("nan"))},
        {"sequence": "cat", "frames": 3, "budget": 0},
    ],
)
def test_impossible_openings_are_refused(store: DirectStore, opening: dict[str, object]) -> None:
    with pytest.raises(RunError):
        store.create(**opening)  # type: ignore[arg-type]
    assert store.list_runs() == []


def test_runs_are_listed_newest_first_with_what_happened(store: DirectStore, run_id: str) -> None:
    free = store.create()
    listed = {run.run_id: (run.sequence, run.events) for run in store.list_runs()}
    assert listed == {run_id: ("cat", 2), free.run_id: (None, 1)}
    assert list(listed) == [free.run_id, run_id]
    assert [event.kind for event in store.history(run_id)] == ["opened", "saved"]
    assert store.exists(run_id)
