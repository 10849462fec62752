"""What a provider answered, through litellm, as a reply of ours."""

import secrets
from collections.abc import Collection, Sequence
from typing import Any

from folding_client.interrupts import ReplyUnreadable
from folding_client.messages import Message, Reply, ToolCall, ToolSpec, Usage
from folding_client.models.chat_format import held_by
from folding_client.models.text_calls import calls_in

_UNREADABLE = frozenset({"malformed_function_call", "MALFORMED_FUNCTION_CALL", "UNEXPECTED_TOOL_CALL"})
_ID_BYTES = 5
_ID_LENGTH = 9
"""Of ids of our own: nine letters or digits are what Mistral asks for, and no provider minds."""


def read_reply(response: Any, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> Reply:  # noqa: ANN401
    """The reply to ``messages``. ReplyUnreadable if there is none, or its provider could not read it.

    Calls that the model wrote into its text are calls like others. An id of a call that is missing, or was there before in
    the conversation, is replaced by one of our own.
    """
    if not response.choices:
        message = "the provider's answer holds no reply"
        raise ReplyUnreadable(message, _usage(response))
    choice = response.choices[0]
    reason = choice.finish_reason or "stop"
    fields = getattr(choice, "provider_specific_fields", None) or {}
    if reason in _UNREADABLE or fields.get("native_finish_reason") in _UNREADABLE:
        message = "the model wrote a tool call that its provider could not read"
        raise ReplyUnreadable(message, _usage(response))
    native = choice.message.model_dump(exclude_none=True)
    text = native.get("content") or ""
    known = [call.id for message in messages for call in message.tool_calls]
    calls = _calls(native, known) or calls_in(text, {tool.name for tool in tools}, len(known) + 1)
    return Reply(
        text, calls, native.get("reasoning_content") or "", reason, _usage(response), held_by(native)
    )


def _calls(native: dict[str, Any], known: Collection[str]) -> tuple[ToolCall, ...]:
    seen = set(known)
    calls = []
    for entry in native.get("tool_calls") or []:
        function = entry.get("function") or {}
        call_id = entry.get("id") or ""
        if not call_id or call_id in seen:
            call_id = secrets.token_hex(_ID_BYTES)[:_ID_LENGTH]
        seen.add(call_id)
        calls.append(ToolCall(call_id, function.get("name") or "", function.get("arguments") or "{}"))
    return tuple(calls)


def _usage(response: Any) -> Usage:  # noqa: ANN401
    usage = getattr(response, "usage", None)
    if usage is None:
        return Usage()
    read = getattr(usage, "prompt_tokens_details", None)
    written = getattr(usage, "completion_tokens_details", None)
    return Usage(
        usage.prompt_tokens or 0,
        usage.completion_tokens or 0,
        getattr(read, "cached_tokens", None) or 0,
        getattr(written, "reasoning_tokens", None) or 0,
        _cost(response),
    )


def _cost(response: Any) -> float | None:  # noqa: ANN401
    """The price by litellm's list; None for a model that is not on it."""
    cost = getattr(response, "_hidden_params", {}).get("response_cost")
    return None if cost is None else float(cost)
