"""What the client keeps of a tool's answer, and what a model is told of it."""

import base64
import json
from typing import Any

from folding_client.agent.context_compaction import compacted, without_old_states, without_repeated_pictures
from folding_client.messages import Message, Picture, ToolCall, ToolResult, tool_answer
from folding_client.protocol.tool_results import tool_result
from folding_schemas.pictures import PictureMeta
from hypothesis import given
from hypothesis import strategies as st
from mcp.types import CallToolResult, ImageContent, TextContent

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
DATA = st.dictionaries(st.text(), JSON, min_size=1, max_size=3)


def answer(*texts: str, data: dict[str, Any] | None, meta: dict[str, Any] | None = None) -> CallToolResult:
    """An answer with these texts, this data, and an image if there is a ``meta`` for it."""
    image = ImageContent(data=base64.b64encode(b"png").decode(), mime_type="image/png", _meta=meta)
    content = [*(TextContent(text=text) for text in texts), *([] if meta is None else [image])]
    return CallToolResult(content=content, structured_content=data)


@given(DATA, st.text().filter(lambda text: not text.lstrip().startswith("{")))
def test_the_summary_is_the_text_without_the_data_whatever_the_data_holds(
    data: dict[str, Any], summary: str
) -> None:
    kept = tool_result(answer(summary, json.dumps(data), data=data), "fold")
    assert (kept.summary, kept.data) == (summary, data)
    assert json.loads(kept.text.removeprefix(summary)) == data


def test_data_that_the_summary_quotes_is_still_told_once() -> None:
    data = {"a": 1}
    kept = tool_result(answer('The data is {"a":1}.', '{"a":1}', data=data), "fold")
    assert kept.text == 'The data is {"a":1}.\n{"a":1}'
    assert compacted("render_current", kept).text == 'The data is {"a":1}.'


def test_a_server_whose_only_text_is_the_data_has_no_summary() -> None:
    kept = tool_result(answer('{"a": 1.0}', data={"a": 1}), "fold")
    assert kept.summary == ""
    assert kept.text == '{"a":1}'


def test_texts_without_data_are_all_kept() -> None:
    assert tool_result(answer("One.", '{"a": 1}', data=None), "fold").text == 'One.\n{"a": 1}'


def test_a_picture_is_what_its_server_says_it_is() -> None:
    meta = PictureMeta(subject="photo of frame 3", frame=3, role="photo").to_meta()
    (picture,) = tool_result(answer("", data=None, meta={**meta, "other.org/x": 1}), "look").pictures
    assert picture == Picture(b"png", "image/png", "photo of frame 3", 3, "photo")


def test_a_picture_of_a_server_that_says_nothing_of_it_has_a_neutral_subject() -> None:
    for meta in ({}, {"other.org/x": 1}, {"foldingagent/subject": "photo", "foldingagent/role": "hologram"}):
        (picture,) = tool_result(answer("", data=None, meta=meta), "look").pictures
        assert picture == Picture(b"png", "image/png", "picture 1 of look")


def answered(tool: str, result: ToolResult) -> Message:
    """A tool's result in a conversation."""
    return tool_answer(ToolCall("1", tool, "{}"), result)


def test_notes_follow_what_is_left_of_the_data() -> None:
    result = ToolResult(
        "Back.", {"next_attempt": 4, "state": {"faces": 1}, "frame": 1}, notes=("Look around.",)
    )
    old, new = without_old_states(
        [answered("restore_checkpoint", compacted("restore_checkpoint", result))] * 2
    )
    assert old.text == "Back.\n(State left out: a newer one follows.)\nLook around."
    assert new.text == 'Back.\n{"next_attempt":4,"state":{"faces":1}}\nLook around.'
    assert old.result is not None
    assert old.result.data == result.data


def test_a_picture_is_shown_once_and_other_states_of_the_same_thing_stay() -> None:
    shown = [
        answered(
            "list_attempts",
            ToolResult(
                "Seen.",
                pictures=(Picture(drawn, "image/png", "diagram of the current state", None, "diagram"),),
            ),
        )
        for drawn in (b"flat", b"folded", b"folded")
    ]
    kept = without_repeated_pictures(shown)
    assert [len(message.pictures) for message in kept] == [1, 1, 0]
    assert kept[2].text == "Seen.\n(Shown above already: diagram of the current state.)"


def test_a_photo_is_known_by_its_frame_however_it_was_encoded() -> None:
    photos = [Picture(data, "image/jpeg", "photo of frame 2", 2, "photo") for data in (b"large", b"small")]
    shown = [answered("view_frame", ToolResult("Seen.", pictures=(photo,))) for photo in photos]
    assert [len(message.pictures) for message in without_repeated_pictures(shown)] == [1, 0]


def test_a_film_is_left_out_once_the_paper_has_moved() -> None:
    film = Picture(b"", "image/png", "filmstrip up to frame 2", 2, "filmstrip")
    seen, _ = without_repeated_pictures(
        [
            answered("observe_movement", ToolResult("Seen.", pictures=(film,))),
            answered("fold", ToolResult("Done.")),
        ]
    )
    assert seen.pictures == ()
    assert "since the paper has moved" in seen.text


def test_the_data_of_an_answer_with_pictures_is_the_json_in_its_text() -> None:
    kept = tool_result(answer("The frame.", '{"a": 1}', data=None, meta={}), "view_frame")
    assert (kept.summary, kept.data, len(kept.pictures)) == ("The frame.", {"a": 1}, 1)
    assert kept.text == 'The frame.\n{"a":1}'


def test_pictures_of_a_server_that_states_no_data_have_none() -> None:
    for texts in ((), ("A picture.",), ("A list.", "[1]")):
        kept = tool_result(answer(*texts, data=None, meta={}), "look")
        assert (kept.data, kept.text) == (None, "\n".join(texts))
