"""Prompts for hosts: what a user picks to set a model to work."""

from typing import TYPE_CHECKING, Annotated

from folding_prompts import prompt
from pydantic import Field

from folding_server.tools.desk import Desk

if TYPE_CHECKING:
    from mcp.server.mcpserver import MCPServer


def register(server: "MCPServer[Desk]") -> None:
    """Give the server its prompts."""

    @server.prompt(title="Reconstruct a folding sequence")
    def reconstruct(
        sequence: Annotated[
            str, Field(description="the name of a photo sequence; empty to choose from the list")
        ] = "",
    ) -> str:
        """Work out how the paper in a photo sequence was folded, frame by frame."""
        return prompt(
            "server/reconstruct", sequence=sequence or "that the user names (list_sequences shows them)"
        )
