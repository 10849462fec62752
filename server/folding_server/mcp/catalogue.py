"""All tools of the server, in the order in which hosts list them, each with its description from the prompts."""

from folding_prompts import tool_description
from mcp.server.mcpserver.tools import Tool

from folding_server.mcp.arguments import ArgumentsAsSent
from folding_server.mcp.brief_calls import in_event_loop
from folding_server.mcp.schemas import lean_input, lean_output
from folding_server.mcp.tool_record import ToolRecord, ToolSelection
from folding_server.mcp.tools import (
    adding,
    apps,
    attempts,
    checkpoints,
    evaluating,
    folding,
    instructions,
    interchange,
    runs,
    verification,
    viewing,
    vision,
)

RECORDS: tuple[ToolRecord, ...] = (
    runs.list_sequences,
    runs.list_runs,
    runs.open_run,
    runs.get_run,
    folding.add_vertex,
    folding.fold,
    folding.unfold,
    folding.rotate,
    folding.flip,
    folding.undo,
    viewing.view_frame,
    viewing.observe_movement,
    viewing.get_current_state,
    viewing.render_current,
    checkpoints.save_checkpoint,
    checkpoints.restore_checkpoint,
    checkpoints.get_checkpoint_state,
    checkpoints.generate_checkpoint_overview,
    attempts.list_attempts,
    attempts.commit_attempt,
    verification.critic_grid,
    verification.compare_to_frame,
    verification.check_foldability,
    vision.propose_actions,
    vision.refine_creases,
    interchange.export_state,
    instructions.get_instructions,
    instructions.try_program,
    apps.show_model,
)


READING_FILES: tuple[ToolRecord, ...] = (adding.add_sequence, adding.remove_sequence)
"""Tools for sequences made of files of the user's own: offered only where folders are allowed."""

FOR_EVALUATION: tuple[ToolRecord, ...] = (evaluating.measure_state,)
"""Tools that score states against others: offered only where that is asked for, since who folds has no use for them."""


def tools(
    tool_set: ToolSelection = "all",
    *,
    read_only: bool = False,
    reading_files: bool = False,
    for_evaluation: bool = False,
) -> list[Tool]:
    """The tools of a set; with ``read_only`` those of them that change nothing, with ``reading_files`` also those that do so,
    with ``for_evaluation`` also those that score states.

    KeyError if one has no description.
    """
    records = RECORDS + (READING_FILES if reading_files else ()) + (FOR_EVALUATION if for_evaluation else ())
    return [_tool(record) for record in records if record.offered(tool_set, read_only)]


def long_tools() -> list[str]:
    """The names of the tools whose calls can take seconds."""
    return [record.name for record in (*RECORDS, *FOR_EVALUATION, *READING_FILES) if record.long]


def _tool(record: ToolRecord) -> Tool:
    """One tool. Its schemas come from the signature; a tool with pictures publishes none of its answer."""
    made = Tool.from_function(
        in_event_loop(record.function) if record.brief else record.function,
        title=record.title,
        description=tool_description(record.name),
        annotations=record.hints,
        icons=[record.icon],
        meta=apps.TOOL_META.get(record.name),
    )
    made.parameters = lean_input(made.parameters)
    answer = made.fn_metadata.output_schema
    made.fn_metadata = ArgumentsAsSent(
        arg_model=made.fn_metadata.arg_model,
        output_model=made.fn_metadata.output_model,
        output_schema=lean_output(answer) if answer else None,
    )
    if record.pictures:
        made.fn_metadata.output_schema = None
    return made
