"""One run of a batch, and batches in this process: a run folder for each, finished ones skipped, unfinished ones continued."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from folding_client.batch.batch_budget import BatchBudget, RunWatch
from folding_client.batch.batch_entry import BatchEntry, described_entry
from folding_client.batch.batch_index import BatchIndex, BatchTask
from folding_client.batch.conditions import Condition
from folding_client.batch.scheduling import BatchLimits, BatchQueue, Listener
from folding_client.exits import fault
from folding_client.interrupts import Interrupt, UsageError
from folding_client.progress import Progress, Silent
from folding_client.reconstruct import Job, new_job, reconstruct, resumed_job
from folding_client.record.folder import RunFolder, file_trouble
from folding_client.record.redaction import redact
from folding_client.run_limits import SharedLimit
from folding_client.settings import Settings


@dataclass(frozen=True)
class Batch:
    """What is to be done: every sequence under every condition, into ``out``; ``most_cost`` in US dollars is for all runs
    together, None for no limit.
    """

    sequences: Iterable[Path]
    conditions: Sequence[Condition]
    out: Path
    limits: BatchLimits = field(default_factory=BatchLimits)
    most_cost: float | None = None


class PlannedBatch:
    """A batch with its index and its queue."""

    def __init__(self, batch: Batch, index: BatchIndex, listener: Listener) -> None:
        self.batch = batch
        self.budget = BatchBudget(batch.most_cost)
        self._index = index
        index.add(batch.sequences, batch.conditions)
        self.queue = BatchQueue(index, self.budget, listener, self._is_there)

    def settings_of(self, task: BatchTask) -> Settings:
        """The settings of a run."""
        return self.batch.conditions[task.condition].settings

    def folder_of(self, task: BatchTask) -> Path:
        """The folder of a run."""
        return self.batch.out / task.folder

    def entries(self) -> Iterator[BatchEntry]:
        """How every run fared, those included that were complete before and those that were not come to."""
        for task, known in self._index.entries():
            entry = known or self._not_begun(task)
            before = task.status == "complete" and not self._index.was_begun(task)
            yield replace(entry, status="skipped", reason="") if before else entry

    def _not_begun(self, task: BatchTask) -> BatchEntry:
        why = self.budget.reason if self.budget.is_reached else "not begun"
        name, settings = Path(task.sequence).name, self.settings_of(task)
        return unknown_entry(name, "waiting", why, self.folder_of(task), settings)

    def _is_there(self, task: BatchTask) -> bool:
        return (self.folder_of(task) / "run.json").exists()


@contextmanager
def planned_batch(batch: Batch, listener: Listener) -> Iterator[PlannedBatch]:
    """A batch that no other process works on meanwhile. UsageError if one does, there is nothing to do, or two sequences
    share a folder.
    """
    with BatchIndex(batch.out) as index:
        yield PlannedBatch(batch, index, listener)


async def work_here(planned: PlannedBatch) -> None:
    """Do a batch in this process. What ends one run leaves the others alone; a cancellation ends all and leaves each
    resumable.
    """

    async def work(task: BatchTask, watch: RunWatch) -> BatchEntry:
        """One run, into its folder."""
        folder, settings = planned.folder_of(task), planned.settings_of(task)
        return await batch_entry(Path(task.sequence), folder, settings, watch, planned.budget)

    await planned.queue.work_through(work, planned.batch.limits)


async def batch_entry(
    sequence: Path,
    folder: Path,
    settings: Settings,
    progress: Progress | None = None,
    shared: SharedLimit | None = None,
) -> BatchEntry:
    """Reconstruct one sequence into its run folder, or go on with it, and say how it fared. Whatever goes wrong is
    this sequence's alone.
    """
    name = sequence.resolve().name
    try:
        if (done := _finished(folder, sequence, settings)) is not None:
            return done
        job = replace(_job(sequence, folder, settings), shared=shared)
        outcome = await reconstruct(job, progress or Silent())
    except Interrupt as error:
        why = str(error)
    except OSError as error:
        why = f"{file_trouble(error)}."
    except Exception as error:  # noqa: BLE001 - the boundary between the sequences of a batch
        why = fault(error)
    else:
        return described_entry(name, outcome.status, outcome.reason, outcome.run, folder)
    return failed_entry(name, folder, why, settings)


def failed_entry(name: str, folder: Path, why: str, settings: Settings) -> BatchEntry:
    """The entry of a run that something other than a limit of its own ended, by what is on record of it."""
    with suppress(Interrupt, KeyError, TypeError):
        about = RunFolder(folder).description("models", "outcome", "settings")
        if about["models"]["agent"] == settings.model:
            return described_entry(name, "failed", why, about, folder)
    return unknown_entry(name, "failed", why, folder, settings)


def unknown_entry(name: str, status: str, why: str, folder: Path, settings: Settings) -> BatchEntry:
    """The entry of a run that nothing is on record of."""
    model, variant, seed = settings.model, settings.variant, settings.seed
    return BatchEntry(
        name, status, redact(why), 0, 0, 0.0, str(folder), model=model, variant=variant, seed=seed
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
    return described_entry(sequence.resolve().name, "skipped", "", about, folder)
