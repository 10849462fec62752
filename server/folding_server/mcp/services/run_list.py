"""The runs there are, newest first: after a restart nothing else tells how to find one."""

from typing import TYPE_CHECKING

from folding_schemas.results import RunLine, RunList

from folding_server.mcp.context import AppContext

if TYPE_CHECKING:
    from folding_server.store.owners import RunSummary

MOST_LISTED = 100
"""The most runs in one list, and values in one completion, which is the protocol's own limit."""


def newest_runs(app: AppContext, most: int, before: str | None = None) -> RunList:
    """The caller's newest runs, or those opened before run ``before``.

    RunError if there is no such run, or the database cannot be used.
    """
    found = app.list_runs(most + 1, before)
    return RunList(runs=[_line(each) for each in found[:most]], more=len(found) > most)


def newest_ids(app: AppContext, most: int = MOST_LISTED) -> list[str]:
    """The ids of the caller's newest runs; of all where callers have no tokens."""
    return [each.run_id for each in app.list_runs(most)]


def _line(run: "RunSummary") -> RunLine:
    return RunLine(
        run_id=run.run_id,
        sequence=run.sequence,
        frames=run.frames,
        saved=run.saved,
        changed=run.changed.isoformat(timespec="seconds"),
        complete=run.complete,
    )
