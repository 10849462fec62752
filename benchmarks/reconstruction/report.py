"""Scores as one JSON document, or as a table."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich.box import SIMPLE
from rich.table import Table
from scoring import Overall, Score, overall

DIGITS = 6
COLUMNS = ("sequence", "frames", "done", "exact", "class", "line", "IoU", "s", "s max", "MB", "lost")


def document(settings: dict[str, Any], scores: Sequence[Score]) -> dict[str, Any]:
    """Settings, the overall figures and each sequence, as plain JSON values."""
    return {
        **settings,
        "overall": _plain(asdict(overall(scores))),
        "sequences": [_plain(asdict(score)) for score in scores],
    }


def in_words(score: Score) -> str:
    """One line on a sequence: exact, or where its paper stops being so, what was done there and found."""
    if score.lost_at is None:
        return f"{score.sequence}: exact in all {score.frames} frames"
    lost = score.transitions[score.lost_at - 2]
    found = score.reason or "nothing" if lost.found is None else "; ".join(lost.found) or "nothing"
    done = "; ".join(lost.true)
    return f"{score.sequence}: exact until frame {lost.frame}, where {done} was done and {found} found"


def table(title: str, scores: Sequence[Score]) -> Table:
    """One row a sequence and the overall figures below: seconds are the median and the worst."""
    shown = Table(title=title, box=SIMPLE, padding=(0, 1, 0, 0))
    for column in COLUMNS:
        first = column == "sequence"
        shown.add_column(column, justify="left" if first else "right", no_wrap=not first, overflow="fold")
    for score in scores:
        shown.add_row(*_row(score))
    shown.add_section()
    shown.add_row(*_last_row(overall(scores)))
    return shown


def _row(score: Score) -> tuple[str, ...]:
    return (
        score.sequence,
        str(score.frames),
        "yes" if score.completed else "no",
        "yes" if score.final_exact else "no",
        *_figures(score),
        str(score.lost_at or ""),
    )


def _last_row(total: Overall) -> tuple[str, ...]:
    return (
        f"{total.sequences} sequences",
        str(total.transitions + total.sequences),
        f"{total.completed:.1%}",
        f"{total.final_exact:.1%}",
        *_figures(total),
        "",
    )


def _figures(row: Score | Overall) -> tuple[str, ...]:
    return (
        f"{row.class_right:.1%}",
        _number(row.fold_line_error, 4),
        f"{row.silhouette_iou:.3f}",
        _number(row.seconds_median, 2),
        _number(row.seconds_max, 2),
        f"{row.memory_mb:.0f}",
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _plain(value: Any) -> Any:
    """The value with floats rounded."""
    if isinstance(value, float):
        return round(value, DIGITS)
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, list | tuple) else value
