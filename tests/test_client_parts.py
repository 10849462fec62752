"""The client's parts by themselves: reading verdicts, the context, the record, redaction, scripts,
batches.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from folding_client.agent.calls import checked_arguments
from folding_client.agent.context import StepContext
from folding_client.agent.context_compaction import ContextPolicy, without_repeated_pictures
from folding_client.agent.tool_selection import on_offer
from folding_client.batch.sequence_lists import sequences_of
from folding_client.interrupts import CallRefused, ReplyUnreadable, UsageError
from folding_client.messages import Message, Picture, ToolCall, ToolResult, ToolSpec, tool_answer, user
from folding_client.models.scripted import load_script
from folding_client.record.event_log import EventLog, read_events
from folding_client.record.folder import RunFolder
from folding_client.record.redaction import redact
from folding_client.roles.reply_parsing import CriticReply, OverviewReply, read_form, read_label
from folding_client.settings import ToolSet
from hypothesis import given
from hypothesis import strategies as st

GOOD = {"verdict": "MATCH", "analysis": "Same.", "anchor_check": "holds", "discrepancies": []}


def shown(*subjects: str) -> Message:
    """A tool result with pictures of these subjects."""
    pictures = tuple(Picture(subject.encode(), "image/png", subject) for subject in subjects)
    return tool_answer(ToolCall("1", "render_current", "{}"), ToolResult("seen", pictures=pictures))


WRONG = GOOD | {"verdict": "MISMATCH"}


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(GOOD),
        f"```json\n{json.dumps(GOOD)}\n```",
        f"  {json.dumps(GOOD)}\n",
        f"I compare {{D}} with B. {json.dumps(GOOD)} I am sure.",
        f"First I thought {json.dumps(WRONG)}, but:\n```\n{json.dumps(GOOD)}\n```",
        json.dumps(GOOD | {"verdict": "match"}),
        json.dumps(GOOD | {"verdict": " Exact_Match"}),
        json.dumps(GOOD | {"confidence": {"verdict": "MISMATCH"}}),
        json.dumps([GOOD]),
        json.dumps(GOOD | {"discrepancies": None, "anchor_check": None}),
        json.dumps(GOOD).replace("Same.", "Same.\nReally."),
    ],
    ids=[
        "bare",
        "fenced",
        "indented",
        "among words",
        "the last of two",
        "lower case",
        "exact match",
        "unknown key",
        "in a list",
        "null",
        "a line break in a string",
    ],
)
def test_a_verdict_is_read_from_the_last_json_object(text: str) -> None:
    form = read_form(CriticReply, text)
    assert form.verdict == "MATCH"
    assert form.discrepancies == []


@pytest.mark.parametrize("word", ["EXTREME DIVERGENCE", "extreme_divergence", "Extreme-Divergence"])
def test_a_verdict_of_two_words_is_read_however_they_are_joined(word: str) -> None:
    assert read_form(CriticReply, json.dumps(GOOD | {"verdict": word})).verdict == "EXTREME DIVERGENCE"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "MATCH",
        "It is a MATCH.",
        json.dumps(GOOD | {"verdict": "NO MATCH"}),
        json.dumps(GOOD | {"verdict": None}),
        json.dumps({"verdict": "MATCH"}),
        json.dumps(GOOD | {"discrepancies": "none"}),
        json.dumps({"answer": GOOD}),
        json.dumps(GOOD)[:-2],
        json.dumps(GOOD) + ' {"verdict": "PERFECT"}',
        "{" * 5000,
    ],
)
def test_anything_else_is_no_verdict(text: str) -> None:
    with pytest.raises(ReplyUnreadable) as refusal:
        read_form(CriticReply, text)
    assert refusal.value.text == text


@pytest.mark.parametrize(
    "text",
    [
        '{"recommendation": "start again", "per_frame_notes": null, "sure": true}',
        '{"last_correct_frame": null, "recommendation": "start again"}',
    ],
)
def test_an_overview_without_notes_is_read(text: str) -> None:
    assert read_form(OverviewReply, text).per_frame_notes == []


def test_an_overview_may_name_no_frame() -> None:
    form = read_form(
        OverviewReply,
        '{"last_correct_frame": null, "first_suspicious_frame": 1, "per_frame_notes": [],'
        ' "recommendation": "start again"}',
    )
    assert form.last_correct_frame is None


@pytest.mark.parametrize(
    ("text", "label"), [("B2", 2), ("B2.", 2), ("**B1**", 1), ("I choose B3, since B3 is best", 3)]
)
def test_a_single_label_is_read(text: str, label: int) -> None:
    assert read_label(text, 3) == label


@pytest.mark.parametrize("text", ["", "2", "B4", "B0", "B1 or B2", "b1", "AB1"])
def test_no_label_or_several_are_refused(text: str) -> None:
    with pytest.raises(ReplyUnreadable):
        read_label(text, 3)


@given(st.text())
def test_whatever_a_model_writes_is_read_or_refused(text: str) -> None:
    for read in (lambda: read_form(CriticReply, text), lambda: read_label(text, 5)):
        try:
            read()
        except ReplyUnreadable as refusal:
            assert str(refusal)


def test_a_picture_is_sent_where_it_was_shown_first() -> None:
    messages = [
        shown("photo of frame 1", "diagram"),
        shown("diagram"),
        user("and?"),
        shown("diagram", "photo of frame 2"),
    ]
    sent = without_repeated_pictures(messages)
    assert [[picture.subject for picture in message.pictures] for message in sent] == [
        ["photo of frame 1", "diagram"],
        [],
        [],
        ["photo of frame 2"],
    ]
    assert "Shown above already: diagram" in sent[1].text


@given(st.lists(st.lists(st.sampled_from("abcd"), max_size=3, unique=True), max_size=8))
def test_leaving_pictures_out_keeps_every_picture_and_message(groups: list[list[str]]) -> None:
    messages = [shown(*group) for group in groups]
    sent = without_repeated_pictures(messages)
    assert len(sent) == len(messages)
    kept = [picture.subject for message in sent for picture in message.pictures]
    assert sorted(kept) == sorted({subject for group in groups for subject in group})


def test_a_context_knows_what_was_sent_before() -> None:
    context = StepContext([user("one"), user("two")], ContextPolicy())
    assert context.to_send()[1] == 0
    context.append(user("three"))
    assert context.to_send()[1] == 2
    context.rewind(1)
    context.append(user("other"))
    assert context.to_send()[1] == 1


@given(
    st.dictionaries(
        st.sampled_from(["angle", "edge", "x"]), st.one_of(st.none(), st.booleans(), st.text(), st.floats())
    )
)
def test_arguments_pass_only_if_the_schema_takes_them(arguments: dict[str, object]) -> None:
    spec = ToolSpec(
        "rotate", "", {"type": "object", "properties": {"angle": {"type": "number"}}, "required": ["angle"]}
    )
    fits = set(arguments) == {"angle"} and isinstance(arguments["angle"], float)
    try:
        checked_arguments(ToolCall("1", "rotate", json.dumps(arguments)), {"rotate": spec})
    except CallRefused:
        assert not fits
    else:
        assert fits


def test_no_set_offers_tools_that_leave_the_run_or_tell_of_others() -> None:
    names = ("list_runs", "open_run", "get_run", "fold", "undo", "commit_attempt", "export_state")
    tools = [ToolSpec(name, "", {}) for name in names]
    offered = {which: [tool.name for tool in on_offer(tools, which)] for which in get_args(ToolSet)}
    assert offered == {
        "paper": ["fold"],
        "standard": ["fold", "undo"],
        "all": ["get_run", "fold", "undo", "export_state"],
    }


def test_a_log_goes_on_after_a_line_that_was_cut_off(tmp_path: Path) -> None:
    file = tmp_path / "events.jsonl"
    log = EventLog(file)
    log.append("opened", run="a")
    log.append("saved", frame=1)
    log.close()
    file.write_bytes(file.read_bytes() + b'{"seq": 3, "ki')
    assert [event["seq"] for event in read_events(file)] == [1, 2]
    log = EventLog(file)
    log.append("resumed")
    log.close()
    assert [(event["seq"], event["kind"]) for event in read_events(file)] == [
        (1, "opened"),
        (2, "saved"),
        (3, "resumed"),
    ]


@pytest.mark.parametrize("line", ["nonsense", "[1]", '{"seq": 2}', "\xff"])
def test_a_damaged_log_is_named_with_its_line(tmp_path: Path, line: str) -> None:
    (tmp_path / "events.jsonl").write_text(f'{{"seq": 1, "kind": "opened"}}\n{line}\n', encoding="latin-1")
    with pytest.raises(UsageError, match="Line 2"):
        list(read_events(tmp_path / "events.jsonl"))


def test_a_damaged_description_of_a_run_is_named_with_what_is_missing(tmp_path: Path) -> None:
    about = {"format": 1, "sequence": {}, "models": {}, "settings": {}}
    (tmp_path / "run.json").write_text(json.dumps(about))
    with pytest.raises(UsageError, match="says nothing of outcome, so the record is damaged"):
        RunFolder(tmp_path).description("settings", "outcome")


@given(st.text(min_size=8).filter(lambda text: text.strip() and "redacted" not in text))
def test_a_key_is_cut_out_as_it_stands_and_as_json(key: str) -> None:
    environment = {"SOME_API_KEY": key}
    assert key not in redact(f"before {key} after", environment).replace("before ", "").replace(" after", "")
    assert json.loads(redact(json.dumps({"notes": key}), environment))["notes"] != key


def test_what_looks_like_a_key_is_cut_out_too() -> None:
    text = redact("use sk-abcdefghij0123456789 or AIzaSyA0123456789abcdefghij", {})
    assert text == "use [redacted] or [redacted]"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("nonsense", "neither JSON"),
        ('[{"calls": [{"name": "fold"}]}]', "calls"),
        ('[{"texts": ""}]', "texts"),
    ],
)
def test_a_script_that_is_none_is_refused(tmp_path: Path, content: str, words: str) -> None:
    (tmp_path / "script.json").write_text(content)
    with pytest.raises(UsageError, match=words):
        load_script(tmp_path / "script.json", "agent")


def test_a_script_may_be_lines_and_speaks_in_roles(tmp_path: Path) -> None:
    (tmp_path / "script.jsonl").write_text('{"text": "a"}\n{"role": "critic", "text": "b"}\n')
    assert [reply.text for reply in load_script(tmp_path / "script.jsonl", "critic")] == ["b"]


def test_a_batch_s_sequences_come_from_a_folder_or_a_list(tmp_path: Path) -> None:
    for name in ("two", "one"):
        (tmp_path / "all" / name).mkdir(parents=True)
        (tmp_path / "all" / name / "keyframes.json").touch()
    (tmp_path / "list.txt").write_text("# mine\nall/two\n\n")
    assert [path.name for path in sequences_of(tmp_path / "all")] == ["one", "two"]
    assert [path.name for path in sequences_of(tmp_path / "list.txt")] == ["two"]
    with pytest.raises(UsageError, match="holds no sequence"):
        sequences_of(tmp_path)


def test_the_client_imports_neither_server_nor_geometry() -> None:
    code = (
        "import sys, folding_client.cli, folding_client.batch.cluster, folding_client.models.litellm_model; "
        "print([name for name in ('folding_server', 'cv2', 'shapely', 'litellm', 'distributed', 'inspect_ai', 'opentelemetry.sdk') if name in sys.modules])"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == "[]"
