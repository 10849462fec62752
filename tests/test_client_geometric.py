"""The geometric model: on photographs with the real server, and its search on a small world of its own."""

import asyncio
import json
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from client_runs import events, program, shortened
from folding_client.interrupts import StepHopeless, UsageError
from folding_client.messages import Message, Reply, ToolResult, answered, tool_answer, user
from folding_client.models.geometric import GeometricModel
from folding_client.progress import Silent
from folding_client.reconstruct import new_job, reconstruct, resumed_job
from folding_client.record.folder import RunFolder
from folding_client.search.backtracking import best_trial
from folding_client.search.search_file import read_search, write_search
from folding_client.search.search_state import SearchState, Trial
from folding_client.settings import Settings
from folding_schemas.actions import Program, Rotate
from folding_schemas.results import Comparison, CreaseRefinement, Proposal, Proposals, RunInfo
from paths import ROOT

Angles = tuple[float, ...]


def test_the_first_folds_of_the_cat_are_found_without_any_model(tmp_path: Path) -> None:
    job = new_job(shortened(ROOT / "examples" / "cat", tmp_path / "cat", 4), tmp_path / "run", Settings())
    outcome = asyncio.run(reconstruct(job, Silent()))
    assert outcome.status == "complete"
    kinds = [
        [action["action"] for action in step if action["action"] != "add_vertex"]
        for step in program(tmp_path / "run")
    ]
    assert kinds == [["rotate"], ["fold"], ["fold"]]
    files = {
        "program.json",
        "final.fold",
        "crease_pattern.fold",
        "crease_pattern.svg",
        "checkpoints.json",
        "run.json",
    }
    assert files <= {file.name for file in (tmp_path / "run").iterdir()}
    checkpoints = json.loads((tmp_path / "run" / "checkpoints.json").read_text())
    assert [checkpoint["frame"] for checkpoint in checkpoints] == [1, 2, 3, 4]
    assert all("a match" in checkpoint["notes"] for checkpoint in checkpoints[1:])
    assert {event["name"] for event in events(tmp_path / "run", "call") if event["by"] == "agent"} >= {
        "propose_actions",
        "compare_to_frame",
        "save_checkpoint",
    }


def scripted(folder: Path, *replies: list[tuple[str, dict[str, Any]]], selector: Sequence[str] = ()) -> str:
    """A script of replies that call tools, and of what a selector says, as a model id."""
    entries: list[dict[str, Any]] = [
        {"calls": [{"tool": tool, "arguments": given} for tool, given in reply]} for reply in replies
    ]
    entries += [{"role": "selector", "text": text} for text in selector]
    (folder / "script.json").write_text(json.dumps(entries))
    return f"scripted:{folder / 'script.json'}"


@pytest.mark.slow
def test_geometry_selects_among_attempts_and_finds_the_first_wrong_frame(tmp_path: Path) -> None:
    tries = [
        [("rotate", {"angle": angle}), ("restore_checkpoint", {"frame": 1})] for angle in (10, 80, 45, 20, 30)
    ]
    model = scripted(
        tmp_path,
        [("save_checkpoint", {"frame": 1})],
        *tries,
        [("fold", {"edge": [4, 2], "direction": 1}), ("save_checkpoint", {"frame": 3})],
        [("generate_checkpoint_overview", {})],
    )
    roles = {"critic": "geometric", "overview": "geometric", "selector": "geometric"}
    sequence = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 4)
    job = new_job(sequence, tmp_path / "run", Settings(model=model, **roles))
    outcome = asyncio.run(reconstruct(job, Silent()))
    assert outcome.status == "stopped"
    (selected,) = events(tmp_path / "run", "selected")
    assert (selected["frame"], selected["attempt"], selected["by"]) == (2, 3, "geometric")
    (overview,) = events(tmp_path / "run", "overview")
    assert (overview["last_correct_frame"], overview["first_suspicious_frame"]) == (2, 3)
    assert program(tmp_path / "run")[0] == [{"action": "rotate", "angle": 45.0}]


@pytest.mark.slow
def test_a_selector_without_a_label_twice_leaves_the_choice_to_geometry_whatever_attempts_grew_from(
    tmp_path: Path,
) -> None:
    fold = ("fold", {"edge": [4, 2], "direction": -1})
    right = [("rotate", {"angle": 45.0}), ("save_checkpoint", {"frame": 2})]
    wrong = [("rotate", {"angle": 20.0}), ("save_checkpoint", {"frame": 2})]
    again = [[fold, ("restore_checkpoint", {"frame": 2})] for _ in range(5)]
    model = scripted(
        tmp_path,
        [("save_checkpoint", {"frame": 1})],
        right[:1],
        right[1:],
        [fold],
        [("restore_checkpoint", {"frame": 1})],
        wrong[:1],
        wrong[1:],
        *again,
        selector=("The first, or none.", "None."),
    )
    sequence = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 4)
    job = new_job(sequence, tmp_path / "run", Settings(model=model))
    asyncio.run(reconstruct(job, Silent()))
    (selected,) = events(tmp_path / "run", "selected")
    assert (selected["frame"], selected["attempt"], selected["by"]) == (3, 1, "geometric")
    assert "named no label, twice" in selected["reason"]
    assert [action["action"] for step in program(tmp_path / "run") for action in step] == ["rotate", "fold"]
    assert program(tmp_path / "run")[0] == [{"action": "rotate", "angle": 45.0}]


@dataclass
class World:
    """Tools over a run in which a state is the list of angles it was turned by.

    ``proposals`` gives by frame the angles on offer with the agreement foreseen; ``agreement`` what a
    comparison finds, by the frame and all angles so far, 0.5 if it is not listed; ``elsewhere`` what all photos together tell
    of an angle that was found.
    """

    proposals: dict[int, list[tuple[float, float]]]
    agreement: dict[tuple[int, Angles], float]
    elsewhere: dict[float, float] = field(default_factory=dict)
    steps: list[Angles] = field(default_factory=list)
    pending: Angles = ()
    base: int = 0
    used: dict[int, int] = field(default_factory=dict)
    budget: int = 5

    def call(self, tool: str, given: dict[str, Any]) -> ToolResult:
        """The answer of a tool."""
        return ToolResult("", getattr(self, tool)(**given))

    def get_run(self) -> dict[str, Any]:
        """Where the run stands."""
        done = tuple((Rotate(angle=angle),) for angle in (step[0] for step in self.steps))
        return RunInfo(
            run_id="r",
            sequence="s",
            frames=3,
            front_color="red",
            back_color="white",
            saved=list(range(1, len(self.steps) + 2)) if self.base else [],
            next_frame=self.base + 1,
            pending=[Rotate(angle=angle) for angle in self.pending],
            attempts=self.used,
            attempts_used=self.used,
            restores={},
            budget=self.budget,
            locked_to=0,
            complete=False,
            program=Program(steps=done),
        ).model_dump(mode="json")

    def propose_actions(self, frame: int, count: int) -> dict[str, Any]:
        """What is on offer."""
        found = [
            Proposal(
                rank=rank,
                action_class="rotate",
                actions=[Rotate(angle=angle)],
                agreement=agreement,
                score=agreement,
                explanation="",
            )
            for rank, (angle, agreement) in enumerate(self.proposals[frame][:count], start=1)
        ]
        return Proposals(frame=frame, proposals=found, confident=False).model_dump(mode="json")

    def rotate(self, angle: float) -> dict[str, Any]:
        """Turn, beginning an attempt if none is open."""
        if not self.pending:
            self.used[self.base + 1] = self.used.get(self.base + 1, 0) + 1
        self.pending = (*self.pending, angle)
        return {}

    def compare_to_frame(self, frame: int) -> dict[str, Any]:
        """How well the state agrees."""
        state = (*(angle for step in self.steps[: self.base - 1] for angle in step), *self.pending)
        found = self.agreement.get((frame, state), 0.5)
        return Comparison(
            frame=frame,
            verdict="MATCH" if found > 0.95 else "MISMATCH",
            agreement=found,
            iou={},
            outline_distance=0,
            shift=(0, 0, 0),
            discrepancies=[],
        ).model_dump(mode="json")

    def refine_creases(self, frame: int) -> dict[str, Any]:
        """Each step as all photos show it."""
        done = [*self.steps[: self.base - 1], self.pending]
        found = [tuple(self.elsewhere.get(angle, angle) for angle in step) for step in done]
        return CreaseRefinement(
            frame=frame,
            told=found != done,
            moved=0.01,
            steps=[[Rotate(angle=angle) for angle in step] for step in found],
        ).model_dump(mode="json")

    def save_checkpoint(self, frame: int, notes: str = "") -> dict[str, Any]:
        """Save, dropping what grew from the state replaced."""
        if frame > 1:
            self.steps = [*self.steps[: frame - 2], self.pending]
        self.base, self.pending = frame, ()
        return {"frame": frame, "notes": notes}

    def restore_checkpoint(self, frame: int) -> dict[str, Any]:
        """Go back."""
        self.base, self.pending = frame, ()
        return {}


class Killed(Exception):
    """The process of a model ended."""


async def solve(
    world: World, model: GeometricModel, queries: int = 60, cut: tuple[int, bool] = (0, False)
) -> list[Angles]:
    """Let a model work in a world until three frames are saved; a save starts a fresh context. It is killed at the
    reply of number ``cut``, before or after the reply's calls are made.
    """
    messages: list[Message] = [user("begin")]
    for number in range(1, queries + 1):
        reply: Reply = await model.query(messages, [])
        if cut == (number, False):
            raise Killed
        results = [(call, world.call(call.name, json.loads(call.arguments))) for call in reply.tool_calls]
        if cut == (number, True):
            raise Killed
        messages.append(answered(reply))
        messages += [tool_answer(call, result) for call, result in results]
        if any(call.name == "save_checkpoint" for call, _ in results):
            messages = [user("next")]
            if len(world.steps) == 2:
                return world.steps
    raise AssertionError("not solved")


def saved(
    proposals: dict[int, list[tuple[float, float]]], agreement: dict[tuple[int, Angles], float]
) -> tuple[list[Angles], World]:
    """What the model saves in a world, and the world."""
    world = World(proposals, agreement)
    return asyncio.run(solve(world, GeometricModel())), world


def test_a_match_is_saved_at_once() -> None:
    steps, world = saved(
        {2: [(10, 0.99), (20, 0.98)], 3: [(30, 0.99)]}, {(2, (10,)): 0.99, (3, (10, 30)): 0.99}
    )
    assert steps == [(10,), (30,)]
    assert world.used == {2: 1, 3: 1}


def test_the_next_best_proposal_is_tried_when_the_best_does_not_match() -> None:
    steps, world = saved(
        {2: [(10, 0.99), (20, 0.98)], 3: [(30, 0.99)]}, {(2, (20,)): 0.99, (3, (20, 30)): 0.99}
    )
    assert steps == [(20,), (30,)]
    assert world.used == {2: 2, 3: 1}


def test_a_later_frame_that_contradicts_sends_the_search_back_to_a_rival() -> None:
    steps, world = saved(
        {2: [(10, 0.99), (20, 0.985)], 3: [(30, 0.99)]},
        {(2, (10,)): 0.99, (2, (20,)): 0.985, (3, (10, 30)): 0.7, (3, (20, 30)): 0.99},
    )
    assert steps == [(20,), (30,)]
    assert world.used == {2: 2, 3: 2}


SENT_BACK = World(
    {2: [(10, 0.99), (20, 0.985)], 3: [(30, 0.99), (35, 0.98), (40, 0.97)]},
    {(2, (10,)): 0.99, (2, (20,)): 0.985, (3, (10, 30)): 0.9, (3, (10, 35)): 0.92, (3, (20, 30)): 0.6},
)
"""A world in which the search tries several explanations, goes back to a rival, and returns to what was best."""
SETTLED = World(
    {2: [(10, 0.99), (20, 0.985), (25, 0.98), (28, 0.97)], 3: [(30, 0.99)]},
    {
        (2, (10,)): 0.9,
        (2, (20,)): 0.91,
        (2, (25,)): 0.92,
        (2, (28,)): 0.99,
        **{(3, (angle, 30)): 0.97 for angle in (10, 20, 25, 28)},
    },
)
"""A world in which the search settles for the third try, whatever comes after it."""
REFINED = World(
    {2: [(10, 0.99)], 3: [(30, 0.99)]},
    {(2, (10,)): 0.98, (3, (10, 30)): 0.98, (2, (12,)): 0.99, (3, (12, 33)): 0.99},
    {10: 12, 30: 33},
)
"""A world in which all photos together tell that both steps were a little otherwise."""


def test_steps_are_done_again_as_all_photos_show_them_once() -> None:
    world = deepcopy(REFINED)
    assert asyncio.run(solve(world, GeometricModel())) == [(12,), (33,)]
    assert world.used == {2: 2, 3: 2}


def test_steps_for_which_no_attempt_is_left_stay_as_they_are() -> None:
    world = replace(deepcopy(REFINED), budget=1)
    assert asyncio.run(solve(world, GeometricModel())) == [(10,), (30,)]


def kept(state: SearchState) -> SearchState:
    """A state as it comes out of its file."""
    return SearchState.model_validate_json(state.model_dump_json(exclude_none=True))


def test_a_search_state_is_plain_data_that_comes_back_as_it_was() -> None:
    seen: list[SearchState] = []
    model = GeometricModel(keep=lambda state: seen.append(kept(state)))
    asyncio.run(solve(deepcopy(SENT_BACK), model))
    assert kept(model.state) == model.state == seen[-1]
    assert model.state.backtracks == {3: 1}
    assert len(model.state.trials) > 3
    assert {state.step.phase for state in seen if state.step} >= {"trying", "retrying", "moving", "saving"}
    assert len({len(state.trials) for state in seen}) == len(model.state.trials) + 1


@pytest.mark.parametrize("answered", [False, True], ids=["before its calls are made", "after they are made"])
@pytest.mark.parametrize(
    ("begun", "steps"),
    [(SENT_BACK, [(10,), (35,)]), (SETTLED, [(25,), (30,)]), (REFINED, [(12,), (33,)])],
    ids=["sent back", "settled", "refined"],
)
def test_a_search_killed_after_any_reply_goes_on_to_the_same_program(
    begun: World, steps: list[Angles], answered: bool
) -> None:
    whole = GeometricModel()
    assert asyncio.run(solve(deepcopy(begun), whole)) == steps
    for cut in range(1, whole.state.queries):
        world = replace(deepcopy(begun), budget=8)
        files: list[SearchState] = []
        model = GeometricModel(keep=lambda state, files=files: files.append(kept(state)))
        with pytest.raises(Killed):
            asyncio.run(solve(world, model, cut=(cut, answered)))
        world.pending = ()
        again = GeometricModel(state=files[-1])
        assert asyncio.run(solve(world, again)) == steps
        known = [trial for trial in again.state.trials if trial in files[-1].trials]
        assert known == files[-1].trials


def test_a_search_that_cannot_be_read_is_refused_with_its_file(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    assert read_search(folder) == SearchState()
    write_search(folder, SearchState(queries=3))
    assert read_search(folder).queries == 3
    (tmp_path / "search.json").write_text('{"format": 2}')
    with pytest.raises(UsageError, match=r"search\.json is not a search of format 1.*remove it"):
        read_search(folder)


@pytest.mark.slow
def test_a_resumed_run_does_not_ask_for_the_same_proposals_again(tmp_path: Path) -> None:
    sequence = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 2)
    job = new_job(sequence, tmp_path / "run", Settings(max_queries=5))
    assert asyncio.run(reconstruct(job, Silent())).status == "stopped"
    job = resumed_job(tmp_path / "run", None, Settings(max_queries=300))
    assert asyncio.run(reconstruct(job, Silent())).status == "complete"
    asked = [event["name"] for event in events(tmp_path / "run", "call") if event["by"] == "agent"]
    assert asked.count("propose_actions") == 1
    assert asked.count("save_checkpoint") == 2
    known = SearchState.model_validate_json((tmp_path / "run" / "search.json").read_bytes())
    assert [proposed.frame for proposed in known.proposed] == [2]
    assert [trial.matches for trial in known.trials] == [True]


def test_if_the_rival_explains_less_the_search_returns_to_the_better_path() -> None:
    steps, _ = saved(
        {2: [(10, 0.99), (20, 0.985)], 3: [(30, 0.99)]},
        {(2, (10,)): 0.99, (2, (20,)): 0.985, (3, (10, 30)): 0.9, (3, (20, 30)): 0.6},
    )
    assert steps == [(10,), (30,)]


def test_without_a_rival_the_best_of_what_was_tried_is_saved_with_a_note() -> None:
    steps, world = saved(
        {2: [(10, 0.99)], 3: [(30, 0.99), (40, 0.98), (50, 0.97)]},
        {(2, (10,)): 0.99, (3, (10, 30)): 0.6, (3, (10, 40)): 0.8, (3, (10, 50)): 0.7},
    )
    assert steps == [(10,), (40,)]
    assert world.used[3] <= 5


def test_what_grew_from_steps_that_are_no_longer_allowed_is_not_gone_back_to() -> None:
    chosen, given_up = ((Rotate(angle=10),),), ((Rotate(angle=20),),)
    state = SearchState(
        trials=[
            Trial(frame=3, lineage=given_up, actions=(Rotate(angle=30),), agreement=0.9, matches=False),
            Trial(frame=3, lineage=chosen, actions=(Rotate(angle=40),), agreement=0.8, matches=False),
        ]
    )
    world = World({}, {}, steps=[(10,)], base=2)
    open_run = RunInfo.model_validate(world.get_run())
    assert best_trial(state, open_run) == state.trials[0]
    assert best_trial(state, open_run.model_copy(update={"locked_to": 2})) == state.trials[1]


def test_proposals_far_below_the_best_are_not_tried() -> None:
    steps, world = saved(
        {2: [(10, 0.99), (20, 0.5)], 3: [(30, 0.99)]}, {(2, (20,)): 0.99, (3, (10, 30)): 0.99}
    )
    assert steps[0] == (10,)
    assert world.used[2] == 1


def test_without_any_proposal_the_search_says_so() -> None:
    with pytest.raises(StepHopeless, match="frame 2"):
        saved({2: [], 3: []}, {})


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_the_order_of_equal_proposals_does_not_decide_what_is_found(order: Sequence[int]) -> None:
    offered = [[(10.0, 0.99), (20.0, 0.99), (30.0, 0.99)][index] for index in order]
    agreement = {(2, (angle,)): 0.99 for angle, _ in offered} | {(3, (20.0, 5.0)): 0.99}
    steps, _ = saved({2: offered, 3: [(5.0, 0.99)]}, agreement)
    assert steps == [(20.0,), (5.0,)]
