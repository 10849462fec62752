"""What a query of the agent leaves out of its step so far, and what it shows smaller."""

import io
from typing import Any

import pytest
from folding_client.agent.context import StepContext
from folding_client.agent.context_compaction import ContextPolicy
from folding_client.messages import (
    Message,
    Picture,
    Reply,
    ToolCall,
    ToolResult,
    answered,
    lettered,
    system,
    tool_answer,
    user,
)
from folding_client.models.chat_format import chat_messages, dialect_of
from folding_client.models.litellm_model import entry_of
from folding_client.models.picture_limits import pictures_at_most
from folding_client.models.picture_sizes import in_its_resolution
from PIL import Image

STATE = '{"vertices":{"1":[0.0,1.0]}}'


def picture(subject: str, role: str, frame: int | None, side: int) -> Picture:
    encoded = io.BytesIO()
    Image.new("RGB", (side, side), (side % 255, 90, 120)).save(encoded, "PNG")
    return Picture(encoded.getvalue(), "image/png", subject, frame, role)  # type: ignore[arg-type]


BEFORE, TARGET = picture("photo of frame 2", "photo", 2, 40), picture("photo of frame 3", "photo", 3, 44)
OLD, NEW = (picture("diagram of the current state", "diagram", None, side) for side in (48, 52))


def called(tool: str, data: dict[str, Any] | None = None, *pictures: Picture) -> list[Message]:
    """A reply that calls a tool, and its answer."""
    call = ToolCall(tool, tool, "{}")
    told = () if data is None or "critic_verdict" in data else ("state",)
    return [
        answered(Reply(tool_calls=(call,))),
        tool_answer(call, ToolResult("Done.", data, pictures, told=told)),
    ]


def sent(*messages: Message) -> list[Message]:
    """The messages as they go out with the next query, of a step that opens with state, photos and diagram."""
    opened = Message("user", f"The state:\n{STATE}", lettered([BEFORE, TARGET, OLD]), state=STATE)
    context = StepContext([system("You fold."), opened], ContextPolicy())
    for message in messages:
        context.append(message)
    return context.to_send()[0]


def resolutions(message: Message) -> dict[str, str]:
    return {each.subject: each.resolution for each in message.pictures}


FOLDED = called("fold", {"state": {"vertices": {"1": [0.5, 1.0]}}})
DRAWN = called("render_current", {"size": 52}, NEW)


def test_until_the_paper_moves_a_step_is_shown_as_it_opened() -> None:
    messages = sent(*called("view_frame", None, BEFORE))
    assert resolutions(messages[1]) == {
        "photo of frame 2": "medium",
        "photo of frame 3": "full",
        "diagram of the current state": "medium",
    }
    assert messages[-1].pictures == ()
    assert "Shown above already" in messages[-1].text


def test_a_state_that_has_changed_is_told_by_the_last_that_tells_it() -> None:
    messages = sent(*FOLDED, *called("get_current_state", {"state": {"vertices": {"1": [0.5, 1.0]}}}))
    assert [("vertices" in message.text) for message in messages if message.role != "assistant"] == [
        False,
        False,
        False,
        True,
    ]


def test_once_the_moved_paper_is_drawn_what_shows_it_as_it_was_is_small() -> None:
    assert set(resolutions(sent(*FOLDED)[1]).values()) == {"medium", "full"}
    messages = sent(*FOLDED, *DRAWN)
    assert resolutions(messages[1]) == {
        "photo of frame 2": "small",
        "photo of frame 3": "full",
        "diagram of the current state": "small",
    }
    assert "Small now, since the paper has moved: photo of frame 2" in messages[1].text
    assert resolutions(messages[-1]) == {"diagram of the current state": "medium"}


def test_a_photo_that_is_small_is_shown_larger_when_it_is_asked_for_again() -> None:
    messages = sent(*FOLDED, *DRAWN, *called("view_frame", None, BEFORE))
    assert resolutions(messages[-1]) == {"photo of frame 2": "medium"}


@pytest.mark.parametrize("tool", ["undo", "restore_checkpoint"])
def test_back_where_the_step_began_its_pictures_are_as_they_were(tool: str) -> None:
    messages = sent(*FOLDED, *DRAWN, *called(tool, {"state": {"vertices": {"1": [0.0, 1.0]}}}))
    assert "small" not in resolutions(messages[1]).values()


@pytest.mark.parametrize(("verdict", "shown"), [("MATCH", 0), ("MISMATCH", 1)])
def test_a_match_is_told_without_the_pictures_that_the_critic_saw(verdict: str, shown: int) -> None:
    candidate = picture("diagram of the candidate for frame 3", "diagram", 3, 56)
    messages = sent(*FOLDED, *DRAWN, *called("ask_critic", {"critic_verdict": verdict}, candidate))
    assert len(messages[-1].pictures) == shown


def test_a_small_picture_has_half_the_width_and_height() -> None:
    small = in_its_resolution(lettered([OLD], diagrams="small")[0])
    with Image.open(io.BytesIO(small.data)) as image:
        assert (image.size, small.mime) == ((24, 24), "image/jpeg")
    assert in_its_resolution(OLD) is OLD


@pytest.mark.parametrize(
    ("model", "details"),
    [
        ("openai/gpt-4o", [None, None, "low"]),
        ("gemini/gemini-3.1-pro-preview", [None, "medium", "low"]),
        ("anthropic/claude-sonnet-4-5", [None, None, None]),
    ],
)
def test_a_provider_is_asked_for_the_resolutions_that_it_has_words_for(
    model: str, details: list[str | None]
) -> None:
    shown = (OLD, *lettered([OLD], "medium"), *lettered([OLD], "small"))
    (message,) = chat_messages([user("Look.", shown)], dialect_of(entry_of(model)))
    images = [part["image_url"] for part in message["content"] if part["type"] == "image_url"]
    assert [image.get("detail") for image in images] == details


def test_for_a_model_of_one_picture_those_of_a_message_are_joined_under_their_captions() -> None:
    messages = [user("Then.", (OLD,)), user("Compare these.", lettered([BEFORE, TARGET, OLD]))]
    then, (*_, compared) = pictures_at_most(messages, 1)[0], pictures_at_most(messages, 1)
    assert then.pictures == ()
    (sheet,) = compared.pictures
    assert sheet.subject == "A: photo of frame 2; B: photo of frame 3; C: diagram of the current state"
    assert "Side by side in one picture" in compared.text
    with Image.open(io.BytesIO(sheet.data)) as image:
        corner = image.convert("RGB").getpixel((20, 40))
    assert isinstance(corner, tuple)
    assert abs(corner[0] - 40) < 12
    assert abs(corner[1] - 90) < 12
