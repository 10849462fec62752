"""An evaluation as tables for people."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from folding_schemas.evaluation import (
    LOWER_IS_BETTER,
    METRICS,
    EvaluationReport,
    MetricName,
    Summary,
)

if TYPE_CHECKING:
    from rich.table import Table

BLIND_BELOW = 0.05
"""A metric that told less than this share of the states with a mistake from the truth is called blind to the mistake."""


def evaluation_tables(report: EvaluationReport) -> Iterator["Table"]:
    """Scores, first as denominators should be and then as the paper has them; classes of action; spending; endings."""
    count = len(report.sequences)
    yield _scores(report, f"Last frame, all {count} planned sequences", "last")
    yield _scores(report, "Last frame, completed sequences", "last_completed")
    yield _scores(report, "All frames, mean of each planned sequence", "steps")
    yield _classes(report)
    yield _spending(report)
    yield _endings(report)
    if report.blindness:
        yield _blindness(report.blindness)


def _new(title: str, *columns: str) -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if index else "left", overflow="fold")
    return table


def _scores(report: EvaluationReport, title: str, which: str) -> "Table":
    """Four lines a model: mean, standard deviation, and the interval of the mean."""
    table = _new(title, "model", "#Comp", *map(_head, METRICS))
    confidence = f"{report.configuration['confidence']:.0%}"
    for group in report.groups:
        found: Mapping[MetricName, Summary] = getattr(group, which)
        completed = f"{group.completed / group.planned:.0%}", f"{group.completed} of {group.planned}", "", ""
        lines = group.label, "  deviation", f"  {confidence} from", f"  {confidence} to"
        for line, share, member in zip(lines, completed, ("mean", "deviation", "low", "high"), strict=True):
            table.add_row(line, share, *(_figure(m, getattr(found[m], member)) for m in METRICS))
    return table


def _head(metric: MetricName) -> str:
    return f"{metric} {'↓' if metric in LOWER_IS_BETTER else '↑'}"


def _figure(metric: MetricName, value: float | None) -> str:
    return "-" if value is None else f"{value:.{0 if metric == 'CPD' else 2}f}"


def _classes(report: EvaluationReport) -> "Table":
    table = _new("Frames by what is done to come to them", "model", "action", "n", *map(_head, METRICS))
    for group in report.groups:
        for each in group.by_class:
            figures = (_figure(metric, each.scores[metric].mean) for metric in METRICS)
            table.add_row(group.label, each.action_class, str(each.steps), *figures)
    return table


def _spending(report: EvaluationReport) -> "Table":
    columns = ("queries", "input tokens", "output tokens", "dollars", "seconds")
    table = _new("Mean for each sequence with a run", "model", *columns)
    for group in report.groups:
        spent = group.spending
        table.add_row(
            group.label,
            _number(spent.queries),
            _number(spent.input_tokens),
            _number(spent.output_tokens),
            _number(spent.cost, 2),
            _number(spent.seconds, 1),
        )
    return table


def _number(found: Summary, digits: int = 0) -> str:
    return "-" if found.mean is None else f"{found.mean:,.{digits}f}"


def _endings(report: EvaluationReport) -> "Table":
    table = _new("How the runs ended", "model", "sequences", "status", "reason")
    for group in report.groups:
        for ending in group.endings:
            table.add_row(group.label, str(ending.sequences), ending.status, ending.reason)
    table.columns[3].justify = "left"
    return table


def _blindness(told: Mapping[str, Mapping[str, float]]) -> "Table":
    """What each metric does not see, by the measurement that is shipped."""
    table = _new("What a metric does not see, of states with one mistake", "metric", "blind to")
    for metric in METRICS:
        blind = [mistake for mistake, shares in told.items() if shares[metric] < BLIND_BELOW]
        table.add_row(metric, ", ".join(blind) or "nothing")
    table.columns[1].justify = "left"
    return table
