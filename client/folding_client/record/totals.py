"""Sums over the replies of a run, by role: queries, tokens, price."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from folding_client.messages import Usage
from folding_client.record.events import Event


@dataclass(frozen=True)
class Totals:
    """What one role has used so far. ``cost`` is None until a reply with a known price comes."""

    queries: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    cached_tokens: int = 0
    thinking_tokens: int = 0
    cost: float | None = None

    def plus(self, usage: Usage) -> "Totals":
        """The sums with one more reply."""
        cost = self.cost if usage.cost is None else (self.cost or 0.0) + usage.cost
        return replace(
            self,
            queries=self.queries + 1,
            input_tokens=self.input_tokens + usage.input_tokens,
            output_tokens=self.output_tokens + usage.output_tokens,
            cached_tokens=self.cached_tokens + usage.cached_tokens,
            thinking_tokens=self.thinking_tokens + usage.thinking_tokens,
            cost=cost,
        )


def totals_of(events: Iterable[Event]) -> dict[str, Totals]:
    """The sums by role over a recorded run."""
    totals: dict[str, Totals] = {}
    for event in events:
        if event["kind"] == "reply":
            totals[event["role"]] = totals.get(event["role"], Totals()).plus(Usage(**event["usage"]))
    return totals
