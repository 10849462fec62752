"""The conversation of one keyframe step: it only grows, and can be rewound to an earlier length."""

from collections.abc import Sequence

from folding_client.agent.context_compaction import (
    ContextPolicy,
    without_old_states,
    without_repeated_pictures,
)
from folding_client.messages import Message


class StepContext:
    """The messages of a step, from a fresh start. What the ``policy`` does not keep is left out
    when something newer follows it.
    """

    def __init__(self, opening: Sequence[Message], policy: ContextPolicy) -> None:
        self._messages = list(opening)
        self._sent = 0
        self._policy = policy

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
        messages = list(self._messages)
        if not self._policy.images:
            messages = without_repeated_pictures(messages)
        if not self._policy.results:
            messages = without_old_states(messages)
        return messages, new_from
