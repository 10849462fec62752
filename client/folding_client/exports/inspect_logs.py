"""Recorded runs as logs of Inspect (``inspect_ai``): a log for each condition, a sample for each sequence."""

from collections.abc import Iterable
from itertools import groupby
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Literal

from folding_client.batch.batch_entry import BatchEntry
from folding_client.exports.conversation import agent_conversation
from folding_client.exports.exported_run import ExportedRun
from folding_client.exports.inspect_messages import (
    inspect_events,
    inspect_message,
    inspect_usage,
    last_output,
)
from folding_client.interrupts import UsageError

if TYPE_CHECKING:
    from inspect_ai.log import EvalLog, EvalResults, EvalSample, EvalSpec, EvalStats

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
    runs: Iterable[ExportedRun], out: Path, kind: InspectFormat, *, images: bool
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


def eval_log(runs: list[ExportedRun], *, images: bool) -> "EvalLog":
    """The log of runs of one condition."""
    from inspect_ai.log import EvalLog

    samples = [_sample(run, images=images) for run in runs]
    return EvalLog(
        status="success",
        eval=_spec(runs),
        results=_results([run.entry for run in runs]),
        stats=_stats(samples),
        samples=samples,
    )


def _spec(runs: list[ExportedRun]) -> "EvalSpec":
    """What was run: the condition, the sequences, the versions."""
    from inspect_ai.log import EvalConfig, EvalDataset, EvalSpec

    about, entries = runs[0].about, [run.entry for run in runs]
    return EvalSpec(
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
    )


def _results(entries: list[BatchEntry]) -> "EvalResults":
    """How many runs are complete, and the means of their scores."""
    from inspect_ai.log import EvalMetric, EvalResults, EvalScore

    scores = []
    for name in _scores(entries[0]):
        mean = EvalMetric(name="mean", value=fmean(_scores(entry)[name] for entry in entries))
        scores.append(EvalScore(name=name, scorer=name, metrics={"mean": mean}))
    complete = sum(entry.status == "complete" for entry in entries)
    return EvalResults(total_samples=len(entries), completed_samples=complete, scores=scores)


def _stats(samples: "list[EvalSample]") -> "EvalStats":
    """When the first run began and the last ended."""
    from inspect_ai.log import EvalStats

    return EvalStats(
        started_at=min((each.started_at for each in samples if each.started_at), default=""),
        completed_at=max((each.completed_at for each in samples if each.completed_at), default=""),
    )


def _scores(entry: BatchEntry) -> dict[str, float]:
    """What a run says of itself: shares of the frames saved, and of the steps found to match."""
    return {
        "saved": entry.frames_saved / entry.frames if entry.frames else 0.0,
        "matching": entry.matching / entry.steps if entry.steps else 0.0,
    }


def _sample(run: ExportedRun, *, images: bool) -> "EvalSample":
    from inspect_ai.log import EvalSample
    from inspect_ai.scorer import Score

    entry, about = run.entry, run.about
    scores: dict[str, Score] = {name: Score(value=value) for name, value in _scores(entry).items()}
    usage = {name: inspect_usage(totals) for name, totals in about.get("totals", {}).items()}
    return EvalSample(
        id=entry.sequence,
        epoch=1,
        input=f"Reconstruct the {entry.frames} keyframes of {entry.sequence}.",
        target="",
        messages=[inspect_message(run, said, images=images) for said in agent_conversation(run)],
        output=last_output(run),
        scores=scores,
        events=list(inspect_events(run, images=images)),
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
