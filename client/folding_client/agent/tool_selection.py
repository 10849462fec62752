"""Which of the server's tools are on offer to the agent, and in how many words."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from folding_client.messages import ToolSpec
from folding_client.settings import ToolSet

PAPER_TOOLS = frozenset(
    {
        "add_vertex",
        "fold",
        "unfold",
        "rotate",
        "flip",
        "view_frame",
        "observe_movement",
        "get_current_state",
        "render_current",
        "save_checkpoint",
        "restore_checkpoint",
        "get_checkpoint_state",
        "generate_checkpoint_overview",
    }
)
"""The tools that the paper's agent has, beside ``ask_critic``."""
STANDARD_TOOLS = PAPER_TOOLS | {"undo", "compare_to_frame"}
"""Those, a way to take one action back, and a measure to hold against the critic's word."""
PROPOSING = frozenset({"propose_actions"})
"""What is on offer beside a set where a solver works before the model."""
NOT_OFFERED = frozenset({"list_sequences", "list_runs", "open_run", "commit_attempt", "show_model"})
"""Tools that would leave the run or tell of others, take a decision that is the controller's, or show what only people see."""

_OTHERS_ARGUMENTS = {"compare_to_frame": frozenset({"attempt", "state"})}
"""Arguments that the agent has no use for: which of the attempts is best is asked once they are used up."""


def on_offer(tools: Iterable[ToolSpec], which: ToolSet, also: frozenset[str] = frozenset()) -> list[ToolSpec]:
    """The tools of a set and those ``also`` named, in the server's order."""
    if which == "all":
        return [tool for tool in tools if tool.name not in NOT_OFFERED]
    names = (PAPER_TOOLS if which == "paper" else STANDARD_TOOLS) | also
    return [tool for tool in tools if tool.name in names]


def summarised(tool: ToolSpec) -> ToolSpec:
    """The tool with the first paragraph of its description, since what follows is advice that the system prompt gives too,
    and without the arguments that a selector needs.
    """
    left_out = _OTHERS_ARGUMENTS.get(tool.name, frozenset())
    properties = {
        name: each for name, each in tool.schema.get("properties", {}).items() if name not in left_out
    }
    schema = tool.schema | {"properties": properties} if left_out else tool.schema
    return replace(tool, description=_first_paragraph(tool), schema=schema)


def tool_list(tools: Sequence[ToolSpec]) -> str:
    """The tools, one a line: name, and the first sentence of its description."""
    return "\n".join(
        f"* `{tool.name}`: {_first_paragraph(tool).split('. ')[0].rstrip('.')}." for tool in tools
    )


def _first_paragraph(tool: ToolSpec) -> str:
    return tool.description.strip().split("\n\n")[0].replace("\n", " ")
