"""The baselines: random actions, and breadth-first search, on photographed paper with the real server."""

import asyncio
import json
from pathlib import Path

import pytest
from client_runs import events, program, shortened
from client_runs import sequence as plain
from client_runs import settings as plain_settings
from folding_client.baselines.search_moves import look_of, moves_from
from folding_client.progress import Silent
from folding_client.reconstruct import Outcome, new_job, reconstruct
from folding_client.record.event_log import read_events
from folding_client.record.replay import replay_run
from folding_client.settings import Settings
from folding_schemas.event_record import RunEventLine
from folding_schemas.state import FoldedState
from paths import ROOT
from pydantic import TypeAdapter

SQUARE = FoldedState(
    vertices={"1": (0, 0), "2": (1, 0), "3": (1, 1), "4": (0, 1)},
    faces={"1": [1, 2, 3, 4]},
    faces_orientations={"1": 0},
    edges=[(1, 2, "B"), (2, 3, "B"), (3, 4, "B"), (1, 4, "B")],
    layers=[[[1]]],
)


def reconstructed(sequence: Path, out: Path, settings: Settings) -> Outcome:
    return asyncio.run(reconstruct(new_job(sequence, out, settings), Silent()))


def test_random_actions_are_those_of_the_seed_and_each_changes_the_paper(tmp_path: Path) -> None:
    for name, seed in (("one", 1), ("again", 1), ("other", 2)):
        given = plain_settings(model="random", seed=seed)
        assert reconstructed(plain(3), tmp_path / name, given).status == "complete"
    one = program(tmp_path / "one")
    assert one == program(tmp_path / "again")
    assert one != program(tmp_path / "other")
    assert [step[-1]["action"] in {"fold", "unfold", "rotate", "flip"} for step in one] == [True] * 2
    assert json.loads((tmp_path / "one" / "run.json").read_text())["decided"]["2"] == "random"


@pytest.mark.slow
def test_a_record_of_random_actions_is_like_any_other_and_replays(tmp_path: Path) -> None:
    reconstructed(plain(2), tmp_path / "run", Settings(model="random"))
    line = TypeAdapter(RunEventLine)
    for event in read_events(tmp_path / "run" / "events.jsonl"):
        line.validate_python(event)
    assert asyncio.run(replay_run(tmp_path / "run")).differences == ()


def test_a_square_offers_motions_and_folds_through_corners_and_middles_of_edges_simplest_first() -> None:
    moves = list(moves_from(SQUARE))
    assert [move.tool for move in moves[:11]] == ["flip"] * 4 + ["rotate"] * 7
    folds = moves[11:]
    assert len(folds) == 2 * 8 * 7 / 2
    middles = [sum(isinstance(end, tuple) for end in move.ends) for move in folds]
    assert middles == sorted(middles)


def test_states_look_alike_whatever_their_vertices_are_called_but_not_turned_over() -> None:
    renamed = SQUARE.model_copy(
        update={
            "vertices": {str(9 - int(name)): place for name, place in SQUARE.vertices.items()},
            "faces": {"1": [8, 7, 6, 5]},
        }
    )
    flipped = SQUARE.model_copy(update={"faces_orientations": {"1": 1}})
    assert look_of(SQUARE) == look_of(renamed)
    assert look_of(SQUARE) != look_of(flipped)


@pytest.mark.slow
def test_the_search_finds_turn_and_folds_of_a_photographed_cat(tmp_path: Path) -> None:
    sequence = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 4)
    outcome = reconstructed(sequence, tmp_path / "run", Settings(model="search"))
    assert [fit["verdict"] for fit in outcome.run["fits"].values()] == ["MATCH"] * 3
    truth = json.loads((ROOT / "examples" / "cat" / "program.json").read_text())["steps"]
    found = [[action["action"] for action in step] for step in program(tmp_path / "run")]
    assert found == [[action["action"] for action in step] for step in truth[:3]]
    starts = [event for event in events(tmp_path / "run", "result") if event["name"] == "restore_checkpoint"]
    assert len(starts) == 3, "one attempt to search in, one to carry out what was found"


@pytest.mark.slow
def test_a_search_at_its_bounds_saves_what_agrees_best(tmp_path: Path) -> None:
    bounded = Settings(model="search", search_depth=1, search_tries=6)
    sequence = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 2)
    outcome = reconstructed(sequence, tmp_path / "run", bounded)
    assert outcome.status == "complete"
    compared = [event for event in events(tmp_path / "run", "result") if event["name"] == "compare_to_frame"]
    best = max(event["structured"]["agreement"] for event in compared)
    assert compared[-1]["structured"]["agreement"] == best
    assert all(event["images"] == [] for event in compared)
