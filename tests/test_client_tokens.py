"""Counting input tokens: the providers' published examples, and what each saving leaves out."""

import base64
import io
from pathlib import Path

import pytest
from client_runs import run, save
from folding_client.messages import (
    Message,
    Picture,
    Reply,
    ToolCall,
    ToolResult,
    ToolSpec,
    answered,
    system,
    tool_answer,
    user,
)
from PIL import Image
from providers.base import Says
from providers.openai import OpenAI
from token_counting import anthropic_tokens, openai_tokens, pieces, text_tokens
from token_trace import Query, script
from tokens import ALL, sent_with

TOOLS = (
    ToolSpec("view_frame", "Show a photo. It is small.\n\nMore.", {}),
    ToolSpec("propose_actions", "Propose.", {}),
    ToolSpec("undo", "Take back.", {}),
    ToolSpec("ask_critic", "Ask.", {}),
)
LISTED = (
    "* `view_frame`: Show a photo.\n* `propose_actions`: Propose.\n* `undo`: Take back.\n* `ask_critic`: Ask."
)
STATE = '{"run_id":"r","state":{}}'


@pytest.mark.parametrize(
    ("size", "tokens"), [((1024, 1024), 765), ((2048, 4096), 1105), ((512, 512), 255), ((768, 768), 765)]
)
def test_pictures_count_as_openai_says(size: tuple[int, int], tokens: int) -> None:
    assert openai_tokens(*size) == tokens


@pytest.mark.parametrize(("size", "tokens"), [((200, 200), 53), ((1000, 1000), 1333), ((4000, 4000), 1532)])
def test_pictures_count_as_anthropic_says(size: tuple[int, int], tokens: int) -> None:
    assert anthropic_tokens(*size) == tokens


def photo(subject: str) -> Picture:
    data = io.BytesIO()
    Image.new("RGB", (512, 512), (len(subject), 0, 0)).save(data, "PNG")
    return Picture(data.getvalue(), "image/png", subject)


def test_every_part_of_a_request_is_counted_once() -> None:
    picture = base64.b64encode(photo("").data).decode()
    body = {
        "tools": [{"function": {"name": "fold"}}],
        "messages": [
            {"role": "system", "content": "You fold."},
            {
                "role": "user",
                "content": [
                    {"type": "text", "text": "Look."},
                    {"type": "image_url", "image_url": {"url": f"data:image/png;base64,{picture}"}},
                ],
            },
            {
                "role": "assistant",
                "content": None,
                "tool_calls": [{"function": {"name": "flip", "arguments": "{}"}}],
            },
        ],
    }
    counted = [tokens["openai"] for _, tokens in pieces(body)]
    texts = [text_tokens(text) for text in ('{"name": "fold"}', "You fold.", "Look.", "", "flip{}")]
    assert counted == [texts[0], texts[1] + 4, texts[2] + 4, 255, texts[3] + 4, texts[4] + 4]


def said(call: str, *pictures: str) -> list[Message]:
    """A reply that calls a tool, and the result with its pictures."""
    made = ToolCall("c", call, "{}")
    result = ToolResult("Done.", {"run_id": "r", "state": {}}, tuple(map(photo, pictures)))
    return [answered(Reply(tool_calls=(made,))), tool_answer(made, result)]


def two_steps() -> list[Query]:
    """A first step of one query, and the two last queries of a second, with the critic's in between."""
    about = system(f"You fold.\n{LISTED}\nBe exact.")
    save = Reply(tool_calls=(ToolCall("c", "save_checkpoint", "{}"),))
    second = [about, user("Frame 1: flat square."), *said("render_current", "diagram"), *said("flip")]
    third = [
        *second,
        *said("ask_critic", "photo of frame 1"),
        *said("render_current", "diagram"),
        *said("flip"),
    ]
    return [
        Query("agent", (about, user("Begin.")), TOOLS, save),
        Query("agent", (about, user("Frame 1: flat square.")), TOOLS, save),
        Query("agent", tuple(second), TOOLS, save),
        Query(
            "critic", (system("You judge."), user("These.", (photo("photo of frame 1"),))), (), Reply("{}")
        ),
        Query("agent", tuple(third), TOOLS, save),
    ]


def shown(query: Query) -> list[list[str]]:
    return [[p.subject for p in message.pictures] for message in query.messages if message.role == "tool"]


def test_without_a_saving_the_conversation_goes_on_with_all_its_pictures() -> None:
    sent = list(sent_with(frozenset(), two_steps()))
    assert [len(query.messages) for query in sent] == [2, 5, 9, 2, 15]
    texts = [message.text for message in sent[1].messages]
    assert texts[1] == "Begin."
    assert texts[3] == "Saved."
    assert "(as above)" in texts[4]
    assert "flat square" not in texts[4]
    assert shown(sent[4])[1:] == [["diagram"], [], ["photo of frame 1"], ["diagram"], []]
    assert sent[4].messages[:9] == sent[2].messages


def test_each_saving_leaves_out_its_own() -> None:
    queries = two_steps()
    summary = list(sent_with(frozenset({"summary"}), queries))
    assert [query.messages for query in summary] == [query.messages for query in queries]
    repeated = list(sent_with(frozenset({"summary", "repeated_pictures"}), queries))
    assert shown(repeated[4]) == [["diagram"], [], ["photo of frame 1"], [], []]
    assert repeated[3].messages == queries[3].messages
    states = list(sent_with(frozenset({"summary", "old_states"}), queries))
    assert [STATE in message.text for message in states[4].messages] == [
        message.tool in ("render_current", "ask_critic") or index == 11
        for index, message in enumerate(states[4].messages)
    ]


def test_tools_and_answers_in_brief_are_savings_of_their_own() -> None:
    queries = two_steps()
    brief = list(sent_with(frozenset({"summary", "brief_answers"}), queries))
    told = [message.text for message in brief[4].messages if message.role == "tool"]
    assert told == ["Done.", 'Done.\n{"state":{}}', 'Done.\n{"state":{}}', "Done.", 'Done.\n{"state":{}}']
    described = list(sent_with(frozenset({"summary", "brief_descriptions"}), queries))
    assert described[0].tools[0].description == "Show a photo. It is small."
    standard = list(sent_with(ALL, queries))
    assert [tool.name for tool in standard[0].tools] == ["view_frame", "undo", "ask_critic"]
    assert "`propose_actions`" not in standard[0].messages[0].text
    paper = list(sent_with(ALL | {"paper_tools"}, queries))
    assert [tool.name for tool in paper[0].tools] == ["view_frame", "ask_critic"]
    assert "`undo`" not in paper[0].messages[0].text


def test_what_every_query_carries_stays_small(tmp_path: Path) -> None:
    turn = Says(calls=[("rotate", {"angle": 45.0})])
    with OpenAI(save(1), turn, save(2)) as provider:
        run(2, tmp_path / "run", model="litellm/openai/gpt-4o", api_base=provider.url)
    body = provider.received[0]
    fixed = pieces({"tools": body["tools"], "messages": body["messages"][:1]})
    assert sum(tokens["openai"] for _, tokens in fixed) <= 3000


def test_the_script_of_the_heart_is_140_queries_long() -> None:
    steps = [[{"action": "flip", "axis": "x"}]] * 15
    assert len(list(script(steps, again=True))) == 140
    assert len(list(script(steps, again=False))) == 95
