"""Wrapping an answer for the wire: a short text, the model as JSON text, and structured content or pictures.

Codex hands its model the structured content alone where there is any, so an answer with pictures carries none.
"""

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from folding_schemas.pictures import PictureMeta
from folding_schemas.results import Images
from folding_schemas.wire import Wire
from mcp.types import CallToolResult, ContentBlock, ImageContent, ResourceLink, TextContent

if TYPE_CHECKING:
    from folding_server.frames.image_files import EncodedImage

IMAGE_LIMIT = 800_000
"""The most bytes that the images of one answer may have together, as they travel (base64).

Hosts that read answers as server-sent events refuse an event of more than 1 MiB.
"""

_FIRST_WITH_LINKS = "2025-06-18"
"""The version of the protocol from which answers may hold links to resources."""


@dataclass(frozen=True)
class AnswerPicture:
    """A picture of an answer, and what it shows."""

    image: "EncodedImage"
    meta: PictureMeta

    def halved(self) -> "AnswerPicture":
        """The same picture, half as wide and high: a quarter of the tokens."""
        from folding_server.mcp.services.images import half_size  # noqa: PLC0415

        return replace(self, image=half_size(self.image))

    def content(self) -> ImageContent:
        """The picture as image content that says in its ``_meta`` what it shows."""
        data = base64.b64encode(self.image.data).decode("ascii")
        return ImageContent(data=data, mime_type=self.image.mime, _meta=self.meta.to_meta())


def call_tool_result(text: str, model: Wire, *links: ResourceLink) -> CallToolResult:
    """An answer without pictures: ``text``, then the model as JSON for hosts that read text alone, then links."""
    content: list[ContentBlock] = [TextContent(text=text), TextContent(text=model.model_dump_json()), *links]
    return CallToolResult(content=content, structured_content=model.model_dump(mode="json"))


def picture_result(
    text: str, model: Wire, pictures: Iterable[AnswerPicture], images: Images = "full"
) -> CallToolResult:
    """An answer with pictures: ``text``, the model as JSON, the images. They are only made where they are wanted.

    ``images`` says whether they are left out or halved. Without pictures the answer is as any other.
    """
    if images == "none":
        return call_tool_result(f"Without pictures: {text}", model)
    shown = [(each.halved() if images == "small" else each).content() for each in pictures]
    if not shown:
        return call_tool_result(text, model)
    _check_size(shown)
    return CallToolResult(content=[TextContent(text=text), TextContent(text=model.model_dump_json()), *shown])


def _check_size(images: Sequence[ImageContent]) -> None:
    """ValueError above the limit, which no answer of ours may reach."""
    size = sum(len(image.data) for image in images)
    if size > IMAGE_LIMIT:
        message = f"images of {size} bytes are over the limit of {IMAGE_LIMIT} for one answer"
        raise ValueError(message)


def readable(answer: CallToolResult, note: str, protocol: str | None) -> CallToolResult:
    """The answer as its host can read it: with ``note`` in its text, and without links where the protocol has none."""
    content: list[ContentBlock] = [
        block
        for block in answer.content
        if protocol is None or protocol >= _FIRST_WITH_LINKS or not isinstance(block, ResourceLink)
    ]
    if note and isinstance(content[0], TextContent):
        content[0] = TextContent(text=f"{content[0].text} {note}")
    return answer.model_copy(update={"content": content})
