"""Interchange: the current state as a file."""

from typing import Annotated

from folding_schemas.results import Export, ExportFormat
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.tools.answers import answer
from folding_server.tools.arguments import RunId
from folding_server.tools.desk import Call, desk_of
from folding_server.tools.pictures import diagram

Format = Annotated[
    ExportFormat, Field(description="one of fold, crease-pattern, svg, png, obj and program")
]


def export_state(call: Call, format: Format, run_id: RunId = None) -> Annotated[CallToolResult, Export]:  # noqa: A002
    """Give the current state as a file."""
    raise NotImplementedError
