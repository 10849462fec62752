"""What was said and done in a run, as messages, outputs and events of Inspect (``inspect_ai``)."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from folding_client.exports.conversation import ChatEntry
from folding_client.exports.exported_run import ExportedRun, ModelTurn, ToolTurn, data_url, when

if TYPE_CHECKING:
    from inspect_ai.event import Event as InspectEvent
    from inspect_ai.event import ModelEvent, ToolEvent
    from inspect_ai.model import ChatMessage, ModelOutput, ModelUsage
    from inspect_ai.tool import ToolCall


def inspect_usage(totals: Mapping[str, Any]) -> "ModelUsage":
    """Tokens and price, of a reply or of a role in all."""
    from inspect_ai.model import ModelUsage

    return ModelUsage(
        input_tokens=totals["input_tokens"],
        output_tokens=totals["output_tokens"],
        total_tokens=totals["input_tokens"] + totals["output_tokens"],
        input_tokens_cache_read=totals["cached_tokens"],
        reasoning_tokens=totals["thinking_tokens"],
        total_cost=totals["cost"],
    )


def inspect_message(run: ExportedRun, said: ChatEntry, *, images: bool) -> "ChatMessage":
    """A message as Inspect has it; pictures as ``data:`` URLs."""
    from inspect_ai.model import (
        ChatMessageAssistant,
        ChatMessageSystem,
        ChatMessageTool,
        ChatMessageUser,
        ContentImage,
        ContentReasoning,
        ContentText,
    )

    urls = [data_url(run, picture) for picture in said.images] if images else []
    content: list[Any] = [ContentReasoning(reasoning=said.thinking)] if said.thinking else []
    content += [ContentText(text=said.text), *(ContentImage(image=url) for url in urls if url)]
    match said.role:
        case "system":
            return ChatMessageSystem(content=said.text)
        case "tool":
            return ChatMessageTool(content=content, tool_call_id=said.call_id, function=said.tool)
        case "assistant":
            calls = [_call(call) for call in said.calls]
            return ChatMessageAssistant(
                content=content, tool_calls=calls or None, model=run.model_of("agent")
            )
        case _:
            return ChatMessageUser(content=content)


def _call(call: Mapping[str, str]) -> "ToolCall":
    """A call as its model wrote it; arguments that are no JSON object are told as an error."""
    from inspect_ai.tool import ToolCall

    try:
        arguments = json.loads(call["arguments"] or "{}")
    except ValueError as error:
        return ToolCall(id=call["id"], function=call["name"], arguments={}, parse_error=str(error))
    fitting = arguments if isinstance(arguments, dict) else {"arguments": arguments}
    return ToolCall(id=call["id"], function=call["name"], arguments=fitting)


def last_output(run: ExportedRun) -> "ModelOutput":
    """What the agent replied last."""
    from inspect_ai.model import ModelOutput

    replies = [
        turn for turn in run.turns if isinstance(turn, ModelTurn) and turn.role == "agent" and turn.reply
    ]
    return _output(run, replies[-1]) if replies else ModelOutput(model=run.model_of("agent"))


def _output(run: ExportedRun, turn: ModelTurn) -> "ModelOutput":
    from inspect_ai.model import ChatCompletionChoice, ChatMessageAssistant, ModelOutput

    reply = turn.reply
    if reply is None or reply["kind"] == "unreadable":
        why = "the run was cut short" if reply is None else reply["reason"]
        return ModelOutput(model=run.model_of(turn.role), error=why)
    calls = [_call(call) for call in reply["calls"]]
    message = ChatMessageAssistant(content=reply["text"], tool_calls=calls or None)
    reason: Any = {"tool_calls": "tool_calls", "length": "max_tokens"}.get(reply["finish_reason"], "stop")
    return ModelOutput(
        model=run.model_of(turn.role),
        choices=[ChatCompletionChoice(message=message, stop_reason=reason)],
        usage=inspect_usage(reply["usage"]),
        time=reply["seconds"],
    )


def inspect_events(run: ExportedRun, *, images: bool) -> "Iterator[InspectEvent]":
    """Model events with the messages that were new to the conversation, and tool events, in order."""
    for turn in run.turns:
        yield _tool_event(turn) if isinstance(turn, ToolTurn) else _model_event(run, turn, images=images)


def _model_event(run: ExportedRun, turn: ModelTurn, *, images: bool) -> "ModelEvent":
    from inspect_ai.event import ModelEvent
    from inspect_ai.model import GenerateConfig

    new = [ChatEntry.of_message(entry) for entry in turn.request["new"]]
    return ModelEvent(
        timestamp=when(turn.request),
        model=run.model_of(turn.role),
        role=turn.role,
        input=[inspect_message(run, said, images=images) for said in new],
        tools=[],
        tool_choice="auto",
        config=GenerateConfig(),
        output=_output(run, turn),
        completed=when(turn.reply) if turn.reply else None,
    )


def _tool_event(turn: ToolTurn) -> "ToolEvent":
    from inspect_ai.event import ToolEvent
    from inspect_ai.tool import ToolCallError

    failed = turn.result is not None and turn.result["is_error"]
    return ToolEvent(
        timestamp=when(turn.call),
        id=turn.call["id"] or f"{turn.call['by']}_{turn.call['seq']}",
        function=turn.call["name"],
        arguments=turn.call["arguments"],
        result=turn.text,
        error=ToolCallError(type="unknown", message=turn.text) if failed else None,
        completed=when(turn.result) if turn.result else None,
        agent=turn.call["by"],
        failed=failed or None,
    )
