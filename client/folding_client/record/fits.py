"""How well each saved frame was found to fit its photo, by what a run put on record before it saved the frame."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from folding_client.protocol.acting import ACTIONS
from folding_client.record.event_log import Event

_CHANGES = ACTIONS | {"undo", "restore_checkpoint"}
"""Tools after which an earlier verdict tells of another state."""

TRUSTED_CONFIDENCE = 0.8
"""Confidence of the server in a proposal below which a step is doubtful though it matches its photo: of 649 steps of known programs,
those that match and are above it were wrong in 1.6 % (docs/solver.md).
"""
_MEANING = ("action", "edge", "position", "direction", "angle", "axis")
FitSource = Literal["comparison", "critic", "selector"]


@dataclass(frozen=True)
class Fit:
    """The last verdict on a frame before it was saved, and the agreement with the photo; each None if there was none.
    ``by`` says where the verdict is from, None if nobody looked. ``confidence``, 0 to 1, is the server's in what was done,
    if that was the first of its proposals.
    """

    verdict: str | None = None
    agreement: float | None = None
    by: FitSource | None = None
    confidence: float | None = None

    @property
    def matches(self) -> bool:
        """Whether the frame was found to match its photo."""
        return self.verdict == "MATCH"

    @property
    def is_doubtful(self) -> bool:
        """Whether somebody looked, and found no match, or one that the server was not sure of."""
        unsure = self.confidence is not None and self.confidence < TRUSTED_CONFIDENCE
        return self.by is not None and (unsure or not self.matches)


class FitRecord:
    """Reads the events of a run as they come; ``by_frame`` is what it found of the frames saved so far."""

    def __init__(self, events: Iterable[Event] = ()) -> None:
        self.by_frame: dict[int, Fit] = {}
        self._run_id: str | None = None
        self._arguments: Mapping[str, Any] = {}
        self._now: dict[int, Fit] = {}
        self._rewrites: tuple[int, ...] = ()
        self._tried: dict[tuple[int, int, int | None], Fit] = {}
        self._proposed: dict[int, tuple[list[Mapping[str, Any]], float | None]] = {}
        self._done: list[Mapping[str, Any]] = []
        for event in events:
            self.add(event["kind"], event)

    def add(self, kind: str, data: Mapping[str, Any]) -> None:
        """One event more."""
        if kind == "call":
            self._arguments = data["arguments"]
        elif kind == "verdict":
            before = self._now.get(data["frame"], Fit())
            self._now[data["frame"]] = Fit(data["verdict"], before.agreement, "critic")
        elif kind == "selected":
            self._rewrites = tuple(data.get("rewrites", ()))
        elif kind == "result" and not data["is_error"]:
            self._add_result(data["name"], data["structured"] or {})

    def described(self, frames_saved: int) -> dict[str, dict[str, Any]]:
        """What ``run.json`` says of the frames from 2 on that are saved."""
        return {str(frame): asdict(self.by_frame.get(frame, Fit())) for frame in range(2, frames_saved + 1)}

    def _add_result(self, tool: str, answer: Mapping[str, Any]) -> None:
        if tool == "open_run":
            self._run_id = self._run_id or answer.get("run_id")
        if self._arguments.get("run_id") != self._run_id:
            return
        self._follow(tool, answer)
        if tool in _CHANGES:
            self._now.clear()
        elif tool == "compare_to_frame":
            self._add_comparison(answer)
        elif tool == "save_checkpoint":
            fit = self._now.get(answer["frame"], Fit())
            self.by_frame[answer["frame"]] = replace(fit, confidence=self._confidence(answer["frame"]))
            self._done = []
        elif tool == "commit_attempt":
            self.by_frame |= dict.fromkeys(self._rewrites, Fit(by="selector"))
            known = self._tried.get(self._place(), Fit())
            self.by_frame[answer["frame"]] = Fit(known.verdict, known.agreement, "selector")

    def _follow(self, tool: str, answer: Mapping[str, Any]) -> None:
        """Remember what was proposed, and what was done since the last saved frame."""
        if tool == "propose_actions" and answer.get("proposals"):
            first = answer["proposals"][0]["actions"]
            self._proposed[answer["frame"]] = [_bare(action) for action in first], answer.get("confidence")
        elif tool in ACTIONS:
            self._done.append(_bare({**self._arguments, "action": tool}))
        elif tool == "undo":
            self._done = self._done[:-1]
        elif tool == "restore_checkpoint":
            self._done = []

    def _confidence(self, frame: int) -> float | None:
        """The server's confidence in what was done for a frame, if that is what it proposed first."""
        actions, confidence = self._proposed.get(frame, ([], None))
        return confidence if actions == self._done else None

    def _add_comparison(self, answer: Mapping[str, Any]) -> None:
        found = Fit(answer["verdict"], answer["agreement"], "comparison")
        if self._arguments.get("attempt") is None:
            self._now[answer["frame"]] = found
        else:
            self._tried[self._place()] = found

    def _place(self) -> tuple[int, int, int | None]:
        """The frame, the attempt, and which of its states if not the last, that the call at hand means."""
        return self._arguments["frame"], self._arguments["attempt"], self._arguments.get("state")


@dataclass(frozen=True)
class FitSummary:
    """How the steps of a run fit: how many there are, how many match, which do not, which nobody looked at."""

    steps: int
    matching: int
    doubtful: Mapping[int, Fit]
    unseen: tuple[int, ...]

    @property
    def mostly_doubtful(self) -> bool:
        """Whether more than half of the steps do not fit: no success, for all that every frame is saved."""
        return 2 * len(self.doubtful) > self.steps

    @property
    def text(self) -> str:
        """In words, such as ``7 of 9 steps match; doubtful frames: 4 (0.81), 7 (0.77)``; empty without steps."""
        if not self.steps:
            return ""
        parts = [f"{self.matching} of {self.steps} steps match"]
        if self.doubtful:
            parts.append("doubtful frames: " + ", ".join(map(_doubt, self.doubtful, self.doubtful.values())))
        if self.unseen:
            parts.append("not compared: " + ", ".join(map(str, self.unseen)))
        return "; ".join(parts)


def fit_summary(described: Mapping[str, Mapping[str, Any]]) -> FitSummary:
    """The summary of what ``run.json`` says under ``fits``."""
    fits = {int(frame): Fit(**fit) for frame, fit in described.items()}
    return FitSummary(
        len(fits),
        sum(fit.matches for fit in fits.values()),
        {frame: fit for frame, fit in fits.items() if fit.is_doubtful},
        tuple(frame for frame, fit in fits.items() if fit.by is None),
    )


def _bare(action: Mapping[str, Any]) -> Mapping[str, Any]:
    """An action by what it means, without what a call says of the run and of pictures."""
    return {key: action[key] for key in _MEANING if action.get(key) is not None}


def _doubt(frame: int, fit: Fit) -> str:
    if fit.matches and fit.confidence is not None:
        return f"{frame} (confidence {fit.confidence:.2f})"
    if fit.agreement is not None:
        return f"{frame} ({fit.agreement:.2f})"
    return f"{frame} ({'chosen among the attempts' if fit.by == 'selector' else fit.verdict or 'NO VERDICT'})"
