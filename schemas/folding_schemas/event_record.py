"""What the client writes into a line of ``events.jsonl`` of a run's folder, and the JSON schemas of a run's files."""

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from folding_schemas.evaluation import EvaluationReport
from folding_schemas.results import Verdict
from folding_schemas.run_record import RecordPart, RunRecord


class RecordedUsage(RecordPart):
    """Tokens and price of a reply."""

    input_tokens: int
    output_tokens: int
    cached_tokens: int
    thinking_tokens: int
    cost: float | None


class RecordedPicture(RecordPart):
    """A picture by its file in the run folder."""

    file: str
    subject: str


class RecordedToolCall(RecordPart):
    """A call as a model wrote it; ``arguments`` is its text."""

    id: str
    name: str
    arguments: str


class RecordedMessage(RecordPart):
    """A message that is new to a conversation; ``call_id``, ``tool`` and ``is_error`` with the result of a call."""

    role: Literal["system", "user", "assistant", "tool"]
    text: str
    images: list[RecordedPicture] = []
    calls: list[RecordedToolCall] = []
    call_id: str | None = None
    tool: str | None = None
    is_error: bool | None = None


class RecordedEvent(RecordPart):
    """What every event has: its number from 1, the time (ISO 8601, UTC), the seconds since the log was opened."""

    seq: int = Field(ge=1)
    time: str
    elapsed: float = Field(ge=0)


class OpenedEvent(RecordedEvent):
    """The run is open on the server, anew or again."""

    kind: Literal["opened", "resumed"]
    run_id: str
    saved: list[int]


class EndedEvent(RecordedEvent):
    """The work on the run ended."""

    kind: Literal["ended"]
    status: Literal["complete", "stopped", "interrupted"]
    reason: str


class StoppedEvent(RecordedEvent):
    """Something stopped the work."""

    kind: Literal["stopped"]
    cause: str
    reason: str


class StepStartedEvent(RecordedEvent):
    """A step towards a frame begins."""

    kind: Literal["step_started"]
    frame: int
    saved: list[int]


class StepOverEvent(RecordedEvent):
    """A frame is saved, decided by whoever ``by`` names."""

    kind: Literal["step_over"]
    frame: int
    complete: bool
    by: str


class FrameReasonEvent(RecordedEvent):
    """The solver leaves a frame to the model, or a plan for it was refused."""

    kind: Literal["handed_over", "plan_refused"]
    frame: int
    reason: str


class PlanFailedEvent(RecordedEvent):
    """A plan did not match."""

    kind: Literal["plan_failed"]
    frame: int
    plan: int


class RequestOptionsEvent(RecordedEvent):
    """What every query of a role carries beside its conversation."""

    kind: Literal["request_options"]
    role: str
    model: str
    options: dict[str, Any]


class RequestEvent(RecordedEvent):
    """A query goes out: ``new`` holds its messages from ``new_from`` on."""

    kind: Literal["request"]
    role: str
    messages: int
    new_from: int
    new: list[RecordedMessage]


class ReplyEvent(RecordedEvent):
    """A model answered; ``native`` is the part of its provider's message that goes back as it came."""

    kind: Literal["reply"]
    role: str
    seconds: float
    text: str
    thinking: str
    calls: list[RecordedToolCall]
    finish_reason: str
    usage: RecordedUsage
    native: dict[str, Any] | None


class UnreadableEvent(RecordedEvent):
    """A model's answer cannot be read."""

    kind: Literal["unreadable"]
    role: str
    seconds: float
    reason: str
    usage: RecordedUsage


class RetryEvent(RecordedEvent):
    """A query is sent again after so many seconds."""

    kind: Literal["retry"]
    role: str
    reason: str
    wait: float


class CallEvent(RecordedEvent):
    """A tool call goes to the server; with a ``request_id`` if it may change the run, ``technical`` if it costs no attempt."""

    kind: Literal["call"]
    by: str
    id: str | None
    name: str
    arguments: dict[str, Any]
    request_id: str | None = None
    technical: bool = False


class ResultEvent(RecordedEvent):
    """The server answered the call before."""

    kind: Literal["result"]
    by: str
    name: str
    seconds: float
    is_error: bool
    text: str
    structured: dict[str, Any] | None
    images: list[RecordedPicture]


class RefusedEvent(RecordedEvent):
    """A call of a model's was not sent."""

    kind: Literal["refused"]
    call: RecordedToolCall
    reason: str


class SkippedEvent(RecordedEvent):
    """A call was left out because one before it in the same reply failed."""

    kind: Literal["skipped"]
    call: str
    because_of: str


class VerdictEvent(RecordedEvent):
    """What the critic said; no ``verdict`` if it cannot be read."""

    kind: Literal["verdict"]
    frame: int
    verdict: Verdict | None
    analysis: str
    anchor_check: str
    discrepancies: list[str]


class SavedAgainstEvent(RecordedEvent):
    """A frame was saved although the critic's last word on it was against."""

    kind: Literal["saved_against"]
    frame: int
    verdict: str


class OverviewEvent(RecordedEvent):
    """What the overview critic said."""

    kind: Literal["overview"]
    last_correct_frame: int | None
    first_suspicious_frame: int | None
    per_frame_notes: list[str]
    recommendation: str
    readable: bool


class SelectedEvent(RecordedEvent):
    """Which attempt the selector chose, or which ``state`` of it; ``rewrites`` are the earlier frames that change with it."""

    kind: Literal["selected"]
    frame: int
    attempt: int
    state: int | None = None
    rewrites: list[int] = []
    by: Literal["model", "geometric"]
    reason: str


class RolledBackEvent(RecordedEvent):
    """A step starts again from its checkpoint."""

    kind: Literal["rolled_back"]
    frame: int
    cause: str
    reason: str


class RewoundEvent(RecordedEvent):
    """The conversation of a step is cut back to so many messages."""

    kind: Literal["rewound"]
    messages: int


class ServerLostEvent(RecordedEvent):
    """The server died on a call, or while it started (no ``call``)."""

    kind: Literal["server_lost"]
    reason: str
    call: str | None
    in_a_row: int


class ServerRestartedEvent(RecordedEvent):
    """The server that died on a call runs again."""

    kind: Literal["server_restarted"]
    call: str


class OutputMissingEvent(RecordedEvent):
    """A result could not be written."""

    kind: Literal["output_missing"]
    file: str
    reason: str


class OutputsMissingEvent(RecordedEvent):
    """No results could be written."""

    kind: Literal["outputs_missing"]
    reason: str


RunEventLine = Annotated[
    OpenedEvent
    | EndedEvent
    | StoppedEvent
    | StepStartedEvent
    | StepOverEvent
    | FrameReasonEvent
    | PlanFailedEvent
    | RequestOptionsEvent
    | RequestEvent
    | ReplyEvent
    | UnreadableEvent
    | RetryEvent
    | CallEvent
    | ResultEvent
    | RefusedEvent
    | SkippedEvent
    | VerdictEvent
    | SavedAgainstEvent
    | OverviewEvent
    | SelectedEvent
    | RolledBackEvent
    | RewoundEvent
    | ServerLostEvent
    | ServerRestartedEvent
    | OutputMissingEvent
    | OutputsMissingEvent,
    Field(discriminator="kind"),
]
"""A line of ``events.jsonl``."""


def record_schemas() -> dict[str, dict[str, Any]]:
    """The JSON schemas of a run's files and of an evaluation, by the name that each is published under."""
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return {
        "run.schema.json": {**dialect, **RunRecord.model_json_schema(), "title": "run.json"},
        "event.schema.json": {
            **dialect,
            **TypeAdapter(RunEventLine).json_schema(),
            "title": "a line of events.jsonl",
        },
        "evaluation.schema.json": {
            **dialect,
            **EvaluationReport.model_json_schema(),
            "title": "evaluation.json",
        },
    }
