"""The command ``batch``: from a source and options to a batch that is done, and how it ended."""

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_table import BatchTable
from folding_client.batch.conditions import conditions_of
from folding_client.batch.experiment import (
    EXPERIMENT_SUFFIXES,
    Experiment,
    experiment_sequences,
    read_experiment,
)
from folding_client.batch.runner import Batch, planned_batch, work_here
from folding_client.batch.scheduling import BatchLimits
from folding_client.batch.sequence_lists import absolute_folders, iter_sequences, no_sequence, shard_of
from folding_client.exits import EXIT_DOUBTFUL, EXIT_STOPPED, finish
from folding_client.interrupts import UsageError
from folding_client.models.requirements import require_models, require_prices
from folding_client.record.redaction import redact
from folding_client.setting_sources import settings_from

DEFAULT_OUT = Path("runs")


@dataclass(frozen=True)
class BatchOptions:
    """What the command line says of a batch; None and empty where it says nothing."""

    given: Mapping[str, Any] = field(default_factory=dict)
    config: Path | None = None
    out: Path | None = None
    models: Sequence[str] = ()
    variants: Sequence[str] = ()
    seeds: Sequence[int] = ()
    jobs: int | None = None
    tries: int | None = None
    max_batch_cost: float | None = None
    dask: str | None = None
    shard: str | None = None


def carry_out_batch(source: Path, options: BatchOptions, *, as_json: bool) -> int:
    """Do a batch, print how it went, and answer the exit code. UsageError if it cannot be done as given."""
    experiment = read_experiment(source) if source.suffix.lower() in EXPERIMENT_SUFFIXES else None
    options = _with_experiment(options, experiment)
    batch = _batch(source, experiment, options)
    for condition in batch.conditions:
        require_models(condition.settings, keys=options.dask is None)
        if batch.most_cost is not None:
            require_prices(condition.settings, f"--max-batch-cost {batch.most_cost:g}")
    with planned_batch(batch, BatchTable(Console(stderr=True))) as planned:
        if not planned.queue.sums.runs:
            raise no_sequence(source)
        if options.dask is None:
            work = work_here(planned)
        else:
            from folding_client.batch.cluster import work_on_cluster

            work = work_on_cluster(options.dask, planned)
        finish(work, "the same command goes on from here")
        return _told(planned.entries(), batch.out, as_json=as_json)


def _with_experiment(options: BatchOptions, experiment: Experiment | None) -> BatchOptions:
    """The options with what the experiment says where they say nothing. UsageError for options that contradict."""
    said = experiment or Experiment(sequences=[Path()])
    merged = replace(
        options,
        given={**said.settings, **options.given},
        out=options.out or said.out,
        models=options.models or ([] if "model" in options.given else said.models),
        variants=options.variants or ([] if "variant" in options.given else said.variants),
        seeds=options.seeds or ([] if "seed" in options.given else said.seeds),
        jobs=options.jobs or (None if options.dask else said.jobs),
        tries=options.tries or said.tries,
        max_batch_cost=options.max_batch_cost or said.max_batch_cost,
        dask=options.dask or (None if options.jobs else said.dask),
    )
    if merged.dask is not None and merged.jobs is not None:
        message = (
            "--jobs is for work in this process; with --dask the cluster has as many at a time as threads."
        )
        raise UsageError(message)
    return merged


def _batch(source: Path, experiment: Experiment | None, options: BatchOptions) -> Batch:
    found = iter_sequences(source) if experiment is None else experiment_sequences(experiment)
    settings = settings_from(options.given, options.config)
    models = options.models or ([] if experiment is None else [settings.model])
    conditions = conditions_of(settings, models, options.variants, options.seeds)
    shard = None if options.shard is None else shard_of(options.shard)
    limits = BatchLimits(options.jobs or 1, options.tries or 1)
    out = (options.out or DEFAULT_OUT).resolve()
    return Batch(absolute_folders(found, shard), conditions, out, limits, options.max_batch_cost)


def _told(entries: Iterable[BatchEntry], out: Path, *, as_json: bool) -> int:
    """Print the entries as JSON, or how many are done, and answer the exit code."""
    done = runs = 0
    doubtful = False
    for entry in entries:
        if as_json:
            text = json.dumps(asdict(entry), indent=1).replace("\n", "\n ")
            sys.stdout.write(redact(f"{',' if runs else '['}\n {text}"))
        runs += 1
        done += entry.is_done
        doubtful |= entry.mostly_doubtful
    typer.echo("\n]" if as_json else f"{done} of {runs} runs complete: {out}")
    if done < runs:
        return EXIT_STOPPED
    return EXIT_DOUBTFUL if doubtful else 0
