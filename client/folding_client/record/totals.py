"""Sums over the replies of a run by role: queries, tokens, price, time; and how often what went wrong."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from folding_client.messages import Usage
from folding_client.record.event_log import Event

ANSWERED = frozenset({"reply", "unreadable"})
"""The events that end a query, one way or the other."""
FAILURES = frozenset({"refused", "skipped", "rolled_back", "rewound", "unreadable", "retry", "server_lost"})
"""The events that tell of a failure and how it was met."""


@dataclass(frozen=True)
class Totals:
    """What one role has used so far. ``cost`` is None until a reply with a known price comes."""

    queries: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    cached_tokens: int = 0
    thinking_tokens: int = 0
    cost: float | None = None
    seconds: float = 0.0

    def plus(self, usage: Usage, seconds: float) -> "Totals":
        """The sums with one more reply, for which the role waited so long."""
        cost = self.cost if usage.cost is None else (self.cost or 0.0) + usage.cost
        return replace(
            self,
            queries=self.queries + 1,
            input_tokens=self.input_tokens + usage.input_tokens,
            output_tokens=self.output_tokens + usage.output_tokens,
            cached_tokens=self.cached_tokens + usage.cached_tokens,
            thinking_tokens=self.thinking_tokens + usage.thinking_tokens,
            cost=cost,
            seconds=round(self.seconds + seconds, 3),
        )


def total_cost(totals: Mapping[str, Totals]) -> float | None:
    """The price of all roles together, as far as it is known; None if none is."""
    known = [each.cost for each in totals.values() if each.cost is not None]
    return sum(known) if known else None


def total_tokens(totals: Mapping[str, Totals]) -> int:
    """The tokens of all roles together, sent and received."""
    return sum(each.input_tokens + each.output_tokens for each in totals.values())


def totals_of(events: Iterable[Event]) -> dict[str, Totals]:
    """The sums by role over a recorded run."""
    totals: dict[str, Totals] = {}
    for event in events:
        if event["kind"] in ANSWERED:
            before = totals.get(event["role"], Totals())
            totals[event["role"]] = before.plus(Usage(**event["usage"]), event["seconds"])
    return totals


def seconds_of(events: Iterable[Event]) -> float:
    """How long was worked on a recorded run: the time of the last event of each time that its log was open."""
    before = total = 0.0
    for event in events:
        if event["elapsed"] < before:
            total += before
        before = event["elapsed"]
    return total + before


def deciders_of(events: Iterable[Event]) -> dict[int, str]:
    """By frame, who decided it last: the name of a model, the solver, or the selector among the attempts."""
    found: dict[int, str] = {}
    for event in events:
        if decided := decision(event["kind"], event):
            found |= decided
    return found


def decision(kind: str, data: Mapping[str, Any]) -> dict[int, str]:
    """The frame that an event decides, and by whom; nothing if it decides none."""
    if kind == "step_over" and "by" in data:
        return {data["frame"]: data["by"]}
    return {data["frame"]: f"selector ({data['by']})"} if kind == "selected" else {}


def tally_of(events: Iterable[Event]) -> Counter[str]:
    """How often each kind of failure came up in a recorded run, and each verdict."""
    return Counter(name for event in events if (name := tallied(event["kind"], event)))


def tallied(kind: str, data: Mapping[str, object]) -> str | None:
    """The name under which an event is counted, None if it is not."""
    if kind == "verdict":
        return str(data["verdict"] or "NO VERDICT")
    return kind if kind in FAILURES else None
