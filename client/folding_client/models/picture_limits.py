"""Conversations with fewer pictures, for models that take only so many or a short conversation.

Nothing is left out without a line that says so.
"""

from collections.abc import Sequence

from folding_client.interrupts import ProviderRefused
from folding_client.messages import Message
from folding_client.models.picture_sizes import joined_sheet

_LEFT_OUT = "(Left out, for the model takes no more: {subjects}.)"
_NONE_TAKEN = (
    "(Not shown, for you take no pictures: {subjects}. Go by numbers and by what tools say in words.)"
)
_TOGETHER = (
    "The model takes no more than {most} of the {count} pictures that belong together here: choose one that takes more, or "
    "geometric for --critic, --overview and --selector."
)


def without_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without any picture, for a model that takes none."""
    return [_without(message, _NONE_TAKEN) for message in messages]


def newest_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without the pictures before the newest ones: those that came since the last reply that was followed by
    any.
    """
    turns = _turns_with_pictures(messages)
    older = {index for turn in turns[:-1] for index in turn}
    return [_without(message) if index in older else message for index, message in enumerate(messages)]


def pictures_at_most(messages: Sequence[Message], most: int) -> list[Message]:
    """The messages with at most so many pictures, the newest; those of a message stay or go together.

    For a model that takes one, those of a message are joined to one sheet. ProviderRefused if the newest message with pictures has more: they are to be compared with each other.
    """
    if most == 1:
        messages = [_joined(message) for message in messages]
    kept: list[Message] = []
    room = most
    for message in reversed(messages):
        count = len(message.pictures)
        if count > most and room == most:
            raise ProviderRefused(_TOGETHER.format(most=most, count=count))
        kept.append(message if count <= room else _without(message))
        room -= count if count <= room else 0
    return kept[::-1]


def _joined(message: Message) -> Message:
    """The message with its pictures as one, each under its caption."""
    if len(message.pictures) < 2:
        return message
    subjects = "; ".join(picture.subject for picture in message.pictures)
    return message.showing((joined_sheet(message.pictures),), f"(Side by side in one picture: {subjects}.)")


def _turns_with_pictures(messages: Sequence[Message]) -> list[list[int]]:
    """The indices of the messages with pictures, in groups between replies."""
    turns: list[list[int]] = [[]]
    for index, message in enumerate(messages):
        if message.role == "assistant":
            turns.append([])
        elif message.pictures:
            turns[-1].append(index)
    return [turn for turn in turns if turn]


def _without(message: Message, why: str = _LEFT_OUT) -> Message:
    subjects = "; ".join(picture.subject for picture in message.pictures)
    return message.showing((), why.format(subjects=subjects)) if subjects else message
