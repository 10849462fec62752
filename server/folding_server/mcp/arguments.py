"""The arguments of a call as hosts send them: some add their own, some send null or "" for what is left out."""

from collections.abc import Mapping
from typing import Any

from mcp.server.mcpserver.utilities.func_metadata import FuncMetadata
from mcp.types import CallToolResult, InputRequiredResult

from folding_server.mcp.schemas import Schema

Arguments = dict[str, Any]


class ArgumentsAsSent(FuncMetadata):
    """A tool's arguments and answer, for the SDK, which then leaves text as it was sent.

    The SDK reads text that looks like JSON before it is checked, so that notes such as ``[1]`` would be a list. Numbers
    and lists that come as text are read where the parameter is one (``parameters``).
    """

    def pre_parse_json(self, data: Arguments) -> Arguments:
        """The arguments, unread."""
        return data

    def convert_result(self, result: Any) -> CallToolResult | InputRequiredResult:
        """The answer as it is: its data come from the model of which the tool's schema is made (``results``), checked already."""
        return result if isinstance(result, CallToolResult) else super().convert_result(result)


def known_arguments(schema: Schema, given: Mapping[str, Any]) -> Arguments:
    """What a tool is called with: what it knows, without optional arguments that are null or empty text."""
    taken, required = schema.get("properties", {}), schema.get("required", ())
    return {
        name: value
        for name, value in given.items()
        if name in taken and (name in required or value not in (None, ""))
    }


def unknown_arguments(schema: Schema, given: Mapping[str, Any]) -> list[str]:
    """The names of arguments that the tool does not know."""
    return [name for name in given if name not in schema.get("properties", {})]
