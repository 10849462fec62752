"""What the catalogue knows of a tool beside its function: title, hints, the sets it belongs to, whether it shows pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

from mcp.types import Icon, ToolAnnotations

ToolFunction = Callable[..., Any]
ToolSelection = Literal["paper", "standard", "all"]
"""Which tools a server offers: those of the paper's agent, those and a few more, or all. Each holds the one before."""

TOOL_SETS: tuple[ToolSelection, ...] = get_args(ToolSelection)

LOOKS = ToolAnnotations(read_only_hint=True, idempotent_hint=True, open_world_hint=False)
"""Changes nothing."""
ADDS = ToolAnnotations(read_only_hint=False, destructive_hint=False, open_world_hint=False)
"""Adds to a run, and more with each call."""
KEEPS = ToolAnnotations(
    read_only_hint=False, destructive_hint=False, idempotent_hint=True, open_world_hint=False
)
"""Keeps something new; a second call finds it there."""
GIVES_UP = ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=False)
"""Takes something away from a run."""
SETTLES = ToolAnnotations(
    read_only_hint=False, destructive_hint=True, idempotent_hint=True, open_world_hint=False
)
"""Takes something away for good; a second call finds nothing left to do."""


@dataclass(frozen=True)
class ToolRecord:
    """A tool: its function, and what hosts are told of it that the function's signature does not say.

    ``title`` is what people read, ``icon`` stands for its family, ``within`` is the smallest set that holds it. With
    ``pictures`` its answers can hold images; then they carry no structured content, since some hosts drop the images
    where there is any. A ``long`` one can take seconds: its calls can be tasks. A ``brief`` one takes a millisecond as a rule,
    and says before it changes anything (``store.non_blocking``) if it does not: then its call goes to a thread.
    """

    function: ToolFunction
    title: str
    hints: ToolAnnotations
    icon: Icon
    within: ToolSelection = "all"
    pictures: bool = False
    long: bool = False
    brief: bool = False

    @property
    def name(self) -> str:
        """The name under which it is called."""
        return self.function.__name__

    def offered(self, tool_set: ToolSelection, read_only: bool) -> bool:
        """Whether a server with this choice of tools has it."""
        in_set = TOOL_SETS.index(self.within) <= TOOL_SETS.index(tool_set)
        return in_set and (bool(self.hints.read_only_hint) or not read_only)


def tool(
    title: str,
    hints: ToolAnnotations,
    icon: Icon,
    *,
    within: ToolSelection = "all",
    pictures: bool = False,
    long: bool = False,
    brief: bool = False,
) -> Callable[[ToolFunction], ToolRecord]:
    """A decorator that makes a function a tool."""

    def record(function: ToolFunction) -> ToolRecord:
        return ToolRecord(function, title, hints, icon, within, pictures, long, brief)

    return record
