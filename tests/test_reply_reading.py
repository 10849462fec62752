"""Replies as they come: calls in the model's text, ids that are missing or come again, critics who do not keep to the form."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from client_runs import MATCH, act, ask, events, program, run, save
from folding_client.interrupts import ReplyUnreadable
from folding_client.messages import Message, ToolCall, system, user
from folding_client.models.litellm_model import LitellmModel
from folding_client.models.text_calls import calls_in, told_in_text
from folding_client.roles.reply_parsing import with_words
from folding_client.settings import Settings
from hypothesis import given
from hypothesis import strategies as st
from providers.base import Body, Says
from providers.gemini import Gemini
from providers.openai import OpenAI
from test_agent_providers import LOOK_AGAIN, LOOK_TWICE, VIEW, converse, keys

__all__ = ["keys"]
MODEL = "litellm/openai/gpt-4o"
TURN = {"action": "rotate", "angle": 45.0}
TOOLS = {"fold", "rotate"}
FOLD = ("fold", {"edge": [1, 2], "direction": 1})
CALL = '{"name": "fold", "arguments": {"edge": [1, 2], "direction": 1}}'


@pytest.mark.parametrize(
    "text",
    [
        f"<tool_call>{CALL}</tool_call>",
        f"I fold.\n<tool_call>\n{CALL}\n</tool_call>\nThen I look.",
        f"<tool_call>{CALL}",
        f"<function_call>{CALL}</function_call>",
        '<function=fold>{"edge": [1, 2], "direction": 1}</function>',
        f"[TOOL_CALLS][{CALL}]",
        f"<|python_tag|>{CALL}",
        f"I fold.\n```json\n{CALL}\n```",
        f"```\n[{CALL}]\n```",
        CALL,
        '{"tool": "fold", "parameters": {"edge": [1, 2], "direction": 1}}',
        '{"type": "function", "function": {"name": "fold", "arguments": "{\\"edge\\": [1, 2], \\"direction\\": 1}"}}',
    ],
)
def test_a_call_in_the_text_is_read_whatever_the_model_s_way(text: str) -> None:
    assert [(call.name, json.loads(call.arguments)) for call in calls_in(text, TOOLS, 1)] == [FOLD]


def test_several_calls_in_the_text_are_read_in_order() -> None:
    turn = '{"name": "rotate", "arguments": {"angle": 45}}'
    for text in (
        f"<tool_call>{CALL}</tool_call> and <tool_call>{turn}</tool_call>",
        f"<tool_call>{CALL}\n{turn}</tool_call>",
        f"```json\n{CALL}\n```\n```json\n{turn}\n```",
        f"[{CALL}, {turn}]",
    ):
        calls = calls_in(text, TOOLS, 7)
        assert [(call.id, call.name) for call in calls] == [("text_7", "fold"), ("text_8", "rotate")]


@pytest.mark.parametrize(
    "text",
    [
        "I would fold edge 1 to 2.",
        'The answer is {"name": "fold", "arguments": {}}.',
        '{"name": "burn", "arguments": {}}',
        '{"verdict": "MATCH", "analysis": "fold"}',
        "<tool_call>fold it</tool_call>",
        "```python\nfold(1, 2)\n```",
        "[1, 2]",
        '{"name": ["fold"]}',
    ],
)
def test_what_is_no_call_of_a_tool_on_offer_stays_text(text: str) -> None:
    assert calls_in(text, TOOLS, 1) == ()


@given(st.text(alphabet='<>{}[]"`:,tool_call namefds=\n') | st.text())
def test_whatever_a_model_writes_is_a_call_or_text(text: str) -> None:
    assert all(call.name in TOOLS for call in calls_in(text, TOOLS, 1))


def test_a_run_by_calls_in_text_comes_to_its_end(tmp_path: Path) -> None:
    def written(tool: str, **arguments: Any) -> Says:
        return Says(f'<tool_call>{{"name": "{tool}", "arguments": {json.dumps(arguments)}}}</tool_call>')

    turns = [
        written("save_checkpoint", frame=1),
        written("rotate", angle=45.0),
        written("save_checkpoint", frame=2),
    ]
    with OpenAI(*turns) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[TURN]]
    said, told = provider.received[2]["messages"][-2:]
    assert said["content"] == turns[1].text
    assert told["role"] == "user"
    assert told["content"].startswith("Result of rotate:\n")


def test_results_of_calls_in_text_are_told_together_and_others_are_left_alone() -> None:
    called = (ToolCall("text_1", "fold", "{}"), ToolCall("text_2", "rotate", "{}"))
    messages = [
        user("Fold."),
        Message("assistant", "My calls.", tool_calls=called),
        Message("tool", "Done.", call_id="text_1", tool="fold"),
        Message("tool", "Turned.", call_id="text_2", tool="rotate"),
    ]
    told = told_in_text(messages)
    assert [message.role for message in told] == ["user", "assistant", "user"]
    assert told[1].tool_calls == ()
    assert told[2].text == "Result of fold:\nDone.\n\nResult of rotate:\nTurned."
    native = [user("Fold."), Message("assistant", tool_calls=(ToolCall("call_1", "fold", "{}"),))]
    assert told_in_text(native) == native


class SameIds(OpenAI):
    """Numbers the calls of every reply anew, or not at all."""

    ids: tuple[str, ...] = ("", "")

    def answer(self, turn: Says, number: int) -> Body:
        completion = super().answer(turn, number)
        for call, same in zip(
            completion["choices"][0]["message"].get("tool_calls", []), self.ids, strict=False
        ):
            call["id"] = same
        return completion


@pytest.mark.parametrize("ids", [("", ""), ("call_0", "call_0"), ("call_0", "call_1")], ids=str)
def test_ids_that_are_missing_or_come_again_are_replaced(ids: tuple[str, str]) -> None:
    with SameIds(LOOK_TWICE, LOOK_TWICE, Says("A square.")) as provider:
        provider.ids = ids
        said, _ = asyncio.run(converse(provider, "openai/gpt-4o", 3, timeout=30))
    made = [call.id for reply in said for call in reply.tool_calls]
    assert len(set(made)) == 4
    assert all(made)
    answers = [
        message["tool_call_id"] for message in provider.received[2]["messages"] if message["role"] == "tool"
    ]
    assert answers == made


def test_a_gemini_s_signature_comes_back_although_the_id_was_replaced() -> None:
    with Gemini(LOOK_TWICE, LOOK_AGAIN, Says("A square.")) as provider:
        said, messages = asyncio.run(converse(provider, "gemini/gemini-3.1-pro-preview", 2, timeout=30))
        partner = LitellmModel(
            "litellm/gemini/gemini-3.1-pro-preview", Settings(api_base=provider.url), lambda *_: None
        )
        reply = asyncio.run(partner.query(messages, [VIEW]))
    assert reply.text == "A square."
    assert said[1].tool_calls


@pytest.mark.parametrize(
    ("model", "kind", "asked"),
    [
        ("openai/gpt-4o", OpenAI, True),
        ("openai/a-model-of-my-own", OpenAI, False),
        ("gemini/gemini-2.5-pro", Gemini, True),
    ],
)
def test_json_alone_is_asked_for_where_the_provider_has_it(model: str, kind: Any, asked: bool) -> None:
    with kind(Says("{}")) as provider:
        partner = LitellmModel(f"litellm/{model}", Settings(api_base=provider.url), lambda *_: None)
        asyncio.run(partner.query([system("Answer in JSON."), user("Now.")], [], json_mode=True))
    assert (
        "json"
        in str(provider.received[0].get("response_format") or provider.received[0].get("generationConfig"))
    ) is asked


def test_critics_are_asked_for_json_and_agents_are_not(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), ask(2, "rotate"), MATCH, save(2)) as provider:
        run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert ["response_format" in body for body in provider.received] == [False, False, False, True, False]


def test_a_verdict_that_cannot_be_read_twice_reaches_the_agent_in_the_critic_s_words(tmp_path: Path) -> None:
    words = "The left flap in D is a little longer than in B, but I would let it pass."
    with OpenAI(save(1), act(TURN), ask(2, "rotate"), Says("Fine."), Says(words), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    told = [message for message in provider.received[-1]["messages"] if message["role"] == "tool"][-1][
        "content"
    ]
    assert "NO VERDICT" in told
    assert words in told
    (verdict,) = events(tmp_path / "run", "verdict")
    assert verdict["verdict"] is None


def test_words_that_are_passed_on_are_not_endless() -> None:
    assert len(with_words("Unread.", "x" * 10**6)) < 5000
    assert with_words("Unread.", " \n") == "Unread."


def test_a_reply_without_choices_has_no_words() -> None:
    with OpenAI(Says(silent=True)) as provider:
        partner = LitellmModel(MODEL, Settings(api_base=provider.url), lambda *_: None)
        with pytest.raises(ReplyUnreadable) as unreadable:
            asyncio.run(partner.query([user("Now.")], []))
    assert unreadable.value.text == ""
