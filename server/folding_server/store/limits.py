"""How much there may be: attempts at a frame, and, of an owner, runs, what they take up, and the time of the vision tools."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from folding_server.errors import FoldingError, RunError

BUDGET = 5
"""How many attempts a frame of a sequence is allowed (paper, section "Bounded exploration")."""

BYTES_PER_MEGABYTE = 1_000_000


@dataclass(frozen=True, slots=True)
class OwnerLimits:
    """The most that each owner may have; None for no limit. Who calls without a token is no owner and has none.

    ``bytes`` is what the events of all the owner's runs take up, and again what the sequences that the owner added do. It may
    be passed by one event, or one sequence: it is looked at before a change. ``vision_seconds`` counts from midnight UTC, and may be passed by the call that is under way.
    ``vision_at_once`` long calls are computed at once, and ``vision_waiting`` wait.
    """

    runs: int | None = None
    bytes: int | None = None
    vision_seconds: float | None = None
    vision_at_once: int | None = None
    vision_waiting: int | None = None

    def check_runs(self, owner: str, runs: int) -> None:
        """Raise RunError if an owner with this many runs may open no other."""
        if self.runs is not None and runs >= self.runs:
            raise RunError(
                f"owner {owner} has {runs} runs, and this server keeps at most {self.runs} for an owner; "
                f"go on with one of them by its run_id, or ask whoever runs the server for more"
            )

    def check_bytes(self, owner: str, stored: int) -> None:
        """Raise RunError if an owner whose runs take up this many bytes may record nothing more."""
        if self.bytes is not None and stored >= self.bytes:
            raise RunError(
                f"the runs of {owner} take up {stored / BYTES_PER_MEGABYTE:.3g} MB, and this server keeps at most "
                f"{self.bytes / BYTES_PER_MEGABYTE:.3g} MB for an owner; ask whoever runs the server for more"
            )

    def check_sequence_bytes(self, owner: str, stored: int) -> None:
        """Raise RunError if an owner whose added sequences take up this many bytes may add no other."""
        if self.bytes is not None and stored >= self.bytes:
            raise RunError(
                f"the sequences that {owner} added take up {stored / BYTES_PER_MEGABYTE:.3g} MB, and this server keeps at most "
                f"{self.bytes / BYTES_PER_MEGABYTE:.3g} MB for an owner; ask whoever runs the server for more"
            )

    def check_vision(self, owner: str, seconds: float) -> None:
        """Raise RunError if the vision tools have computed for the owner for as long as they may in a day."""
        if self.vision_seconds is not None and seconds >= self.vision_seconds:
            raise RunError(
                f"the vision tools have computed {seconds:.0f} seconds for {owner} today, and this server allows "
                f"{self.vision_seconds:.0f} a day; go on without them, or after midnight UTC"
            )


NO_LIMITS = OwnerLimits()
"""What holds where nothing is said: as much as the disk takes."""

_COUNTED = ("runs", "vision-at-once", "vision-waiting")
"""Limits that are whole numbers."""
_LIMITS = ("runs", "megabytes", "vision-seconds", "vision-at-once", "vision-waiting")


def parse_limits(given: Iterable[str]) -> OwnerLimits:
    """The limits that texts such as ``runs=100``, ``megabytes=50`` and ``vision-seconds=600`` set. FoldingError for others."""
    numbers = dict(_limit(text) for text in given)
    runs, at_once, waiting = (None if name not in numbers else int(numbers[name]) for name in _COUNTED)
    megabytes = numbers.get("megabytes")
    return OwnerLimits(
        runs=runs,
        bytes=None if megabytes is None else int(megabytes * BYTES_PER_MEGABYTE),
        vision_seconds=numbers.get("vision-seconds"),
        vision_at_once=at_once,
        vision_waiting=waiting,
    )


def _limit(text: str) -> tuple[str, float]:
    name, _, number = text.partition("=")
    try:
        most = float(number)
    except ValueError:
        most = math.nan
    if name not in _LIMITS or not _usable(name, most):
        raise FoldingError(
            f"The limit {text!r} is not possible; give {', '.join(_LIMITS[:-1])} or {_LIMITS[-1]}, an equals sign and a "
            "number that is not negative, such as runs=100."
        )
    return name, most


def _usable(name: str, most: float) -> bool:
    """Whether a number can be that limit: not negative, finite also in bytes, and whole where something is counted.

    An owner with nothing at once would wait for ever.
    """
    least = 1 if name == "vision-at-once" else 0
    return (
        least <= most and most * BYTES_PER_MEGABYTE < math.inf and (name not in _COUNTED or most.is_integer())
    )
