"""From the protocol's answer to a tool call to what the client keeps of it."""

import base64
import json
from collections.abc import Sequence

from folding_schemas.pictures import PictureMeta
from mcp.types import CallToolResult, ImageContent, TextContent

from folding_client.messages import JsonObject, Picture, ToolResult


def tool_result(answer: CallToolResult, tool: str) -> ToolResult:
    """A tool's answer: its text without the data that servers repeat there as JSON, its data, its pictures.

    An answer with pictures has its data in the text alone, since other hosts drop pictures beside structured content.
    """
    texts = [block.text for block in answer.content if isinstance(block, TextContent)]
    images = [block for block in answer.content if isinstance(block, ImageContent)]
    data = answer.structured_content or (_stated(texts) if images else None)
    pictures = tuple(_picture(image, f"picture {number} of {tool}") for number, image in enumerate(images, 1))
    return ToolResult(_summary(texts, data), data, pictures, bool(answer.is_error))


def _summary(texts: Sequence[str], data: JsonObject | None) -> str:
    return "\n".join(text for text in texts if data is None or not _states(text, data))


def _states(text: str, data: JsonObject) -> bool:
    """Whether a text is the data as JSON and nothing else."""
    try:
        return bool(json.loads(text) == data)
    except ValueError:
        return False


def _stated(texts: Sequence[str]) -> JsonObject | None:
    """The data that the last text states, if it is a JSON object and nothing else."""
    try:
        data = json.loads(texts[-1]) if texts else None
    except ValueError:
        return None
    return data if isinstance(data, dict) else None


def _picture(image: ImageContent, neutral: str) -> Picture:
    """An image, under a ``neutral`` subject if its server does not say what it shows."""
    data = base64.b64decode(image.data)
    meta = PictureMeta.from_meta(image.meta)
    if meta is None:
        return Picture(data, image.mime_type, neutral)
    return Picture(data, image.mime_type, meta.subject, meta.frame, meta.role)
