"""Runs: which sequences there are, opening and resuming a run, and where a run stands."""

from typing import Annotated

from folding_schemas.attempt_limits import MOST_ATTEMPTS
from folding_schemas.results import RunInfo, RunList, SequenceInfo, SequenceList
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context, request_id_of
from folding_server.mcp.parameters import READ_WHOLE, RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.allowing import ALLOWING
from folding_server.mcp.services.run_addresses import checkpoint_links, file_links
from folding_server.mcp.services.run_list import MOST_LISTED, newest_runs
from folding_server.mcp.services.run_status import next_step, run_info
from folding_server.mcp.tool_record import ADDS, LOOKS, tool

OptionalSequence = Annotated[
    str | None, Field(description="the name of a sequence, as list_sequences shows it")
]
ResumedId = Annotated[str | None, Field(description="the id of an earlier run to take up again")]
OptionalAttempts = Annotated[
    int | None,
    Field(
        ge=1,
        le=MOST_ATTEMPTS,
        description="attempts at each frame of a new run, from 1 to 20",
    ),
    READ_WHOLE,
]
Most = Annotated[
    int,
    Field(ge=1, le=MOST_LISTED, description=f"how many runs to list, from 1 to {MOST_LISTED}; left out, 20"),
    READ_WHOLE,
]
Before = Annotated[
    str | None,
    Field(description="the run_id of a run: runs opened before it are listed; left out, the newest are"),
]


@tool("List sequences", LOOKS, icons.RUN_ICON, within="paper")
def list_sequences(ctx: ToolContext) -> Annotated[CallToolResult, SequenceList]:
    """List the sequences that can be opened."""
    found = sequence_list(app_context(ctx))
    names = ", ".join(f"{each.name} ({each.frames} frames)" for each in found.sequences)
    text = (
        f"Sequences: {names}." if names else "There are no sequences here; open_run without one folds freely."
    )
    return call_tool_result(" ".join((text, *_adding(app_context(ctx)), *found.problems)), found)


def _adding(app: AppContext) -> list[str]:
    """How films and photos of the user's own become sequences, said to hosts whose user starts the server."""
    if app.settings.read_only or app.settings.shared:
        return []
    return ["add_sequence makes others of films and photos."] if app.settings.allowed else [ALLOWING]


def sequence_list(app: AppContext) -> SequenceList:
    """The sequences that can be opened, and one sentence for each folder that cannot be."""
    infos = [
        SequenceInfo(name=s.name, frames=s.frame_count, front_color=s.front_color, back_color=s.back_color)
        for s in app.library.sequences()
    ]
    return SequenceList(sequences=infos, problems=app.library.problems())


@tool("Open a run", ADDS, icons.RUN_ICON, within="paper", brief=True)
def open_run(
    ctx: ToolContext,
    sequence: OptionalSequence = None,
    run_id: ResumedId = None,
    attempts: OptionalAttempts = None,
) -> Annotated[CallToolResult, RunInfo]:
    """Start a run or resume one."""
    app = app_context(ctx)
    if run_id is not None:
        run = app.resume(run_id, sequence, attempts)
    else:
        run = app.open(sequence, request_id_of(ctx), attempts)
    verb = "Resumed" if run_id is not None else "Opened"
    about = f"on {run.sequence}, {run.frames} frames" if run.sequence else "as a free fold"
    return call_tool_result(f"{verb} run {run.run_id} {about}. {next_step(run)}", run_info(run))


@tool("List runs", LOOKS, icons.RUN_ICON, within="paper")
def list_runs(
    ctx: ToolContext, count: Most = 20, before: Before = None
) -> Annotated[CallToolResult, RunList]:
    """List the runs that can be taken up again, newest first."""
    app = app_context(ctx)
    found = newest_runs(app, count, before)
    return call_tool_result(_runs_in_words(found, before, shared=app.settings.shared), found)


def _runs_in_words(found: RunList, before: str | None, *, shared: bool) -> str:
    """The runs, one a line."""
    if not found.runs and before is not None:
        return f"No run was opened before {before}."
    if not found.runs:
        whose = " of yours" if shared else ""
        return f"There is no run{whose} here yet; open_run starts one."
    lines = [
        f"{each.run_id}: {each.sequence or 'a free fold'}, {each.saved}"
        + (f" of {each.frames} frames saved" if each.frames else " saved")
        + f", last changed {each.changed}."
        for each in found.runs
    ]
    older = [f"There are older ones: list_runs with before={found.runs[-1].run_id}."] if found.more else []
    return "\n".join([*lines, *older])


@tool("Show a run", LOOKS, icons.RUN_ICON, within="paper", brief=True)
def get_run(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, RunInfo]:
    """Show where a run stands."""
    run = app_context(ctx).run(run_id)
    saved = f"{len(run.checkpoints)} of {run.frames} frames saved. " if run.sequence else ""
    links = [*file_links(run.run_id), *checkpoint_links(run.run_id, sorted(run.checkpoints))]
    return call_tool_result(f"Run {run.run_id}: {saved}{next_step(run)}", run_info(run), *links)
