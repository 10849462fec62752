"""A call of the client's with its request id: what was on its way when server or client died is asked again."""

from collections.abc import Iterable
from dataclasses import dataclass

from folding_schemas.attempt_limits import TECHNICAL_RETURN
from folding_schemas.request_id import REQUEST_ID

from folding_client.messages import JsonObject
from folding_client.record.event_log import Event


@dataclass(frozen=True)
class Request:
    """A tool call for ``by``, the agent or the client itself.

    ``id`` makes it safe to send again: the server carries a call out once and answers it alike each time. It is
    None for a call that only reads, which needs none. ``technical`` says why a checkpoint is restored: not because the
    result was wrong, so that it costs no attempt.
    """

    by: str
    tool: str
    arguments: JsonObject
    id: str | None
    technical: bool = False

    @property
    def meta(self) -> JsonObject:
        """What the server is told beside the arguments."""
        meta: JsonObject = {} if self.id is None else {REQUEST_ID: self.id}
        return meta | {TECHNICAL_RETURN: True} if self.technical else meta


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
    technical = last.get("technical", False)
    return Request(last["by"], last["name"], last["arguments"], last["request_id"], technical)
