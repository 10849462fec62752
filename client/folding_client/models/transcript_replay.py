"""The queries of the geometric model in a recorded run: what it was told each time, and what it then did."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from folding_client.messages import JsonObject, Message
from folding_client.record.event_log import Event

Called = list[tuple[str, str]]
"""Tool calls as their names and arguments."""


@dataclass(frozen=True)
class Query:
    """The results that a query brought, None if it began a step; the calls of the reply, None if none came."""

    results: list[Message] | None
    calls: Called | None


def recorded_queries(events: Iterable[Event]) -> Iterator[Query]:
    """The agent's queries in order, its results with the data that came with them."""
    asked: list[Message] | None = None
    waiting = False
    data: dict[str, JsonObject | None] = {}
    call = ""
    for event in events:
        match event["kind"]:
            case "request" if event["role"] == "agent":
                if waiting:
                    yield Query(asked, None)
                asked, waiting = _results(event, data), True
            case "reply" if event["role"] == "agent":
                yield Query(asked, [(each["name"], each["arguments"]) for each in event["calls"]])
                waiting, data = False, {}
            case "call" if event["by"] == "agent":
                call = event["id"]
            case "result" if event["by"] == "agent":
                data[call] = event["structured"]
            case "verdict":
                data["ask_critic"] = {"critic_verdict": event["verdict"]}
    if waiting:
        yield Query(asked, None)


def _results(request: Event, data: dict[str, JsonObject | None]) -> list[Message] | None:
    """The tool results that a request brought; None for the opening of a step."""
    if request["new_from"] == 0:
        return None
    return [
        Message(
            "tool",
            entry["text"],
            tool=entry["tool"],
            structured=data.get("ask_critic" if entry["tool"] == "ask_critic" else entry["call_id"]),
            is_error=entry["is_error"],
        )
        for entry in request["new"]
        if entry["role"] == "tool"
    ]
