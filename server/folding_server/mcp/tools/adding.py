"""Adding sequences: a film or photos of the user's own become a sequence that can be opened like any other, until it is removed."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from folding_schemas.results import AddedKeyframe, SequenceAdded, SequenceRemoved
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import ToolContext, app_context
from folding_server.mcp.parameters import FilePaths, ImageNumbers, ImageSize
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.long_calls import compute_long
from folding_server.mcp.services.sequence_adding import AddedAnswer, SequenceWish, add_to_library
from folding_server.mcp.services.sequence_jobs import MadeSequence, SequenceWork, make_sequence
from folding_server.mcp.services.sequence_removing import remove_from_library
from folding_server.mcp.tool_progress import PERCENT
from folding_server.mcp.tool_record import KEEPS, SETTLES, tool

_SAID = 30
"""How many keyframes the text of an answer names; the data has all."""

ShortestRest = Annotated[
    float | None,
    Field(description="seconds for which all must rest in a film for a keyframe; left out, 0.4"),
]
NewName = Annotated[
    str | None, Field(description="a name for the sequence; left out, that of the file or folder")
]
AddedName = Annotated[str, Field(description="the name of a sequence that add_sequence made")]
PaperColor = Annotated[
    str | None,
    Field(
        description="the colour of one side of the paper, such as #2060c0; left out, it is seen in the photos"
    ),
]


@tool("Add a sequence", KEEPS, icons.PHOTO_ICON, within="paper", pictures=True, long=True)
async def add_sequence(
    ctx: ToolContext,
    paths: FilePaths,
    name: NewName = None,
    keyframes: ImageNumbers = None,
    front_color: PaperColor = None,
    back_color: PaperColor = None,
    rest: ShortestRest = None,
    images: ImageSize = "full",
) -> Annotated[CallToolResult, SequenceAdded]:
    """Make a sequence of a film or of photos."""
    wish = SequenceWish(paths, name, keyframes, front_color, back_color, rest)

    async def make(work: SequenceWork, folder: Path) -> MadeSequence:
        return await compute_long(ctx, "add_sequence", PERCENT, make_sequence, work, folder, counted=True)

    answer = await add_to_library(app_context(ctx), wish, make, shown=images != "none")
    return picture_result(_in_words(answer), _added(answer), _pictures(answer), images)


@tool("Remove a sequence", SETTLES, icons.PHOTO_ICON, within="paper")
def remove_sequence(ctx: ToolContext, name: AddedName) -> Annotated[CallToolResult, SequenceRemoved]:
    """Remove a sequence that was added."""
    remove_from_library(app_context(ctx), name)
    text = f"The sequence {name!r} was removed; the files that it was made from are untouched."
    return call_tool_result(text, SequenceRemoved(name=name))


def _pictures(answer: AddedAnswer) -> Sequence[AnswerPicture]:
    """The contact sheet, where it was drawn."""
    sheet = answer.made.contact_sheet
    return [AnswerPicture(sheet, picture_metas.contact_sheet_of_sequence(answer.name))] if sheet else []


def _added(answer: AddedAnswer) -> SequenceAdded:
    """What came of it, as data."""
    built, known = answer.made.built, answer.kept.manifest
    seconds = built.seconds or [None] * len(built.keyframes)
    found = enumerate(zip(built.keyframes, seconds, strict=True), start=1)
    return SequenceAdded(
        name=answer.name,
        outcome=answer.outcome,
        images=built.images,
        frames=len(built.keyframes),
        keyframes=[
            AddedKeyframe(
                frame=frame,
                image=image,
                seconds=None if time is None else round(time, 3),
                moving=image in built.moving,
            )
            for frame, (image, time) in found
        ],
        front_color=known.front_color,
        back_color=known.back_color,
        warnings=list(answer.made.warnings),
    )


def _in_words(answer: AddedAnswer) -> str:
    """What came of it, and what to do next."""
    done = {"added": "was added", "replaced": "was replaced", "unchanged": "is as it was"}[answer.outcome]
    built = answer.made.built
    frames, numbers = len(built.keyframes), ", ".join(map(str, built.keyframes[:_SAID]))
    more = " and so on" if frames > _SAID else ""
    other = ""
    if answer.name != answer.asked:
        other = f" There is a {answer.asked!r} already that is not to be changed, since it is of other files or runs of it are kept."
    moving = ""
    if built.moving:
        moving = " Nothing rests in the film, so these are its stillest moments, in which something moves: look at each."
    warned = "".join(f" Warning: {each}." for each in answer.made.warnings)
    return (
        f"The sequence {answer.name!r} {done}: {frames} keyframes of {built.images} images, {numbers}{more}.{other}{moving}{warned} "
        "Look at the contact sheet, where keyframes are framed in red and each image stands under its number: frame 1 has "
        "to show the flat sheet, and each later one the paper after one step. To correct them, call add_sequence again with "
        f"the same paths and the right numbers as keyframes; then open_run with sequence {answer.name!r}."
    )
