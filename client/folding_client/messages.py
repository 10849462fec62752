"""What goes between the loop and a model: messages, tool calls, replies. Free of any provider's format."""

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from string import ascii_uppercase
from typing import Any, Literal

from folding_schemas.pictures import PictureRole

MessageRole = Literal["system", "user", "assistant", "tool"]
JsonObject = dict[str, Any]
Resolution = Literal["full", "medium", "small"]


@dataclass(frozen=True)
class Picture:
    """An encoded image. ``subject`` and ``frame`` say what it shows, so that a newer picture of the same thing can
    replace it; ``role`` says what kind of picture it is, None if its server did not say. A ``caption`` is told right
    before it. The ``resolution`` is that in which a model is to see it.
    """

    data: bytes = field(repr=False)
    mime: str
    subject: str = "picture"
    frame: int | None = None
    role: PictureRole | None = None
    caption: str = ""
    resolution: Resolution = "full"

    def named(self, caption: str) -> "Picture":
        """The picture with a caption."""
        return replace(self, caption=caption)

    def data_url(self) -> str:
        """The picture as a ``data:`` URL, the form that model providers take."""
        return f"data:{self.mime};base64,{base64.b64encode(self.data).decode('ascii')}"


@dataclass(frozen=True)
class ToolCall:
    """A call as the model wrote it: ``arguments`` is JSON text that nobody has checked yet."""

    id: str
    name: str
    arguments: str


@dataclass(frozen=True)
class ToolSpec:
    """A tool as it is offered to a model; ``schema`` is the JSON schema of its arguments."""

    name: str
    description: str
    schema: JsonObject
    read_only: bool = False


@dataclass(frozen=True)
class ToolResult:
    """What a call answered: a short text, data, pictures.

    ``told`` names the parts of the data that a model is told beside the summary, None for all of it; ``notes`` are
    sentences of the client's own that follow.
    """

    summary: str
    data: JsonObject | None = None
    pictures: tuple[Picture, ...] = ()
    is_error: bool = False
    told: tuple[str, ...] | None = None
    notes: tuple[str, ...] = ()

    @property
    def told_data(self) -> JsonObject:
        """The part of the data that a model is told."""
        data = self.data or {}
        return data if self.told is None else {name: data[name] for name in self.told if name in data}

    @property
    def text(self) -> str:
        """What a model reads: the summary, the data that it is told as JSON, the notes."""
        data = self.told_data
        return "\n".join(
            part for part in (self.summary, json_text(data) if data else "", *self.notes) if part
        )


@dataclass(frozen=True)
class Usage:
    """Tokens and price of one reply; ``cost`` in US dollars, None where no price is known."""

    input_tokens: int = 0
    output_tokens: int = 0
    cached_tokens: int = 0
    thinking_tokens: int = 0
    cost: float | None = None


NO_USAGE = Usage()


@dataclass(frozen=True)
class Reply:
    """A model's answer. ``native`` is the provider's own message, kept so that thinking blocks and thought
    signatures go back exactly as they came.
    """

    text: str = ""
    tool_calls: tuple[ToolCall, ...] = ()
    thinking: str = ""
    finish_reason: str = "stop"
    usage: Usage = NO_USAGE
    native: JsonObject | None = None


@dataclass(frozen=True)
class Message:
    """One entry of a conversation: what is ``said`` and ``shown``, or, for a tool message, the ``result`` of the call
    ``call_id`` of tool ``tool``. ``state`` is the part of what is said that tells the paper's state.
    """

    role: MessageRole
    said: str = ""
    shown: tuple[Picture, ...] = ()
    tool_calls: tuple[ToolCall, ...] = ()
    native: JsonObject | None = None
    call_id: str | None = None
    tool: str | None = None
    result: ToolResult | None = None
    state: str = ""

    @property
    def text(self) -> str:
        """What a model reads."""
        return self.said if self.result is None else self.result.text

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """What a model sees."""
        return self.shown if self.result is None else self.result.pictures

    def showing(self, pictures: "tuple[Picture, ...]", note: str) -> "Message":
        """The message with these pictures instead of its own, and a line that says so."""
        shown = self.showing_instead(pictures)
        if shown.result is None:
            return replace(shown, said=f"{self.said}\n{note}".strip())
        return replace(shown, result=replace(shown.result, notes=(*shown.result.notes, note)))

    def showing_instead(self, pictures: "tuple[Picture, ...]") -> "Message":
        """The message with these pictures instead of its own."""
        if self.result is None:
            return replace(self, shown=pictures)
        return replace(self, result=replace(self.result, pictures=pictures))

    @property
    def is_error(self) -> bool:
        """Whether this is the result of a call that was refused."""
        return self.result is not None and self.result.is_error


def system(text: str) -> Message:
    """What a model is and has."""
    return Message("system", text)


def user(text: str, pictures: tuple[Picture, ...] = ()) -> Message:
    """What a model is asked."""
    return Message("user", text, pictures)


def lettered(pictures: Sequence[Picture], diagrams: Resolution = "full") -> tuple[Picture, ...]:
    """Pictures with the captions A, B, C, ... and what each shows; ``diagrams`` are seen in that resolution."""
    seen = [replace(each, resolution=diagrams) if each.role == "diagram" else each for each in pictures]
    named = zip(ascii_uppercase, seen, strict=False)
    return tuple(picture.named(f"{letter}: {picture.subject}") for letter, picture in named)


def answered(reply: Reply) -> Message:
    """A reply as an entry of the conversation that it continues."""
    return Message("assistant", reply.text, tool_calls=reply.tool_calls, native=reply.native)


def tool_answer(call: ToolCall, result: ToolResult) -> Message:
    """A call's result as an entry of the conversation."""
    return Message("tool", call_id=call.id, tool=call.name, result=result)


def last_results(messages: Sequence[Message]) -> list[ToolResult] | None:
    """The results of the calls of the last reply; None if it called nothing, or there was no reply."""
    last = max((index for index, message in enumerate(messages) if message.role == "assistant"), default=None)
    if last is None or not messages[last].tool_calls:
        return None
    return [message.result for message in messages[last + 1 :] if message.result is not None]


def json_text(data: JsonObject) -> str:
    """Data as a model is told it: JSON without spaces."""
    return json.dumps(data, separators=(",", ":"), ensure_ascii=False)
