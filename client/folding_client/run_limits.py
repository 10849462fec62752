"""What a run may spend in all, over every role and every time it is resumed: money, tokens, time."""

import asyncio
from collections.abc import Coroutine, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from folding_client.interrupts import LimitReached
from folding_client.record.totals import Totals, total_cost, total_tokens
from folding_client.settings import Settings

_Answer = TypeVar("_Answer")


class SharedLimit(Protocol):
    """A limit over several runs, such as those of a batch."""

    def check(self) -> None:
        """LimitReached if the runs together come to it."""
        ...


@dataclass(frozen=True)
class SpendingLimits:
    """The most that a run may cost in US dollars and use in tokens, sent and received; None for no limit.

    ``shared`` is a limit that other runs count to as well. They are looked at before a query, so the one that reaches a limit is the last, and is paid for.
    """

    cost: float | None = None
    tokens: int | None = None
    shared: SharedLimit | None = None

    def check(self, totals: Mapping[str, Totals]) -> None:
        """LimitReached if the sums by role come to a limit."""
        cost = total_cost(totals)
        if self.cost is not None and cost is not None and cost >= self.cost:
            message = f"The limit of ${self.cost:g} is reached (${cost:.4f} spent); resume with a higher --max-cost."
            raise LimitReached(message)
        tokens = total_tokens(totals)
        if self.tokens is not None and tokens >= self.tokens:
            message = f"The limit of {self.tokens} tokens is reached ({tokens} used); resume with a higher --max-tokens-total."
            raise LimitReached(message)
        if self.shared is not None:
            self.shared.check()


UNLIMITED = SpendingLimits()


def spending_limits(settings: Settings, shared: SharedLimit | None = None) -> SpendingLimits:
    """The limits that the settings give, and that of several runs."""
    return SpendingLimits(settings.max_cost, settings.max_tokens_total, shared)


async def in_time(work: Coroutine[Any, Any, _Answer], most: float | None, used: float) -> _Answer:
    """What ``work`` answers. LimitReached, and the work is cancelled, when ``used`` and the time it takes come to
    ``most`` seconds; None for no limit.
    """
    if most is None:
        return await work
    try:
        async with asyncio.timeout(max(most - used, 0)) as timeout:
            return await work
    except TimeoutError:
        if not timeout.expired():
            raise
        message = f"The limit of {most:g} seconds is reached; resume with a higher --max-time."
        raise LimitReached(message) from None
