"""The conversation of one keyframe step: it only grows, and can be rewound to an earlier length."""

from collections.abc import Sequence
from dataclasses import replace

from folding_client.messages import Message, Picture


class StepContext:
    """The messages of a step, from a fresh start. ``frugal`` leaves out pictures that a newer one
    replaces.
    """

    def __init__(self, opening: Sequence[Message], *, frugal: bool) -> None:
        self._messages = list(opening)
        self._sent = 0
        self._frugal = frugal

    def __len__(self) -> int:
        return len(self._messages)

    def append(self, message: Message) -> None:
        """Add what was said or answered."""
        self._messages.append(message)

    def rewind(self, length: int) -> None:
        """Forget everything after the first ``length`` messages."""
        del self._messages[length:]
        self._sent = min(self._sent, length)

    def to_send(self) -> tuple[list[Message], int]:
        """The messages for the next query, and from which one on they have not been sent before."""
        new_from, self._sent = self._sent, len(self._messages)
        return (without_stale_pictures(self._messages) if self._frugal else list(self._messages)), new_from


def without_stale_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages with every picture left out of which a later message shows the same subject anew."""
    last = {picture.subject: index for index, message in enumerate(messages) for picture in message.pictures}
    return [
        _without(message, {p.subject for p in message.pictures if last[p.subject] > index})
        for index, message in enumerate(messages)
    ]


def _without(message: Message, stale: set[str]) -> Message:
    if not stale:
        return message
    kept: tuple[Picture, ...] = tuple(p for p in message.pictures if p.subject not in stale)
    note = f"(Left out, since a newer one follows: {', '.join(sorted(stale))}.)"
    return replace(message, text=f"{message.text}\n{note}".strip(), pictures=kept)
