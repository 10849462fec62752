"""Checking that what is sent as an image is one, and no larger than it may be."""

import base64
import io

from PIL import Image

LARGEST = 800_000


def check_data_url(url: str) -> None:
    """Raise AssertionError unless the URL holds an image."""
    head, data = url.split(",", 1)
    assert head.startswith("data:image/"), head
    assert head.endswith(";base64"), head
    check_base64(data, head.removeprefix("data:").removesuffix(";base64"))


def check_base64(data: str, mime: str) -> None:
    """Raise AssertionError unless the data is an image of the type it is said to be."""
    raw = base64.b64decode(data, validate=True)
    assert len(raw) <= LARGEST, f"{len(raw)} bytes"
    with Image.open(io.BytesIO(raw)) as image:
        assert Image.MIME[image.format or ""] == mime, f"{image.format} sent as {mime}"
