"""Prompts for hosts: what a user picks to set a model to work; sequence names are completed on the way."""

from typing import TYPE_CHECKING, Annotated

import anyio.to_thread
from folding_prompts import prompt
from mcp.types import (
    Completion,
    CompletionArgument,
    CompletionContext,
    PromptReference,
    ResourceTemplateReference,
)
from pydantic import Field

from folding_server.errors import FoldingError
from folding_server.mcp.context import AppContext

if TYPE_CHECKING:
    from mcp.server.mcpserver import MCPServer

Reference = PromptReference | ResourceTemplateReference
SequenceName = Annotated[
    str, Field(description="the name of a photo sequence; left empty, the user is asked which")
]
FrameNumber = Annotated[
    str, Field(description="the number of a keyframe, from 2; left empty, the frame that comes next")
]

_FRONT, _BACK = "in the colour that open_run calls front_color", "in that of back_color"
"""What the critic's prompt says of colours before a run is known."""

_NAMES_OF_SEQUENCES = ("sequence", "name")
"""What arguments that take a sequence's name are called, in prompts and in resource templates."""

_MOST = 100
"""The most values that the protocol allows in one completion."""


def register(server: "MCPServer[AppContext]", app: AppContext) -> None:
    """Give the server its prompts and their completion."""

    @server.prompt(title="Reconstruct a folding sequence")
    def reconstruct(sequence: SequenceName = "") -> str:
        """Work out how the paper in a photo sequence was folded, frame by frame."""
        return prompt(
            "server/reconstruct", sequence=sequence or "that the user names (list_sequences shows them)"
        )

    @server.prompt(title="Judge a step")
    def judge_step(frame: FrameNumber = "") -> str:
        """Judge whether the current state is what a frame's photo shows, as the agent's critic does."""
        critic = prompt("critic/system", front=_FRONT, back=_BACK)
        asked = f"frame {frame}" if frame else "the frame that comes next"
        return prompt("server/judge_step", critic=critic, frame=asked)

    @server.prompt(title="Find the first mistake")
    def find_mistake() -> str:
        """Find the first saved frame that departs from its photo, as the agent's overview critic does."""
        return prompt("server/find_mistake", overview=prompt("overview/system"))

    @server.completion()  # type: ignore[untyped-decorator,no-untyped-call]
    async def complete(
        reference: Reference, argument: CompletionArgument, context: CompletionContext | None
    ) -> Completion | None:
        """Complete names of sequences."""
        del reference, context
        if argument.name not in _NAMES_OF_SEQUENCES:
            return None
        return await anyio.to_thread.run_sync(_sequences_like, app, argument.value)


def _sequences_like(app: AppContext, start: str) -> Completion:
    """The sequences whose name starts like this; none where they cannot be listed."""
    try:
        names = [each.name for each in app.library.sequences() if each.name.startswith(start)]
    except FoldingError:
        names = []
    return Completion(values=names[:_MOST], total=len(names), has_more=len(names) > _MOST)
