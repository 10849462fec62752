"""A call of the client's with its request id: what was on its way when server or client died is asked again.

What the answer decides is put on record then, as it would have been.
"""

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


@dataclass(frozen=True)
class SavedFrame:
    """A frame that was saved for ``by``, the agent or the client itself."""

    frame: int
    complete: bool
    by: str


def undecided(events: Iterable[Event], run_id: str) -> SavedFrame | None:
    """What a recorded run saved last, if it was cut short before it was on record who decided the frame."""
    call: Event | None = None
    saved: SavedFrame | None = None
    for event in events:
        match event["kind"]:
            case "call":
                call = event
            case "result" if (
                call is not None and event["name"] == "save_checkpoint" and not event["is_error"]
            ):
                if call["arguments"].get("run_id") == run_id:
                    answer = event["structured"]
                    saved = SavedFrame(answer["frame"], answer["complete"], event["by"])
            case "step_over" | "step_started":
                saved = None
    return saved


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
