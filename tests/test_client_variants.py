"""The paper's ablation variants, and solved examples in context, against a scripted provider."""

import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import ANCHOR, MATCH, MISMATCH, events, figure, program, resume, run
from folding_client.variants.few_shot import solved_examples
from providers.base import Says
from providers.openai import OpenAI

MODEL = "litellm/openai/gpt-4o"
CAT = figure("d_cat")
SQUARE = {
    "vertices_coords": [[0, 1], [1, 1], [1, 0], [0, 0]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0]],
    "edges_assignment": ["B", "B", "B", "B"],
}


def plan(*actions: dict[str, Any]) -> Says:
    """A plan for one step."""
    return Says(json.dumps({"reasoning": "It was turned.", "actions": actions}))


def turn(angle: float) -> Says:
    """A plan that rotates."""
    return plan({"action": "rotate", "angle": angle})


def with_diagonal(pattern: dict[str, Any]) -> dict[str, Any]:
    """A square with a valley along a diagonal."""
    return {
        **pattern,
        "edges_vertices": [*pattern["edges_vertices"], [0, 2]],
        "edges_assignment": [*pattern["edges_assignment"], "V"],
    }


def test_vlm_s_carries_out_one_plan_per_step(tmp_path: Path) -> None:
    with OpenAI(*[plan(*step) for step in CAT[:3]]) as provider:
        outcome = run(4, tmp_path / "run", model=MODEL, variant="vlm-s", api_base=provider.url)
    assert outcome.status == "complete"
    assert len(program(tmp_path / "run")) == 3
    assert outcome.run["decided"] == dict.fromkeys("1234", MODEL)
    assert all("tools" not in body for body in provider.received)
    parts = provider.received[1]["messages"][1]["content"]
    assert [part["type"] for part in parts] == ["text", "text", "image_url", "text", "image_url"]
    assert [part["text"] for part in parts[1::2]] == ["A: photo of frame 2", "B: photo of frame 3"]
    assert '"faces_orientations"' in parts[0]["text"]


def test_vlm_s_asks_once_more_for_a_plan_that_cannot_be_carried_out_then_stops(tmp_path: Path) -> None:
    impossible = plan({"action": "rotate", "angle": 10}, {"action": "fold", "edge": [1, 77], "direction": 1})
    with OpenAI(impossible, Says("I do not know.")) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, variant="vlm-s", api_base=provider.url)
    assert stopped.status == "stopped"
    assert "no plan for frame 2" in stopped.reason
    assert "77" in provider.received[1]["messages"][-1]["content"]
    with OpenAI(turn(45)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 45.0}]]


def test_vlm_s_c_gives_the_critic_s_words_back_and_saves_a_match(tmp_path: Path) -> None:
    with OpenAI(turn(10), MISMATCH, turn(45), MATCH) as provider:
        assert (
            run(2, tmp_path / "run", model=MODEL, variant="vlm-s-c", api_base=provider.url).status
            == "complete"
        )
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 45.0}]]
    words, diagram = provider.received[2]["messages"][-1]["content"]
    assert "flap 0.1 too long" in words["text"]
    assert diagram["type"] == "image_url"


def test_vlm_s_c_passes_the_anchor_to_the_critic(tmp_path: Path) -> None:
    fold = {"action": "fold", "edge": [4, 2], "direction": -1}
    planned = Says(json.dumps({"actions": [fold], "fold_anchor": ANCHOR}))
    with OpenAI(planned, MATCH) as provider:
        run(2, tmp_path / "run", model=MODEL, variant="vlm-s-c", api_base=provider.url)
    assert ANCHOR["relationship"] in provider.received[1]["messages"][1]["content"][0]["text"]


def test_vlm_s_c_lets_the_selector_choose_after_three_plans(tmp_path: Path) -> None:
    with OpenAI(turn(10), MISMATCH, turn(20), MISMATCH, turn(30), MISMATCH, Says("B2")) as provider:
        assert (
            run(2, tmp_path / "run", model=MODEL, variant="vlm-s-c", api_base=provider.url).status
            == "complete"
        )
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 20.0}]]
    (selected,) = events(tmp_path / "run", "selected")
    assert (selected["attempt"], selected["by"]) == (2, "model")


def test_vlm_cp_predicts_a_crease_pattern_for_every_frame(tmp_path: Path) -> None:
    with OpenAI(Says(json.dumps(SQUARE)), Says(json.dumps(with_diagonal(SQUARE)))) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, variant="vlm-cp", api_base=provider.url)
    assert outcome.status == "complete"
    assert outcome.run["outcome"]["frames_saved"] == 3
    assert outcome.run["decided"] == dict.fromkeys("23", MODEL)
    fold_file = json.loads((tmp_path / "run" / "crease_pattern.fold").read_text())
    assert fold_file["edges_assignment"] == ["B", "B", "B", "B", "V"]
    assert [
        frame["frame_title"]
        for frame in json.loads((tmp_path / "run" / "patterns.json").read_text())["patterns"]
    ] == ["frame 1", "frame 2", "frame 3"]
    assert not (tmp_path / "run" / "program.json").exists()


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({**SQUARE, "edges_assignment": ["B"]}, "4 edges have 1 assignments"),
        ({**SQUARE, "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 9]]}, "names a vertex that is not there"),
        ({**SQUARE, "edges_assignment": ["B", "B", "B", "X"]}, "edges_assignment.3"),
    ],
)
def test_vlm_cp_stops_at_patterns_that_do_not_fit_together_and_resumes(
    tmp_path: Path, broken: dict[str, Any], words: str
) -> None:
    with OpenAI(Says(json.dumps(SQUARE)), *[Says(json.dumps(broken))] * 2) as provider:
        stopped = run(3, tmp_path / "run", model=MODEL, variant="vlm-cp", api_base=provider.url)
    assert stopped.status == "stopped"
    assert words in stopped.reason
    with OpenAI(Says(json.dumps(with_diagonal(SQUARE)))) as provider:
        assert resume(tmp_path / "run", api_base=provider.url).status == "complete"
    assert "Crease pattern at frame 2" in provider.received[0]["messages"][1]["content"][0]["text"]


def test_few_shot_shows_three_solved_transitions_before_the_task(tmp_path: Path) -> None:
    with OpenAI(turn(45)) as provider:
        run(2, tmp_path / "run", model=MODEL, variant="vlm-s", few_shot=True, api_base=provider.url)
    messages = provider.received[0]["messages"]
    assert [message["role"] for message in messages] == ["system"] + ["user"] * 4
    assert ["Solved example" in message["content"][0]["text"] for message in messages[1:]] == [True] * 3 + [
        False
    ]


@pytest.mark.parametrize(
    ("variant", "key"), [("agent", '"actions"'), ("vlm-s", '"actions"'), ("vlm-cp", '"edges_assignment"')]
)
def test_examples_speak_the_variant_s_language(variant: Any, key: str) -> None:
    for example in solved_examples(variant):
        assert len(example.pictures) == 2
        assert key in example.text.split("Answer:")[1]
