"""Recorded runs as logs of Inspect (``inspect_ai``): a log for each condition, a sample for each sequence."""

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any, Literal

from folding_client.batch.batch_entry import BatchEntry
from folding_client.exports.conversation import Said, agent_conversation
from folding_client.exports.recorded_run import ModelTurn, RecordedRun, ToolTurn, data_url, when
from folding_client.interrupts import UsageError

if TYPE_CHECKING:
    from inspect_ai.event import Event as InspectEvent
    from inspect_ai.log import EvalLog, EvalSample
    from inspect_ai.model import ChatMessage, ModelOutput, ModelUsage
    from inspect_ai.tool import ToolCall

InspectFormat = Literal["eval", "json"]
TASK = "folding"
"""What the logs call the task."""


def require_inspect() -> None:
    """UsageError if ``inspect_ai`` is not installed."""
    try:
        import inspect_ai.log  # noqa: F401
    except ImportError as error:
        message = (
            "Logs in Inspect's format need inspect_ai, which is not installed; install it with "
            "pip install 'foldingagent-mcp[logs]'."
        )
        raise UsageError(message) from error


def write_inspect_logs(
    runs: Iterable[RecordedRun], out: Path, kind: InspectFormat, *, images: bool
) -> list[Path]:
    """Write a log for each model, variant and seed; the files. UsageError without ``inspect_ai``."""
    require_inspect()
    from inspect_ai.log import write_eval_log

    out.mkdir(parents=True, exist_ok=True)
    files = []
    ordered = sorted(runs, key=lambda run: (*_condition(run.entry), run.entry.sequence))
    for condition, group in groupby(ordered, key=lambda run: _condition(run.entry)):
        name = "_".join(part for part in condition if part not in {"agent", "0"})
        file = out / f"{''.join(c if c.isalnum() or c in '._-' else '-' for c in name)}.{kind}"
        write_eval_log(eval_log(list(group), images=images), str(file), format=kind)
        files.append(file)
    return files


def _condition(entry: BatchEntry) -> tuple[str, str, str]:
    return entry.model, entry.variant, str(entry.seed)


def eval_log(runs: list[RecordedRun], *, images: bool) -> "EvalLog":
    """The log of runs of one condition."""
    from inspect_ai.log import (
        EvalConfig,
        EvalDataset,
        EvalLog,
        EvalMetric,
        EvalResults,
        EvalScore,
        EvalSpec,
        EvalStats,
    )

    about, entries = runs[0].about, [run.entry for run in runs]
    samples = [_sample(run, images=images) for run in runs]
    means = {name: fmean(_scores(entry)[name] for entry in entries) for name in _scores(entries[0])}
    return EvalLog(
        status="success",
        eval=EvalSpec(
            created=about["created"],
            task=TASK,
            task_args={"variant": entries[0].variant, "seed": entries[0].seed},
            model=entries[0].model,
            dataset=EvalDataset(
                name="sequences", samples=len(runs), sample_ids=[each.sequence for each in entries]
            ),
            config=EvalConfig(),
            packages={name: str(version) for name, version in about["versions"].items()},
            metadata={"settings": about["settings"]},
        ),
        results=EvalResults(
            total_samples=len(runs),
            completed_samples=sum(entry.status == "complete" for entry in entries),
            scores=[
                EvalScore(name=name, scorer=name, metrics={"mean": EvalMetric(name="mean", value=value)})
                for name, value in means.items()
            ],
        ),
        stats=EvalStats(
            started_at=min(sample.started_at for sample in samples if sample.started_at),
            completed_at=max(sample.completed_at for sample in samples if sample.completed_at),
        ),
        samples=samples,
    )


def _scores(entry: BatchEntry) -> dict[str, float]:
    """What a run says of itself: shares of the frames saved, and of the steps found to match."""
    return {
        "saved": entry.frames_saved / entry.frames if entry.frames else 0.0,
        "matching": entry.matching / entry.steps if entry.steps else 0.0,
    }


def _sample(run: RecordedRun, *, images: bool) -> "EvalSample":
    from inspect_ai.log import EvalSample
    from inspect_ai.scorer import Score

    entry, about = run.entry, run.about
    scores: dict[str, Score] = {name: Score(value=value) for name, value in _scores(entry).items()}
    usage = {name: _usage(totals) for name, totals in about.get("totals", {}).items()}
    return EvalSample(
        id=entry.sequence,
        epoch=1,
        input=f"Reconstruct the {entry.frames} keyframes of {entry.sequence}.",
        target="",
        messages=[_message(run, said, images=images) for said in agent_conversation(run)],
        output=_last_output(run),
        scores=scores,
        events=list(_events(run, images=images)),
        role_usage=usage,
        started_at=None if run.first is None else run.first.isoformat(),
        completed_at=None if run.last is None else run.last.isoformat(),
        total_time=entry.seconds,
        uuid=about.get("run_id"),
        metadata={
            "run": str(run.folder),
            "status": entry.status,
            "reason": entry.reason,
            "decided": about.get("decided", {}),
            "fits": about.get("fits", {}),
            "tally": about.get("tally", {}),
            "cost": entry.cost,
        },
    )


def _usage(totals: Mapping[str, Any]) -> "ModelUsage":
    from inspect_ai.model import ModelUsage

    return ModelUsage(
        input_tokens=totals["input_tokens"],
        output_tokens=totals["output_tokens"],
        total_tokens=totals["input_tokens"] + totals["output_tokens"],
        input_tokens_cache_read=totals["cached_tokens"],
        reasoning_tokens=totals["thinking_tokens"],
        total_cost=totals["cost"],
    )


def _message(run: RecordedRun, said: Said, *, images: bool) -> "ChatMessage":
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


def _last_output(run: RecordedRun) -> "ModelOutput":
    from inspect_ai.model import ModelOutput

    replies = [
        turn for turn in run.turns if isinstance(turn, ModelTurn) and turn.role == "agent" and turn.reply
    ]
    return _output(run, replies[-1]) if replies else ModelOutput(model=run.model_of("agent"))


def _output(run: RecordedRun, turn: ModelTurn) -> "ModelOutput":
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
        usage=_usage(reply["usage"]),
        time=reply["seconds"],
    )


def _events(run: RecordedRun, *, images: bool) -> "Iterator[InspectEvent]":
    """Model events with the messages that were new to the conversation, and tool events, in order."""
    from inspect_ai.event import ModelEvent, ToolEvent
    from inspect_ai.model import GenerateConfig
    from inspect_ai.tool import ToolCallError

    for turn in run.turns:
        if isinstance(turn, ModelTurn):
            new = [Said.of_message(entry) for entry in turn.request["new"]]
            yield ModelEvent(
                timestamp=when(turn.request),
                model=run.model_of(turn.role),
                role=turn.role,
                input=[_message(run, said, images=images) for said in new],
                tools=[],
                tool_choice="auto",
                config=GenerateConfig(),
                output=_output(run, turn),
                completed=when(turn.reply) if turn.reply else None,
            )
        else:
            failed = turn.result is not None and turn.result["is_error"]
            yield ToolEvent(
                timestamp=when(turn.call),
                id=_tool_id(turn),
                function=turn.call["name"],
                arguments=turn.call["arguments"],
                result=turn.text,
                error=ToolCallError(type="unknown", message=turn.text) if failed else None,
                completed=when(turn.result) if turn.result else None,
                agent=turn.call["by"],
                failed=failed or None,
            )


def _tool_id(turn: ToolTurn) -> str:
    return turn.call["id"] or f"{turn.call['by']}_{turn.call['seq']}"
