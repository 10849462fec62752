"""Version 0003: a row for each run, with its owner and what a list of runs tells; what owners have used."""

import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from datetime import datetime
from itertools import groupby
from typing import Any

import sqlalchemy as sa
from alembic import op

from folding_server.store.run_events import EVENT
from folding_server.store.views import RecordDamaged, fold_events

revision = "0003"
down_revision = "0002"

_ROWS_AT_ONCE = 1000
"""How many rows are read or written at once, so that a large database needs little memory."""


def upgrade() -> None:
    """Make the tables and give each run that there is its row. They have no owner: there were none."""
    runs = _make_runs()
    op.create_table(
        "folding_vision",
        sa.Column("owner", sa.String(64), primary_key=True),
        sa.Column("day", sa.String(10), primary_key=True),
        sa.Column("seconds", sa.Float, nullable=False),
    )
    events = sa.text(
        "SELECT run_id, seq, time, kind, payload FROM folding_events ORDER BY run_id, seq"
    ).execution_options(yield_per=_ROWS_AT_ONCE)
    rows = []
    for run_id, of_run in groupby(op.get_bind().execute(events), key=lambda row: row.run_id):
        if (row := _run_row(run_id, list(of_run))) is not None:
            rows.append(row)
        if len(rows) >= _ROWS_AT_ONCE:
            op.bulk_insert(runs, rows)
            rows = []
    op.bulk_insert(runs, rows)


def _make_runs() -> sa.Table:
    runs = op.create_table(
        "folding_runs",
        sa.Column("run_id", sa.String(40), primary_key=True),
        sa.Column("owner", sa.String(64), nullable=True),
        sa.Column("sequence", sa.Text, nullable=True),
        sa.Column("frames", sa.Integer, nullable=False),
        sa.Column("opened", sa.String(40), nullable=False),
        sa.Column("changed", sa.String(40), nullable=False),
        sa.Column("events", sa.Integer, nullable=False),
        sa.Column("saved", sa.Integer, nullable=False),
        sa.Column("bytes", sa.BigInteger, nullable=False),
    )
    op.create_index("folding_runs_newest", "folding_runs", ["opened", "run_id"])
    op.create_index("folding_runs_newest_of_owner", "folding_runs", ["owner", "opened", "run_id"])
    return runs


def _run_row(run_id: str, events: Sequence[sa.Row[Any]]) -> dict[str, Any] | None:
    """The row of a run from the rows of its events; None for a record that is damaged at its beginning."""
    with suppress(ValueError, TypeError, LookupError):
        opened = json.loads(events[0].payload)
        return {
            "run_id": run_id,
            "owner": None,
            "sequence": opened["sequence"],
            "frames": opened["frames"],
            "opened": _sortable(events[0].time),
            "changed": _sortable(events[-1].time),
            "events": len(events),
            "saved": _saved(run_id, events),
            "bytes": sum(len(row.payload.encode()) for row in events),
        }
    return None


def _sortable(time: str) -> str:
    return datetime.fromisoformat(time).isoformat(timespec="microseconds")


def _saved(run_id: str, events: Iterable[sa.Row[Any]]) -> int:
    """How many frames are saved; 0 where the record is damaged, which reading the run then says."""
    try:
        view = fold_events(
            run_id,
            (
                EVENT.validate_python(
                    {"seq": row.seq, "time": row.time, "kind": row.kind, **json.loads(row.payload)}
                )
                for row in events
            ),
        )
    except (ValueError, TypeError, RecordDamaged):
        return 0
    return len(view.checkpoints) if view else 0
