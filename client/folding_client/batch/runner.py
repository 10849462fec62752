"""Many sequences: a run folder for each, finished ones skipped, unfinished ones continued."""

import asyncio
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_client.exits import fault
from folding_client.interrupts import Interrupt, UsageError
from folding_client.progress import Silent
from folding_client.reconstruct import Job, new_job, reconstruct, resumed_job
from folding_client.record.fits import fit_summary
from folding_client.record.folder import RunFolder, file_trouble
from folding_client.record.redaction import redact
from folding_client.settings import Settings


@dataclass(frozen=True)
class BatchEntry:
    """How one sequence fared: ``status`` is complete, skipped (was complete before), stopped or failed."""

    sequence: str
    status: str
    reason: str
    frames_saved: int
    frames: int
    seconds: float
    run: str
    steps: int = 0
    matching: int = 0
    doubtful: tuple[int, ...] = ()
    tokens: int = 0
    cost: float | None = None

    @property
    def mostly_doubtful(self) -> bool:
        """Whether more than half of the steps do not fit their photos."""
        return 2 * len(self.doubtful) > self.steps

    @property
    def text(self) -> str:
        """The line for people."""
        fits = f", {self.matching} of {self.steps} steps match" if self.steps else ""
        spent = f", {self.tokens:,} tokens" if self.tokens else ""
        price = "" if self.cost is None else f", ${self.cost:.4f}"
        reason = f": {self.reason}" if self.reason else ""
        return (
            f"{self.sequence}: {self.status}, {self.frames_saved} of {self.frames} frames{fits}, "
            f"{self.seconds:.1f} s{spent}{price}{reason}"
        )


class Listener:
    """Is told of every sequence that ends; does nothing of itself."""

    def ended(self, line: BatchEntry) -> None:
        """A sequence ended."""


def sequences_of(source: Path) -> list[Path]:
    """The sequence folders in a folder, in order of name, or those that a manifest lists, one a line or as
    JSON.

    UsageError if there are none, or two have the same name.
    """
    found = _in_folder(source) if source.is_dir() else _in_manifest(source)
    if not found:
        message = (
            f"{source} holds no sequence; name a folder of folders with keyframes.json, or a list of "
            "such folders."
        )
        raise UsageError(message)
    names = [folder.resolve().name for folder in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        message = (
            f"{source} lists two sequences named {twice[0]}; their runs would share a folder, so rename one."
        )
        raise UsageError(message)
    return found


async def run_batch(
    sequences: Sequence[Path], out: Path, settings: Settings, jobs: int, listener: Listener
) -> list[BatchEntry]:
    """Reconstruct sequences, up to ``jobs`` at a time. What ends one leaves the others alone; a cancellation
    ends all and leaves each resumable.
    """
    slots = asyncio.Semaphore(jobs)
    async with asyncio.TaskGroup() as group:
        tasks = [
            group.create_task(_told_line(sequence, out, settings, slots, listener)) for sequence in sequences
        ]
    return [task.result() for task in tasks]


async def _told_line(
    sequence: Path, out: Path, settings: Settings, slots: asyncio.Semaphore, listener: Listener
) -> BatchEntry:
    """The line of a sequence, worked on when fewer than the most are; the listener is told of it."""
    async with slots:
        line = await batch_entry(sequence, out / sequence.resolve().name, settings)
        listener.ended(line)
        return line


async def batch_entry(sequence: Path, folder: Path, settings: Settings) -> BatchEntry:
    """Reconstruct one sequence into its run folder, or go on with it, and say how it fared. Whatever goes wrong is
    this sequence's alone.
    """
    name = sequence.resolve().name
    try:
        if (done := _finished(folder, sequence, settings)) is not None:
            return done
        outcome = await reconstruct(_job(sequence, folder, settings), Silent())
    except Interrupt as error:
        why = str(error)
    except OSError as error:
        why = f"{file_trouble(error)}."
    except Exception as error:  # noqa: BLE001 - the boundary between the sequences of a batch
        why = fault(error)
    else:
        return _entry(name, outcome.status, outcome.reason, outcome.run, folder)
    return BatchEntry(name, "failed", redact(why), 0, 0, 0.0, str(folder))


def _entry(name: str, status: str, reason: str, run: Mapping[str, Any], folder: Path) -> BatchEntry:
    """The line of a run by what ``run.json`` says of it."""
    summary, totals = run["outcome"], run.get("totals", {})
    fits = fit_summary(run.get("fits", {}))
    costs = [each["cost"] for each in totals.values() if each["cost"] is not None]
    return BatchEntry(
        name,
        status,
        redact(reason),
        summary["frames_saved"],
        summary["frames"],
        summary["seconds"],
        str(folder),
        fits.steps,
        fits.matching,
        tuple(fits.doubtful),
        sum(each["input_tokens"] + each["output_tokens"] for each in totals.values()),
        sum(costs) if costs else None,
    )


def _job(sequence: Path, folder: Path, settings: Settings) -> Job:
    return (
        resumed_job(folder, sequence, settings)
        if (folder / "run.json").exists()
        else new_job(sequence, folder, settings)
    )


def _finished(folder: Path, sequence: Path, settings: Settings) -> BatchEntry | None:
    """The line of a run that is complete and is what is asked for."""
    if not (folder / "run.json").exists():
        return None
    about = RunFolder(folder).description("models", "outcome")
    if about["outcome"]["status"] != "complete":
        return None
    if about["models"]["agent"] != settings.model:
        message = (
            f"{folder} was made with model {about['models']['agent']}, not {settings.model}; choose "
            "another --out."
        )
        raise UsageError(message)
    return _entry(sequence.resolve().name, "skipped", "", about, folder)


def _in_folder(source: Path) -> list[Path]:
    if (source / "keyframes.json").is_file():
        return [source]
    return sorted(file.parent for file in source.glob("*/keyframes.json"))


def _in_manifest(source: Path) -> list[Path]:
    try:
        text = source.read_text(encoding="utf-8")
        listed = json.loads(text) if text.lstrip().startswith("[") else text.splitlines()
    except OSError as error:
        message = f"Cannot read {source}: {error.strerror}. Name a folder of sequences, or a list of folders."
        raise UsageError(message) from error
    except ValueError as error:
        message = f"{source} is not a list of folders: {error}."
        raise UsageError(message) from error
    paths = [str(entry).strip() for entry in listed]
    return [source.parent / path for path in paths if path and not path.startswith("#")]
