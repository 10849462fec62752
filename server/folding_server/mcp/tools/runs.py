"""Runs: which sequences there are, opening and resuming a run, and where a run stands."""

from typing import Annotated

from folding_schemas.results import RunInfo, SequenceInfo, SequenceList
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp.context import AppContext, ToolContext, app_context, request_id_of
from folding_server.mcp.parameters import RunId
from folding_server.mcp.results import call_tool_result
from folding_server.mcp.services.run_status import next_step, run_info

OptionalSequence = Annotated[
    str | None, Field(description="the name of a sequence, as list_sequences shows it")
]
ResumedId = Annotated[str | None, Field(description="the id of an earlier run to take up again")]


def list_sequences(ctx: ToolContext) -> Annotated[CallToolResult, SequenceList]:
    """List the sequences that can be opened."""
    found = sequence_list(app_context(ctx))
    names = ", ".join(f"{each.name} ({each.frames} frames)" for each in found.sequences)
    text = (
        f"Sequences: {names}." if names else "There are no sequences here; open_run without one folds freely."
    )
    return call_tool_result(" ".join((text, *found.problems)), found)


def sequence_list(app: AppContext) -> SequenceList:
    """The sequences that can be opened, and one sentence for each folder that cannot be."""
    infos = [
        SequenceInfo(name=s.name, frames=s.frame_count, front_color=s.front_color, back_color=s.back_color)
        for s in app.library.sequences()
    ]
    return SequenceList(sequences=infos, problems=app.library.problems())


def open_run(
    ctx: ToolContext, sequence: OptionalSequence = None, run_id: ResumedId = None
) -> Annotated[CallToolResult, RunInfo]:
    """Start a run or resume one."""
    app = app_context(ctx)
    run = app.resume(run_id, sequence) if run_id is not None else app.open(sequence, request_id_of(ctx))
    verb = "Resumed" if run_id is not None else "Opened"
    about = f"on {run.sequence}, {run.frames} frames" if run.sequence else "as a free fold"
    return call_tool_result(f"{verb} run {run.run_id} {about}. {next_step(run)}", run_info(run))


def get_run(ctx: ToolContext, run_id: RunId = None) -> Annotated[CallToolResult, RunInfo]:
    """Show where a run stands."""
    run = app_context(ctx).run(run_id)
    saved = f"{len(run.checkpoints)} of {run.frames} frames saved. " if run.sequence else ""
    return call_tool_result(f"Run {run.run_id}: {saved}{next_step(run)}", run_info(run))
