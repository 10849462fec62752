"""Interchange: the current state as a file."""

from typing import TYPE_CHECKING, Annotated

from folding_schemas.results import Export, ExportFormat
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, ImageSize, RunId
from folding_server.mcp.results import AnswerPicture, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.tool_record import LOOKS, tool

if TYPE_CHECKING:
    from folding_server.frames.image_files import EncodedImage

Format = Annotated[
    ExportFormat,
    Field(description="the kind of file"),
]

Step = Annotated[
    int | None,
    Field(ge=0, description="a step of the program, 0 the flat sheet; left out, the last"),
    READ_WHOLE,
]


@tool("Export the model", LOOKS, icons.FILE_ICON, within="standard", pictures=True)
def export_state(
    ctx: ToolContext,
    format: Format,  # noqa: A002 - the argument's name on the wire
    step: Step = None,
    images: ImageSize = "full",
    run_id: RunId = None,
) -> Annotated[CallToolResult, Export]:
    """Give the current state as a file."""
    from folding_server.diagram.palette import colors_of  # noqa: PLC0415
    from folding_server.interchange.export import export  # noqa: PLC0415  (loads shapely)
    from folding_server.interchange.step_files import paper_after, program_of_step  # noqa: PLC0415

    app = app_context(ctx)
    run = app.run(run_id)
    colors = colors_of(run.front_color, run.back_color)
    program, paper = program_of_step(run.current_program(), step), app.paper(run)
    if step is not None:
        paper = paper_after(program, len(program.steps))
    file = export(paper, format, colors, program)
    text = file.content if isinstance(file.content, str) else None
    exported = Export(format=format, media_type=file.media_type, filename=file.filename, text=text)
    pictures = (
        []
        if isinstance(file.content, str)
        else [AnswerPicture(_picture(file.content), picture_metas.exported_diagram())]
    )
    return picture_result(f"{file.filename} ({file.media_type}).", exported, pictures, images)


def _picture(png: bytes) -> "EncodedImage":
    """A PNG to send."""
    from folding_server.frames.image_files import EncodedImage, decode_bytes  # noqa: PLC0415

    height, width = decode_bytes(png, "the export").shape[:2]
    return EncodedImage(png, "image/png", width, height)
