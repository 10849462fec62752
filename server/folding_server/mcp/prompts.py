"""Prompts for hosts: what a user picks to set a model to work; arguments are completed on the way."""

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

from folding_server.errors import PhotoError
from folding_server.mcp import icons
from folding_server.mcp.completions import completion
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

ModelIdea = Annotated[str, Field(description="what is to be folded, such as a fox with pointed ears")]

_FRONT, _BACK = "in the colour that open_run calls front_color", "in that of back_color"
"""What the critic's prompt says of colours before a run is known."""


def register(server: "MCPServer[AppContext]", app: AppContext) -> None:
    """Give the server its prompts and their completion."""

    @server.prompt(title="Reconstruct a folding sequence", icons=[icons.PHOTO_ICON])
    def reconstruct(sequence: SequenceName = "") -> str:
        """Work out how the paper in a photo sequence was folded, frame by frame."""
        if sequence:
            app.library.open(sequence)
        return prompt(
            "server/reconstruct", sequence=sequence or "that the user names (list_sequences shows them)"
        )

    @server.prompt(title="Judge a step", icons=[icons.CHECK_ICON])
    def judge_step(frame: FrameNumber = "") -> str:
        """Judge whether the current state is what a frame's photo shows, as the agent's critic does."""
        if frame and not (frame.isdecimal() and int(frame) > 1):
            raise PhotoError(f"The frame {frame!r:.80} cannot be judged; give a keyframe's number, from 2.")
        critic = prompt("critic/system", front=_FRONT, back=_BACK)
        asked = f"frame {frame}" if frame else "the frame that comes next"
        return prompt("server/judge_step", critic=critic, frame=asked)

    @server.prompt(title="Find the first mistake", icons=[icons.CHECK_ICON])
    def find_mistake() -> str:
        """Find the first saved frame that departs from its photo, as the agent's overview critic does."""
        return prompt("server/find_mistake", overview=prompt("overview/system", front=_FRONT, back=_BACK))

    @server.prompt(title="Teach me to fold this", icons=[icons.FILE_ICON])
    def teach_folding() -> str:
        """Teach the user to fold the model of the run, step by step."""
        return prompt("server/teach_folding")

    @server.prompt(title="Fold a model from a description", icons=[icons.ACTION_ICON])
    def design_model(idea: ModelIdea) -> str:
        """Design an origami model from a description, as a program that folds."""
        return prompt("server/design_model", idea=idea)

    @server.completion()  # type: ignore[untyped-decorator,no-untyped-call]
    async def complete(
        reference: Reference, argument: CompletionArgument, context: CompletionContext | None
    ) -> Completion:
        """Complete sequences, runs, frames and vertices."""
        del reference
        chosen = (context.arguments if context else None) or {}
        return await anyio.to_thread.run_sync(completion, app, argument.name, argument.value, chosen)
