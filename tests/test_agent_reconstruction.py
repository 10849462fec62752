"""Whole reconstructions by a scripted provider: through litellm, real HTTP, and the real folding server."""

import json
import re
from pathlib import Path

import pytest
from client_runs import (
    ANCHOR,
    MATCH,
    MISMATCH,
    PLANTED_KEY,
    act,
    ask,
    calls,
    events,
    figure,
    program,
    restore,
    run,
    save,
    solved,
)
from folding_client.agent.tool_selection import PAPER_TOOLS
from folding_prompts import tool_description
from providers.anthropic import Anthropic
from providers.base import Provider, Says
from providers.gemini import Gemini
from providers.openai import OpenAI

MODEL = "litellm/openai/gpt-4o"
CAT = figure("d_cat")
DIAGONAL = {"action": "fold", "edge": [4, 2], "direction": -1}
OTHER_WAY = {"action": "fold", "edge": [4, 2], "direction": 1}
LOOK = Says(calls=[("get_current_state", {})])
OVERVIEW = Says(
    json.dumps(
        {
            "last_correct_frame": 4,
            "first_suspicious_frame": 5,
            "per_frame_notes": ["fine"],
            "recommendation": "Restore frame 4 and look at the ear again.",
        }
    )
)


def test_the_cat_is_reconstructed_with_a_match_at_every_step(tmp_path: Path) -> None:
    with OpenAI(save(1), *solved(CAT)) as provider:
        outcome = run(9, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert len(program(tmp_path / "run")) == 8
    assert [[action["action"] for action in step] for step in program(tmp_path / "run")] == [
        [action["action"] for action in step] for step in CAT
    ]
    assert [event["verdict"] for event in events(tmp_path / "run", "verdict")] == ["MATCH"] * 8
    totals = outcome.run["totals"]
    assert (totals["agent"]["queries"], totals["critic"]["queries"]) == (25, 8)
    assert totals["agent"]["input_tokens"] == 25_000
    assert totals["agent"]["cost"] == pytest.approx(25 * 0.003)


def test_the_critic_sees_four_pictures_in_order_and_both_states(tmp_path: Path) -> None:
    with OpenAI(save(1), act(CAT[0][0]), ask(2, "rotate"), MATCH, save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    seen = provider.received[3]["messages"][1]["content"]
    assert [part["type"] for part in seen] == ["text"] + ["text", "image_url"] * 4
    assert [part["text"] for part in seen[1::2]] == [
        "A: photo of frame 1",
        "B: photo of frame 2",
        "C: diagram of frame 1",
        "D: diagram of the candidate for frame 2",
    ]
    assert seen[0]["text"].count('"faces_orientations"') == 2
    (request,) = events(tmp_path / "run", "request")[3:4]
    assert [image["subject"] for image in request["new"][1]["images"]] == [
        "photo of frame 1",
        "photo of frame 2",
        "diagram of frame 1",
        "diagram of the candidate for frame 2",
    ]


def test_two_wrong_folds_are_taken_back_before_the_right_one(tmp_path: Path) -> None:
    wrong = [turn for _ in range(2) for turn in (act(OTHER_WAY), ask(3), MISMATCH, restore(2))]
    with OpenAI(save(1), *solved(CAT[:1]), *wrong, *solved(CAT[1:2], first=3)) as provider:
        outcome = run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run")[1] == [DIAGONAL]
    assert [event["verdict"] for event in events(tmp_path / "run", "verdict")] == [
        "MATCH",
        "MISMATCH",
        "MISMATCH",
        "MATCH",
    ]
    told = [message["content"] for message in provider.received[-1]["messages"] if message["role"] == "tool"]
    assert "flap 0.1 too long" in str(told)


@pytest.mark.slow
def test_a_mistake_noticed_later_is_traced_back_and_redone(tmp_path: Path) -> None:
    wrong_ear = [
        [
            {"action": "add_vertex", "edge": [1, 2], "position": 0.3},
            {"action": "fold", "edge": [5, 6], "direction": -1},
        ]
    ]
    second = [[{"action": "rotate", "angle": 5.0}]]
    look_back = Says(calls=[("generate_checkpoint_overview", {})])
    with OpenAI(
        save(1),
        *solved(CAT[:3]),
        *solved(wrong_ear, first=5),
        *solved(second, first=6),
        look_back,
        OVERVIEW,
        restore(4),
        *solved(CAT[3:6], first=5),
    ) as provider:
        outcome = run(7, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run")[3] == [{"action": "unfold"}]
    (overview,) = events(tmp_path / "run", "overview")
    assert (overview["last_correct_frame"], overview["first_suspicious_frame"]) == (4, 5)
    assert any("look at the ear again" in str(request["messages"]) for request in provider.received)


def test_three_failures_send_the_model_to_the_overview(tmp_path: Path) -> None:
    failing = [turn for _ in range(3) for turn in (act(OTHER_WAY), ask(2), MISMATCH, restore(1))]
    with OpenAI(save(1), *failing, act(DIAGONAL), ask(2), MATCH, save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    answers = [provider.received[number]["messages"][-1]["content"] for number in (4, 8, 12)]
    assert ["generate_checkpoint_overview" in answer for answer in answers] == [False, False, True]


def test_when_the_budget_is_spent_the_selector_chooses_and_earlier_frames_are_closed(tmp_path: Path) -> None:
    attempts = [
        turn
        for angle in (10, 20, 30, 40, 50)
        for turn in (act({"action": "rotate", "angle": angle}), ask(3, "rotate"), MISMATCH, restore(2))
    ]
    closed = Says(calls=[("restore_checkpoint", {"frame": 2})])
    with OpenAI(
        save(1),
        *solved(CAT[:1]),
        *attempts,
        Says("B4"),
        closed,
        *solved([[{"action": "flip", "axis": "x"}]], first=4),
    ) as provider:
        outcome = run(4, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run")[1] == [{"action": "rotate", "angle": 40.0}]
    (selected,) = events(tmp_path / "run", "selected")
    assert (selected["frame"], selected["attempt"], selected["by"]) == (3, 4, "model")
    refused = [
        event
        for event in events(tmp_path / "run", "result")
        if event["name"] == "restore_checkpoint" and event["is_error"]
    ]
    assert "committed for good" in refused[0]["text"]


@pytest.mark.parametrize(
    ("kind", "model"),
    [(Anthropic, "anthropic/claude-sonnet-4-5"), (Gemini, "gemini/gemini-3-pro-preview")],
    ids=["Anthropic", "Gemini"],
)
def test_other_providers_reconstruct_with_pictures_and_thinking(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: type[Provider], model: str
) -> None:
    for name in ("ANTHROPIC_API_KEY", "GEMINI_API_KEY"):
        monkeypatch.setenv(name, PLANTED_KEY)
    look = Says("", [("view_frame", {"frame": 1}), ("view_frame", {"frame": 2})], thinking="It was turned.")
    turn = Says("", [("rotate", {"angle": 45.0}), ("render_current", {})], thinking="By half a right angle.")
    with kind(save(1), look, turn, ask(2, "rotate"), MATCH, save(2)) as provider:
        outcome = run(2, tmp_path / "run", model=f"litellm/{model}", api_base=provider.url)
    assert outcome.status == "complete"
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 45.0}]]


def test_each_role_may_be_another_model(tmp_path: Path) -> None:
    with OpenAI(save(1), act(CAT[0][0]), ask(2, "rotate"), MATCH, save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, critic="litellm/openai/gpt-4o-mini", api_base=provider.url)
    assert [body["model"] for body in provider.received] == ["gpt-4o"] * 3 + ["gpt-4o-mini"] + ["gpt-4o"]


def test_overview_and_selector_may_be_other_models_too(tmp_path: Path) -> None:
    look_back = Says(calls=[("generate_checkpoint_overview", {})])
    attempts = [
        turn
        for angle in (10, 20, 30, 40, 50)
        for turn in (act({"action": "rotate", "angle": angle}), restore(1))
    ]
    others = {"overview": "litellm/openai/gpt-4.1", "selector": "litellm/openai/gpt-4.1-mini"}
    with OpenAI(save(1), look_back, OVERVIEW, *attempts, Says("B2")) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, **others)
    assert outcome.status == "complete"
    asked = [body["model"] for body in provider.received]
    assert [asked[2], asked[-1]] == ["gpt-4.1", "gpt-4.1-mini"]
    assert set(asked[:2] + asked[3:-1]) == {"gpt-4o"}
    assert outcome.run["models"] == {"agent": MODEL, "critic": MODEL, **others}
    assert outcome.run["decided"] == {"1": MODEL, "2": "selector (model)"}
    assert outcome.run["totals"].keys() == {"agent", "overview", "selector"}


def test_a_step_starts_from_a_fresh_context_with_a_summary(tmp_path: Path) -> None:
    with OpenAI(
        save(1),
        act(CAT[0][0]),
        Says(calls=[("save_checkpoint", {"frame": 2, "notes": "quarter turn"})]),
        act(DIAGONAL),
        save(3),
    ) as provider:
        run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    fresh = provider.received[3]["messages"]
    assert [message["role"] for message in fresh] == ["system", "user"]
    assert "Frame 2: rotate(45.0). Notes: quarter turn" in fresh[1]["content"][0]["text"]
    assert fresh[0] == provider.received[0]["messages"][0], "the prefix is the same in every step"


def test_calls_in_one_reply_run_in_order_and_in_one_context(tmp_path: Path) -> None:
    both = Says(
        calls=[
            *calls({"action": "add_vertex", "edge": [1, 2], "position": 0.5}),
            *calls({"action": "add_vertex", "edge": [4, 3], "position": 0.5}),
            *calls({"action": "fold", "edge": [5, 6], "direction": 1}),
            ("render_current", {}),
            ("observe_movement", {"frame": 2}),
        ]
    )
    with OpenAI(save(1), both, save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    roles = [message["role"] for message in provider.received[2]["messages"]]
    assert roles == ["system", "user", "assistant"] + ["tool"] * 5 + ["user"]
    assert sum(part["type"] == "image_url" for part in provider.received[2]["messages"][-1]["content"]) == 2


def test_no_key_is_ever_written(tmp_path: Path) -> None:
    leak = Says(
        f"My key is {PLANTED_KEY}", calls=[("save_checkpoint", {"frame": 1, "notes": f"key {PLANTED_KEY}"})]
    )
    with OpenAI(leak, act(CAT[0][0]), save(2)) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, server_url=None)
        assert provider.headers[0]["authorization"] == f"Bearer {PLANTED_KEY}"
    assert outcome.status == "complete"
    written = [file for file in (tmp_path / "run").rglob("*") if file.is_file()]
    assert {".json", ".jsonl", ".log", ".fold", ".sqlite3"} <= {file.suffix for file in written}
    assert [file for file in written if PLANTED_KEY.encode() in file.read_bytes()] == []


def test_an_anchor_is_asked_for_when_a_fold_is_judged(tmp_path: Path) -> None:
    bare = Says(calls=[("ask_critic", {"frame": 2, "action_classes": ["fold"]})])
    with OpenAI(save(1), act(DIAGONAL), bare, ask(2), MATCH, save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert "fold_anchor" in provider.received[3]["messages"][-1]["content"]
    assert ANCHOR["relationship"] in provider.received[4]["messages"][1]["content"][0]["text"]


def test_a_compound_needs_an_anchor_as_a_fold_does(tmp_path: Path) -> None:
    bare = Says(calls=[("ask_critic", {"frame": 2, "action_classes": ["compound"]})])
    anchored = {"frame": 2, "action_classes": ["compound"], "fold_anchor": ANCHOR}
    good = Says(calls=[("ask_critic", anchored)])
    with OpenAI(save(1), act(DIAGONAL), bare, good, MATCH, save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert "needs a fold_anchor when compound" in provider.received[3]["messages"][-1]["content"]


def test_a_step_opens_with_the_state_both_photos_and_the_labelled_diagram(tmp_path: Path) -> None:
    with OpenAI(save(1), act(CAT[0][0]), save(2), act(DIAGONAL), save(3)) as provider:
        run(3, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert isinstance(provider.received[0]["messages"][1]["content"], str), "frame 1 is the flat square"
    for query, frame in ((1, 2), (3, 3)):
        said, *parts = provider.received[query]["messages"][1]["content"]
        assert '"faces_orientations"' in said["text"]
        assert [part["type"] for part in parts] == ["text", "image_url"] * 3
        assert [part["text"] for part in parts[::2]] == [
            f"A: photo of frame {frame - 1}",
            f"B: photo of frame {frame}",
            "C: diagram of the current state",
        ]


def test_a_picture_is_sent_once_in_a_step_and_diagrams_of_earlier_states_stay_unless_asked_otherwise(
    tmp_path: Path,
) -> None:
    draw = Says(calls=[("render_current", {})])
    sent = {}
    for keep in (False, True):
        turns = [save(1), draw, draw, act(CAT[0][0]), draw, ask(2, "rotate"), MATCH, save(2)]
        with OpenAI(*turns) as provider:
            run(2, tmp_path / str(keep), model=MODEL, keep_images=keep, api_base=provider.url)
        sent[keep] = str(provider.received[-1]).count("data:image/")
    assert sent == {False: 3 + 2, True: 3 + 3 + 4}


def test_the_film_is_left_out_once_the_paper_has_moved_unless_images_are_kept(tmp_path: Path) -> None:
    sent = {}
    for keep in (False, True):
        turns = [save(1), Says(calls=[("observe_movement", {"frame": 2})]), LOOK, act(CAT[0][0]), save(2)]
        with OpenAI(*turns) as provider:
            run(2, tmp_path / str(keep), model=MODEL, keep_images=keep, api_base=provider.url)
        sent[keep] = [str(body).count("data:image/") for body in provider.received[2:]]
    assert sent == {False: [3 + 1, 3 + 1, 3 + 0], True: [3 + 1, 3 + 1, 3 + 1]}


def test_only_the_newest_state_is_told_in_full_unless_results_are_kept(tmp_path: Path) -> None:
    sent = {}
    for keep in (False, True):
        two = Says(calls=calls(*[{"action": "add_vertex", "edge": [1, 2], "position": 0.5}, CAT[0][0]]))
        with OpenAI(save(1), LOOK, two, LOOK, save(2)) as provider:
            run(2, tmp_path / str(keep), model=MODEL, keep_results=keep, api_base=provider.url)
        told = [str(body["messages"]).count('"vertices":') for body in provider.received]
        sent[keep] = [count - told[0] for count in told]
        answers = [
            message["content"] for message in provider.received[-1]["messages"] if message["role"] == "tool"
        ]
        assert all(answer.startswith(("Done: ", "4 vertices", "5 vertices")) for answer in answers)
        assert ("run_id" in str(answers)) is keep
    assert sent == {False: [0, 1, 1, 1, 1], True: [0, 1, 2, 4, 5]}


@pytest.mark.parametrize("tools", [None, "paper", "all"])
def test_the_system_prompt_says_of_every_tool_on_offer_what_it_is_for(
    tmp_path: Path, tools: str | None
) -> None:
    with OpenAI(save(1), act(CAT[0][0]), save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, tools=tools, api_base=provider.url)
    body = provider.received[0]
    described = {tool["function"]["name"]: tool["function"]["description"] for tool in body["tools"]}
    section = body["messages"][0]["content"].partition("# Tools")[2].partition("\n# ")[0]
    listed = dict(re.findall(r"^\* `(\w+)`: (.+)\.$", section, re.MULTILINE))
    assert listed.keys() == described.keys()
    assert all(described[name].startswith(line) for name, line in listed.items())
    assert described.keys() >= PAPER_TOOLS | {"ask_critic"}
    assert {None: 16, "paper": 14, "all": 25}[tools] == len(described)


def test_tools_that_are_not_on_offer_are_not_carried_out(tmp_path: Path) -> None:
    with OpenAI(save(1), Says(calls=[("undo", {})]), act(CAT[0][0]), save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, tools="paper", api_base=provider.url)
    assert "no tool 'undo'" in provider.received[2]["messages"][-1]["content"]


def test_descriptions_are_sent_in_brief_unless_asked_otherwise(tmp_path: Path) -> None:
    described = {}
    for full in (False, True):
        with OpenAI(save(1), act(CAT[0][0]), save(2)) as provider:
            run(2, tmp_path / str(full), model=MODEL, full_descriptions=full, api_base=provider.url)
        tools = {tool["function"]["name"]: tool["function"] for tool in provider.received[0]["tools"]}
        described[full] = tools["fold"]["description"]
    assert described[True] == tool_description("fold")
    assert described[False] == tool_description("fold").split("\n\n")[0].replace("\n", " ")
