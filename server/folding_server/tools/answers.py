"""Wrapping an answer for the wire: a short text, the structured model (also as JSON text) and any pictures."""

import base64
from typing import Protocol

from folding_schemas.base import Wire
from mcp.types import CallToolResult, ContentBlock, ImageContent, TextContent

IMAGE_LIMIT = 800_000
"""The most bytes an image result may have, before base64."""


class Shown(Protocol):
    """A picture ready to send: encoded bytes and their MIME type."""

    @property
    def data(self) -> bytes:
        """The encoded image."""

    @property
    def mime(self) -> str:
        """Its MIME type, such as image/jpeg."""


def answer(text: str, model: Wire, *pictures: Shown) -> CallToolResult:
    """One tool answer: ``text``, then the model as JSON for hosts that read text alone, then the pictures in order."""
    content: list[ContentBlock] = [TextContent(text=text), TextContent(text=model.model_dump_json())]
    content += [_image(picture) for picture in pictures]
    return CallToolResult(content=content, structured_content=model.model_dump(mode="json"))


def _image(picture: Shown) -> ImageContent:
    """A picture as image content. ValueError above the limit, which no picture of ours may reach."""
    if len(picture.data) > IMAGE_LIMIT:
        message = f"an image of {len(picture.data)} bytes is over the limit of {IMAGE_LIMIT}"
        raise ValueError(message)
    return ImageContent(data=base64.b64encode(picture.data).decode("ascii"), mime_type=picture.mime)
