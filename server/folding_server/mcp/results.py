"""Wrapping an answer for the wire: a short text, the structured model (also as JSON text), any pictures."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from folding_schemas.pictures import PictureMeta
from folding_schemas.wire import Wire
from mcp.types import CallToolResult, ContentBlock, ImageContent, TextContent

if TYPE_CHECKING:
    from folding_server.frames.image_files import EncodedImage

IMAGE_LIMIT = 800_000
"""The most bytes that the images of one answer may have together, as they travel (base64).

Hosts that read answers as server-sent events refuse an event of more than 1 MiB.
"""


@dataclass(frozen=True)
class AnswerPicture:
    """A picture of an answer, and what it shows."""

    image: "EncodedImage"
    meta: PictureMeta

    def content(self) -> ImageContent:
        """The picture as image content that says in its ``_meta`` what it shows."""
        data = base64.b64encode(self.image.data).decode("ascii")
        return ImageContent(data=data, mime_type=self.image.mime, _meta=self.meta.to_meta())


def call_tool_result(text: str, model: Wire, *pictures: AnswerPicture) -> CallToolResult:
    """One answer: ``text``, then the model as JSON for hosts that read text alone, then the pictures."""
    images = [picture.content() for picture in pictures]
    _check_size(images)
    content: list[ContentBlock] = [TextContent(text=text), TextContent(text=model.model_dump_json()), *images]
    return CallToolResult(content=content, structured_content=model.model_dump(mode="json"))


def _check_size(images: Sequence[ImageContent]) -> None:
    """ValueError above the limit, which no answer of ours may reach."""
    size = sum(len(image.data) for image in images)
    if size > IMAGE_LIMIT:
        message = f"images of {size} bytes are over the limit of {IMAGE_LIMIT} for one answer"
        raise ValueError(message)
