"""A call of the client's with its request id: what was on its way when server or client died is asked again."""

from collections.abc import Iterable
from dataclasses import dataclass

from folding_client.messages import JsonObject
from folding_client.record.event_log import Event


@dataclass(frozen=True)
class Request:
    """A tool call for ``by``, the agent or the client itself.

    ``id`` makes it safe to send again: the server carries a call out once and answers it alike each time. It is
    None for a call that only reads, which needs none.
    """

    by: str
    tool: str
    arguments: JsonObject
    id: str | None


def unanswered(events: Iterable[Event]) -> Request | None:
    """The last call of a recorded run if no answer to it is on record and it may have changed the run."""
    last: Event | None = None
    for event in events:
        match event["kind"]:
            case "call":
                last = event
            case "result":
                last = None
    if last is None or last.get("request_id") is None:
        return None
    return Request(last["by"], last["name"], last["arguments"], last["request_id"])
