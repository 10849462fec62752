"""What can happen to a run: six kinds of events, numbered from 1 without gaps and never changed once written.

An event holds what was asked, not what came of it: checkpoints, attempts, counts and the current state are
derived by ``views``. ``FORMAT`` is written beside every event; a reader refuses formats newer than its own.
It says how ``payload`` is read: everything but the fields that have columns of their own, ``IN_COLUMNS``.
"""

from typing import Annotated, Literal

from folding_schemas.actions import Action
from folding_schemas.wire import Wire
from pydantic import AwareDatetime, Field, PositiveInt, TypeAdapter

EVENT_FORMAT = 2
"""Format 2 has the rules of a run, technical restores, and commitments to an earlier state of an attempt."""

RULES = 2
"""How attempts are counted in runs that are opened now. By rules 1, an undo back to the checkpoint ended none."""

IN_COLUMNS = frozenset({"seq", "time", "kind", "request_id"})
"""The fields of an event that are columns of the table; the others are its payload."""


class Recorded(Wire):
    """What all events have: their number within the run, from 1, when they were recorded, and the request id
    of the call that asked for them, if it had one.
    """

    seq: PositiveInt
    time: AwareDatetime
    request_id: str | None = None


class Opened(Recorded):
    """The run began; always event 1, and only that.

    ``sequence``, ``fingerprint`` and ``budget`` are None and ``frames`` is 0 for a free fold. ``sheet`` is
    the width and height of the unfolded sheet in units of the square's side. ``rules`` says how the run's attempts
    are counted, for good.
    """

    kind: Literal["opened"] = "opened"
    sequence: str | None
    frames: int
    sheet: tuple[float, float]
    front_color: str
    back_color: str
    fingerprint: str | None
    budget: int | None
    rules: PositiveInt = 1


class Acted(Recorded):
    """An action was applied to the current state."""

    kind: Literal["acted"] = "acted"
    action: Action


class Undone(Recorded):
    """The newest action since the last checkpoint was taken back."""

    kind: Literal["undone"] = "undone"


class Saved(Recorded):
    """The current state was saved as the checkpoint of a frame."""

    kind: Literal["saved"] = "saved"
    frame: int
    notes: str | None


class Restored(Recorded):
    """The checkpoint of a frame became the current state. A ``technical`` return says nothing of what was given up."""

    kind: Literal["restored"] = "restored"
    frame: int
    technical: bool = False


class Committed(Recorded):
    """An attempt at a frame was chosen for good; its last state, unless another ``state`` of it is named."""

    kind: Literal["committed"] = "committed"
    frame: int
    attempt: int
    state: int | None = None


RunEvent = Annotated[
    Opened | Acted | Undone | Saved | Restored | Committed,
    Field(discriminator="kind"),
]
EVENT: TypeAdapter[RunEvent] = TypeAdapter(RunEvent)
"""Reads an event of any kind from plain data; raises pydantic's ValidationError."""
