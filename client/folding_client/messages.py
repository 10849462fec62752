"""What goes between the loop and a model: messages, tool calls, replies. Free of any provider's format."""

import base64
from dataclasses import dataclass, field
from typing import Any, Literal

Role = Literal["system", "user", "assistant", "tool"]
JsonObject = dict[str, Any]


@dataclass(frozen=True)
class Picture:
    """An encoded image; ``subject`` says what it shows, so that a newer picture of the same thing can replace
    it.
    """

    data: bytes = field(repr=False)
    mime: str
    subject: str = "picture"

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
    """What a call answered: text and pictures for a model, and the same as data for a program. ``detail`` is
    the part of the text that states the data.
    """

    text: str
    structured: JsonObject | None = None
    pictures: tuple[Picture, ...] = ()
    is_error: bool = False
    detail: str = ""


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
    """One entry of a conversation. A tool message answers the call ``call_id`` of tool ``tool``; ``detail`` is
    the part of its text that states the result's data.
    """

    role: Role
    text: str = ""
    pictures: tuple[Picture, ...] = ()
    tool_calls: tuple[ToolCall, ...] = ()
    call_id: str | None = None
    tool: str | None = None
    structured: JsonObject | None = None
    is_error: bool = False
    native: JsonObject | None = None
    detail: str = ""


def system(text: str) -> Message:
    """What a model is and has."""
    return Message("system", text)


def user(text: str, pictures: tuple[Picture, ...] = ()) -> Message:
    """What a model is asked."""
    return Message("user", text, pictures)


def answered(reply: Reply) -> Message:
    """A reply as an entry of the conversation that it continues."""
    return Message("assistant", reply.text, tool_calls=reply.tool_calls, native=reply.native)


def tool_answer(call: ToolCall, result: ToolResult) -> Message:
    """A call's result as an entry of the conversation."""
    return Message(
        "tool",
        result.text,
        result.pictures,
        call_id=call.id,
        tool=call.name,
        structured=result.structured,
        is_error=result.is_error,
        detail=result.detail,
    )
