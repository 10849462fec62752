"""Runs: which sequences there are, opening and resuming a run, and where a run stands."""

from typing import Annotated

from folding_schemas.results import RunInfo, SequenceInfo, SequenceList
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.tools.answers import answer
from folding_server.tools.arguments import RunId
from folding_server.tools.desk import Call, Desk, desk_of
from folding_server.tools.standing import next_step, run_info

SequenceName = Annotated[str | None, Field(description="the name of a sequence, as list_sequences shows it")]
ResumedId = Annotated[str | None, Field(description="the id of an earlier run to take up again")]


def list_sequences(call: Call) -> Annotated[CallToolResult, SequenceList]:
    """List the sequences that can be opened."""
    found = sequence_list(desk_of(call))
    names = ", ".join(f"{each.name} ({each.frames} frames)" for each in found.sequences)
    text = (
        f"Sequences: {names}." if names else "There are no sequences here; open_run without one folds freely."
    )
    return answer(" ".join((text, *found.problems)), found)


def sequence_list(desk: Desk) -> SequenceList:
    """The sequences that can be opened, and one sentence for each folder that cannot be."""
    infos = [
        SequenceInfo(name=s.name, frames=s.frame_count, front_color=s.front_color, back_color=s.back_color)
        for s in desk.library.sequences()
    ]
    return SequenceList(sequences=infos, problems=desk.library.problems())


def open_run(
    call: Call, sequence: SequenceName = None, run_id: ResumedId = None
) -> Annotated[CallToolResult, RunInfo]:
    """Start a run or resume one."""
    desk = desk_of(call)
    run = desk.resume(run_id, sequence) if run_id is not None else desk.open(sequence)
    verb = "Resumed" if run_id is not None else "Opened"
    about = f"on {run.sequence}, {run.frames} frames" if run.sequence else "as a free fold"
    return answer(f"{verb} run {run.run_id} {about}. {next_step(run)}", run_info(run))


def get_run(call: Call, run_id: RunId = None) -> Annotated[CallToolResult, RunInfo]:
    """Show where a run stands."""
    run = desk_of(call).run(run_id)
    saved = f"{len(run.checkpoints)} of {run.frames} frames saved. " if run.sequence else ""
    return answer(f"Run {run.run_id}: {saved}{next_step(run)}", run_info(run))
