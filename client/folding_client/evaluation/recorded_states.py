"""Recorded runs as evaluation sees them: what led to each saved frame, how they ended, what they took."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_schemas.actions import Actions, Program
from folding_schemas.evaluation import RunEnding
from pydantic import ValidationError

from folding_client.interrupts import UsageError
from folding_client.json_files import first_error
from folding_client.record.event_log import read_events
from folding_client.record.folder import RunFolder

PATTERNS_FILE = "patterns.json"
"""What a run of the variant vlm-cp keeps: a crease pattern for each frame."""
MOST_LEVELS = 4
"""How far below the folder that is named runs are looked for."""


@dataclass(frozen=True)
class RunToScore:
    """A run's folder as it is evaluated.

    ``path`` is how it is called below the folder that was named. ``steps`` are the actions to each saved frame from 2 on;
    ``patterns``, of the variant that has no simulator, the FOLD text of each frame from 1 on instead.
    """

    path: str
    sequence: str
    model: str
    variant: str
    status: RunEnding
    reason: str
    queries: int
    input_tokens: int
    output_tokens: int
    cost: float | None
    seconds: float
    steps: tuple[Actions, ...]
    patterns: tuple[str, ...] = ()

    @property
    def frames_saved(self) -> int:
        """How many frames have a state, the flat sheet of frame 1 included."""
        return len(self.patterns) or len(self.steps) + 1

    @property
    def label(self) -> str:
        """What its row is called."""
        return self.model if self.variant == "agent" else f"{self.model} {self.variant}"


def runs_in(sources: Sequence[Path]) -> list[RunToScore]:
    """The runs in folders, in order of path. UsageError if there is none."""
    found = [
        run_to_score(folder, folder.relative_to(source).as_posix() if folder != source else source.name)
        for source in sources
        for folder in _run_folders(source)
    ]
    if not found:
        message = f"There is no run in {', '.join(map(str, sources))}; name run folders, or a folder of them."
        raise UsageError(message)
    return sorted(found, key=lambda run: (run.label, run.sequence, run.path))


def _run_folders(source: Path, depth: int = MOST_LEVELS) -> Iterator[Path]:
    if (source / "run.json").is_file():
        yield source
    elif depth and source.is_dir():
        for below in sorted(source.iterdir()):
            if below.is_dir() and not below.is_symlink():
                yield from _run_folders(below, depth - 1)


def run_to_score(folder: Path, path: str) -> RunToScore:
    """The run in a folder. UsageError if its record cannot be read."""
    about = RunFolder(folder).description("models", "settings", "outcome")
    settings = about["settings"]["defaulted"] | about["settings"]["given"]
    outcome, totals = about["outcome"], list(about.get("totals", {}).values())
    costs = [each["cost"] for each in totals if each["cost"] is not None]
    variant = settings.get("variant", "agent") + (" few-shot" if settings.get("few_shot") else "")
    return RunToScore(
        path,
        about["sequence"]["name"],
        about["models"]["agent"],
        variant,
        outcome["status"],
        "" if outcome["status"] == "complete" else outcome["reason"],
        sum(each["queries"] for each in totals),
        sum(each["input_tokens"] for each in totals),
        sum(each["output_tokens"] for each in totals),
        sum(costs) if costs else None,
        outcome["seconds"],
        _steps(folder),
        _patterns(folder),
    )


def _patterns(folder: Path) -> tuple[str, ...]:
    document = _read_json(folder / PATTERNS_FILE)
    return tuple(json.dumps(each) for each in document["patterns"]) if document else ()


def _steps(folder: Path) -> tuple[Actions, ...]:
    """The actions to each frame from 2 on, up to the first that is not saved."""
    saved = _read_json(folder / "checkpoints.json")
    by_frame = (
        {each["frame"]: each["actions"] for each in saved} if saved is not None else _saved_by_events(folder)
    )
    steps: list[Any] = []
    while len(steps) + 2 in by_frame:
        steps.append(by_frame[len(steps) + 2])
    try:
        return Program(steps=tuple(steps)).steps
    except ValidationError as error:
        message = f"The checkpoints of {folder} cannot be read: {first_error(error)}."
        raise UsageError(message) from error


def _saved_by_events(folder: Path) -> dict[int, Any]:
    """What a run that was cut short had saved, by its log."""
    log = RunFolder(folder).events
    saved: dict[int, Any] = {}
    listed: Mapping[str, Any] = {}
    call: Mapping[str, Any] = {}
    for event in read_events(log) if log.exists() else ():
        if event["kind"] == "call":
            call = event
        elif event["kind"] == "result" and not event["is_error"]:
            answer = event["structured"] or {}
            if event["name"] == "save_checkpoint":
                saved[answer["frame"]] = answer["actions"]
            elif event["name"] == "list_attempts":
                listed = answer
            elif event["name"] == "commit_attempt":
                _commit(saved, answer, listed, call["arguments"].get("state"))
    return saved


def _commit(
    saved: dict[int, Any], answer: Mapping[str, Any], listed: Mapping[str, Any], state: int | None
) -> None:
    """A committed attempt takes the place of what was saved; earlier frames that it rewrote are not known any more."""
    for frame in (*answer.get("rewritten", ()), *answer.get("dropped", ()), answer["frame"]):
        saved.pop(frame, None)
    for each in listed.get("states", ()) if listed.get("frame") == answer["frame"] else ():
        if each["attempt"] == answer["attempt"] and (
            each["last"] if state is None else each["state"] == state
        ):
            saved[answer["frame"]] = each["actions"]


def _read_json(file: Path) -> Any:  # noqa: ANN401 - whatever the file holds
    if not file.is_file():
        return None
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = f"{file} cannot be read: {error}."
        raise UsageError(message) from error
