"""What the client writes into ``run.json`` of a run's folder; :mod:`folding_schemas.event_record` has the lines of ``events.jsonl``.

Both are published as JSON schemas beside these modules. Versions of format 1 may add members and events, so readers leave
alone what they do not know.
"""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from folding_schemas.results import Verdict


class RecordPart(BaseModel):
    """Part of a record; later versions may say more in it."""

    model_config = ConfigDict(extra="allow", frozen=True)


class RecordedSequence(RecordPart):
    """What a run reconstructs; ``frames`` once the server has opened it."""

    name: str
    folder: str
    frames: int | None = None


class RecordedSettings(RecordPart):
    """The settings by name: those given, by whatever way, and those that defaulted."""

    given: dict[str, Any]
    defaulted: dict[str, Any]


class RecordedOutcome(RecordPart):
    """How far a run is and how it ended; ``seconds`` over every time that it was worked on, ``updated`` in ISO 8601."""

    status: Literal["running", "complete", "stopped", "interrupted"]
    reason: str
    frames_saved: int
    frames: int
    seconds: float
    updated: str


class RecordedFit(RecordPart):
    """The last verdict on a frame before it was saved, its agreement with the photo from 0 to 1, and where that is from.
    ``by`` is None if nobody looked. ``confidence``, from 0 to 1, is what the server gave the explanation that was saved, if it
    was its first.
    """

    verdict: Verdict | None
    agreement: float | None
    by: Literal["comparison", "critic", "selector"] | None
    confidence: float | None = None


class RecordedTotals(RecordPart):
    """What a role used; ``cost`` in US dollars, None while no price is known."""

    queries: int
    input_tokens: int
    output_tokens: int
    cached_tokens: int
    thinking_tokens: int
    cost: float | None
    seconds: float


class RunRecord(RecordPart):
    """``run.json``. ``models``, ``requests`` and ``totals`` are by role, ``decided`` and ``fits`` by frame."""

    format: Literal[1]
    created: str
    sequence: RecordedSequence
    models: dict[str, str]
    settings: RecordedSettings
    versions: dict[str, str]
    run_id: str | None = None
    server_version: str | None = None
    requests: dict[str, dict[str, Any]] = {}
    outcome: RecordedOutcome
    decided: dict[str, str]
    fits: dict[str, RecordedFit]
    tally: dict[str, int]
    totals: dict[str, RecordedTotals]
