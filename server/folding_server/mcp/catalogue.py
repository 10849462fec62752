"""All tools of the server, each with its description from the prompts and hints about what it may change."""

from collections.abc import Callable
from typing import Any

from folding_prompts import tool_description
from mcp.server.mcpserver.tools import Tool
from mcp.types import ToolAnnotations

from folding_server.mcp.tools import (
    apps,
    attempts,
    checkpoints,
    folding,
    interchange,
    runs,
    verification,
    viewing,
    vision,
)

ToolFunction = Callable[..., Any]

_LOOKS = ToolAnnotations(read_only_hint=True, open_world_hint=False)
_ADDS = ToolAnnotations(read_only_hint=False, destructive_hint=False, open_world_hint=False)
_GIVES_UP = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)

_TOOLS: tuple[tuple[ToolFunction, ToolAnnotations], ...] = (
    (runs.list_sequences, _LOOKS),
    (runs.open_run, _ADDS),
    (runs.get_run, _LOOKS),
    (folding.add_vertex, _ADDS),
    (folding.fold, _ADDS),
    (folding.unfold, _ADDS),
    (folding.rotate, _ADDS),
    (folding.flip, _ADDS),
    (folding.undo, _GIVES_UP),
    (viewing.view_frame, _LOOKS),
    (viewing.observe_movement, _LOOKS),
    (viewing.get_current_state, _LOOKS),
    (viewing.render_current, _LOOKS),
    (checkpoints.save_checkpoint, _ADDS),
    (checkpoints.restore_checkpoint, _GIVES_UP),
    (checkpoints.get_checkpoint_state, _LOOKS),
    (checkpoints.generate_checkpoint_overview, _LOOKS),
    (attempts.list_attempts, _LOOKS),
    (attempts.commit_attempt, _GIVES_UP),
    (verification.critic_grid, _LOOKS),
    (verification.compare_to_frame, _LOOKS),
    (verification.check_foldability, _LOOKS),
    (vision.propose_actions, _LOOKS),
    (interchange.export_state, _LOOKS),
    (apps.show_model, _LOOKS),
)


def tools() -> list[Tool]:
    """The tools, in the order in which hosts list them. KeyError if one has no description."""
    return [_tool(function, annotations) for function, annotations in _TOOLS]


def _tool(function: ToolFunction, annotations: ToolAnnotations) -> Tool:
    """One tool. Its schemas come from the signature, which says that it takes no further arguments."""
    name = function.__name__
    description, meta = tool_description(name), apps.TOOL_META.get(name)
    tool = Tool.from_function(function, description=description, annotations=annotations, meta=meta)
    tool.parameters["additionalProperties"] = False
    return tool
