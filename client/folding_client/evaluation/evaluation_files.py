"""An evaluation as files: JSON, CSV, curves."""

import csv
import io
from collections.abc import Iterable, Iterator
from pathlib import Path

from folding_schemas.evaluation import METRICS, EvaluationReport, GroupEvaluation

from folding_client.evaluation.progress_curves import Curve, curves_svg
from folding_client.record.folder import write_atomically
from folding_client.record.redaction import redact

SUMMARIES = {"last": "last", "last completed": "last_completed", "steps": "steps"}
"""What a line of ``summary.csv`` is over, and the member of a group that has it."""


def report_json(report: EvaluationReport) -> str:
    """The one document of ``--json``; the same for the same runs and truth."""
    return redact(report.model_dump_json(indent=1)) + "\n"


def write_evaluation(report: EvaluationReport, folder: Path) -> list[Path]:
    """Write ``evaluation.json``, ``summary.csv``, ``steps.csv`` and ``curves.svg`` into a folder; their paths."""
    texts = {
        "evaluation.json": report_json(report),
        "summary.csv": _csv(_summary_rows(report.groups)),
        "steps.csv": _csv(_step_rows(report.groups)),
        "curves.svg": curves_svg([Curve(group.label, group.progress) for group in report.groups]),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_atomically(folder / name, redact(text).encode("utf-8"))
    return [folder / name for name in texts]


def _csv(rows: Iterable[Iterable[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _summary_rows(groups: Iterable[GroupEvaluation]) -> Iterator[Iterable[object]]:
    yield (
        "model",
        "variant",
        "over",
        "planned",
        "completed",
        "metric",
        "count",
        "mean",
        "deviation",
        "low",
        "high",
    )
    for group in groups:
        for over, member in SUMMARIES.items():
            for metric, found in getattr(group, member).items():
                figures = found.count, found.mean, found.deviation, found.low, found.high
                yield group.model, group.variant, over, group.planned, group.completed, metric, *figures


def _step_rows(groups: Iterable[GroupEvaluation]) -> Iterator[Iterable[object]]:
    yield (
        *("model", "variant", "sequence", "run", "status", "frame", "action", "saved", "equal"),
        *METRICS,
        "problem",
    )
    for group in groups:
        for run in group.runs:
            for step in run.steps:
                about = group.model, group.variant, run.sequence, run.run, run.status
                place = step.frame, step.action_class, int(step.saved), int(step.equal)
                yield *about, *place, *(step.scores[metric] for metric in METRICS), step.problem
