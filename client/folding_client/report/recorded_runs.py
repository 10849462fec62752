"""Recorded runs as a report reads them: whatever is damaged or missing is a sentence, never the end of the report."""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_schemas.event_record import OpenedEvent, RecordedEvent, RunEventLine
from folding_schemas.run_record import RunRecord
from pydantic import TypeAdapter, ValidationError

from folding_client.interrupts import UsageError

SEARCH_DEPTH = 4
"""How many folders below one that is named a run may lie: batch, sequence, model and seed."""
_EVENT: TypeAdapter[RunEventLine] = TypeAdapter(RunEventLine)
_KNOWN_KINDS = frozenset(
    kind
    for part in RunEventLine.__args__[0].__args__
    for kind in part.model_fields["kind"].annotation.__args__
)


@dataclass(frozen=True)
class RunPlace:
    """Where a run lies: its folder, the name of the batch that it is part of, and where it is within that."""

    folder: Path
    batch: str
    within: str


@dataclass(frozen=True)
class RecordedRun:
    """A run as far as its folder tells of it. ``about`` is None where ``run.json`` cannot be read; ``problems`` has a
    sentence for each thing that is damaged or missing.
    """

    place: RunPlace
    about: RunRecord | None
    events: tuple[RecordedEvent, ...]
    problems: tuple[str, ...]

    @property
    def sequence(self) -> str:
        """The name of the sequence; the run folder's own where the record does not tell it."""
        return self.about.sequence.name if self.about else self.place.folder.name

    @property
    def status(self) -> str:
        """How the run stands; ``damaged`` where it cannot be known."""
        return self.about.outcome.status if self.about else "damaged"

    @property
    def model(self) -> str:
        """The model of the agent."""
        return self.about.models.get("agent", "unknown") if self.about else "unknown"

    @property
    def variant(self) -> str:
        """The variant of the agent, and whether it was shown solved examples."""
        settings = self.settings
        few_shot = ", few-shot" if settings.get("few_shot") else ""
        return f"{settings.get('variant', 'agent')}{few_shot}"

    @property
    def settings(self) -> dict[str, Any]:
        """The settings by name, given and defaulted."""
        if self.about is None:
            return {}
        return {**self.about.settings.defaulted, **self.about.settings.given}

    @property
    def run_id(self) -> str | None:
        """The server's id of the run."""
        opened = next((event for event in self.events if isinstance(event, OpenedEvent)), None)
        return opened.run_id if opened else (self.about.run_id if self.about else None)


def find_runs(roots: Sequence[Path]) -> list[RunPlace]:
    """The runs in folders, in order of their paths; each folder that is named is a batch. UsageError if one holds none."""
    found: dict[Path, RunPlace] = {}
    for root in roots:
        batch = _batch_name(root, roots)
        there = [
            RunPlace(folder, batch, str(folder.relative_to(root.resolve())))
            for folder in _run_folders(root.resolve())
        ]
        if not there:
            message = f"{root} holds no recorded run; name a run folder, or a folder of run folders."
            raise UsageError(message)
        found |= {place.folder: place for place in there if place.folder not in found}
    return list(found.values())


def _batch_name(root: Path, roots: Sequence[Path]) -> str:
    """The folder's name, with its parent's where another root is called the same."""
    place = root.resolve()
    if sum(other.resolve().name == place.name for other in roots) > 1:
        return f"{place.parent.name}/{place.name}"
    return place.name


def _run_folders(root: Path, depth: int = SEARCH_DEPTH) -> Iterator[Path]:
    """The folders at or below one that hold a record."""
    if (root / "run.json").is_file() or (root / "events.jsonl").is_file():
        yield root
        return
    if depth and root.is_dir():
        for folder in sorted(root.iterdir()):
            if folder.is_dir() and not folder.name.startswith("."):
                yield from _run_folders(folder, depth - 1)


def read_run(place: RunPlace) -> RecordedRun:
    """All that a run's folder tells."""
    problems: list[str] = []
    about = _read_about(place.folder / "run.json", problems)
    events = tuple(_read_lines(place.folder / "events.jsonl", problems))
    problems += _missing_numbers(events)
    return RecordedRun(place, about, events, tuple(problems))


def _read_about(file: Path, problems: list[str]) -> RunRecord | None:
    try:
        return RunRecord.model_validate_json(file.read_bytes())
    except OSError as error:
        problems.append(f"run.json cannot be read: {error.strerror}.")
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        problems.append(f"run.json is damaged{f' at {where}' if where else ''}: {first['msg']}.")
    return None


def _read_lines(file: Path, problems: list[str]) -> Iterator[RecordedEvent]:
    """The events that can be read; a last line that was cut off is left out silently, since a run may be writing it."""
    try:
        lines = file.read_bytes().split(b"\n")[:-1]
    except OSError as error:
        problems.append(f"events.jsonl cannot be read: {error.strerror}.")
        return
    broken: list[int] = []
    for number, line in enumerate(lines, start=1):
        event = _event_of(line)
        if isinstance(event, RecordedEvent):
            yield event
        elif event is None:
            broken.append(number)
    if broken:
        shown = ", ".join(map(str, broken[:5])) + (" and more" if len(broken) > 5 else "")
        problems.append(f"Lines of events.jsonl that are no event: {shown}.")


def _event_of(line: bytes) -> RecordedEvent | str | None:
    """The event that a line states; the name of a kind that this version does not know; None for anything else."""
    try:
        data = json.loads(line)
        kind = data["kind"]
        return _EVENT.validate_python(data) if kind in _KNOWN_KINDS else str(kind)
    except (ValueError, KeyError, TypeError):
        return None


def _missing_numbers(events: Iterable[RecordedEvent]) -> Iterator[str]:
    before = 0
    for event in events:
        if event.seq > before + 1:
            yield f"Events {before + 1} to {event.seq - 1} are missing from events.jsonl."
        before = event.seq
