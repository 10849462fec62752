"""Conversations with fewer pictures: the newest alone, or several on one sheet for models that take only so many.

Nothing is left out without a line that says so.
"""

import io
import math
from collections.abc import Sequence
from itertools import accumulate

from folding_client.messages import Message, Picture

_LEFT_OUT = "(Left out, for the model takes no more: {subjects}.)"
_ON_ONE_SHEET = "(On one sheet, row by row from the left: {subjects}.)"
_GAP = 16
"""Pixels between two pictures of a sheet."""
_WHITE = (255, 255, 255)
_QUALITY = 90
"""Of a sheet as JPEG: diagrams keep their thin lines, and four pictures stay under 800 kB."""


def newest_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without the pictures before the newest ones: those that came since the last reply that was followed by
    any.
    """
    turns = _turns_with_pictures(messages)
    older = {index for turn in turns[:-1] for index in turn}
    return [_without(message) if index in older else message for index, message in enumerate(messages)]


def as_sheets(messages: Sequence[Message], most: int) -> list[Message]:
    """The messages with at most so many pictures: as they are if they hold no more, else with the pictures between two
    replies on one sheet, and only the newest sheets.
    """
    if sum(len(message.pictures) for message in messages) <= most:
        return list(messages)
    changed = list(messages)
    turns = _turns_with_pictures(messages)
    for number, turn in enumerate(turns):
        kept = number >= len(turns) - most
        pictures = tuple(picture for index in turn for picture in messages[index].pictures)
        for index in turn:
            last = kept and index == turn[-1]
            changed[index] = _on_sheet(messages[index], pictures) if last else _without(messages[index])
    return changed


def _turns_with_pictures(messages: Sequence[Message]) -> list[list[int]]:
    """The indices of the messages with pictures, in groups between replies."""
    turns: list[list[int]] = [[]]
    for index, message in enumerate(messages):
        if message.role == "assistant":
            turns.append([])
        elif message.pictures:
            turns[-1].append(index)
    return [turn for turn in turns if turn]


def _without(message: Message) -> Message:
    return message.showing((), _LEFT_OUT.format(subjects=_subjects(message.pictures)))


def _on_sheet(message: Message, pictures: Sequence[Picture]) -> Message:
    if len(pictures) == 1:
        return message
    return message.showing((_sheet(pictures),), _ON_ONE_SHEET.format(subjects=_subjects(pictures)))


def _subjects(pictures: Sequence[Picture]) -> str:
    return "; ".join(picture.subject for picture in pictures)


def _sheet(pictures: Sequence[Picture]) -> Picture:
    """The pictures in rows of equal numbers, on white."""
    from PIL import Image

    images = [Image.open(io.BytesIO(picture.data)).convert("RGB") for picture in pictures]
    columns = math.ceil(math.sqrt(len(images)))
    rows = [images[start : start + columns] for start in range(0, len(images), columns)]
    width = max(sum(image.width + _GAP for image in row) for row in rows) - _GAP
    heights = [max(image.height for image in row) + _GAP for row in rows]
    sheet = Image.new("RGB", (width, sum(heights) - _GAP), _WHITE)
    for row, top in zip(rows, accumulate(heights, initial=0), strict=False):
        for image, left in zip(
            row, accumulate((image.width + _GAP for image in row), initial=0), strict=False
        ):
            sheet.paste(image, (left, top))
    data = io.BytesIO()
    sheet.save(data, "JPEG", quality=_QUALITY)
    return Picture(data.getvalue(), "image/jpeg", _subjects(pictures))
