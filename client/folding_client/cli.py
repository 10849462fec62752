"""``foldingagent``: reconstruct sequences, resume and replay runs, ask what models cost and how well a critic judges."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console

from folding_client import options
from folding_client.batch.batch_command import BatchOptions, carry_out_batch
from folding_client.batch.sequence_lists import sequences_of
from folding_client.critic_accuracy.accuracy import accuracy_lines, critic_accuracy, sequences_with_truth
from folding_client.data_sets.import_command import import_purelandfold_command
from folding_client.dry_run import DryRun, dry_run, dry_run_lines
from folding_client.evaluation.evaluate_command import evaluate_command
from folding_client.exits import EXIT_DIFFERENT, EXIT_DOUBTFUL, EXIT_STOPPED, end_cleanly, finish
from folding_client.exports.exported_run import exported_runs
from folding_client.exports.inspect_logs import write_inspect_logs
from folding_client.exports.spans import send_spans
from folding_client.interrupts import UsageError
from folding_client.models.model_table import model_lines, model_table
from folding_client.models.requirements import require_models
from folding_client.photo_folders import as_sequence
from folding_client.progress import Shown, Silent
from folding_client.reconstruct import Job, Outcome, new_folder, new_job, reconstruct, resumed_job
from folding_client.record.redaction import redact
from folding_client.record.replay import replay_run
from folding_client.report_commands import report_command
from folding_client.setting_sources import settings_from
from folding_client.settings import Settings
from folding_client.study_commands import study_command, study_score_command
from folding_client.summaries import fits_of, outcome_document, outcome_lines
from folding_client.videos import video_in_run_folder

app = typer.Typer(
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    help="Reconstruct folding programs from photos of origami.",
)
_SHOWN = 20


@app.callback()
def _commands(
    context: typer.Context,
    _version: options.VersionOption = False,
    _log_level: options.LogLevelOption = None,
) -> None:
    """Reconstruct folding programs from photos of origami."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command()
@options.with_settings
def run(
    given: options.Given,
    sequence: options.SequenceFolder = None,
    out: options.Out = None,
    resume: options.Resume = None,
    config: options.Config = None,
    dry: options.DryRunOption = False,
    verbose: options.Verbose = False,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Reconstruct a sequence or a video, or go on with a run."""
    if resume is not None:
        job = _resumed(resume, sequence, out, settings_from(given, config, {}))
    else:
        settings = settings_from(given, config)
        require_models(settings, keys=not dry)
        if dry:
            _show_request(sequence, settings, as_json=as_json)
            return
        job = _new(sequence, out, settings)
    again = f"the run folder is complete so far, go on with --resume {job.folder.path}"
    _end(finish(_shown(job, verbose=verbose, quiet=quiet), again), job.folder.path, as_json=as_json)


def _resumed(resume: Path, sequence: Path | None, out: Path | None, settings: Settings) -> Job:
    if out is not None:
        message = f"A run goes on in its own folder, {resume}; leave out --out, or start a new run without --resume."
        raise UsageError(message)
    return resumed_job(resume, sequence, settings)


def _new(sequence: Path | None, out: Path | None, settings: Settings) -> Job:
    sequence = _named(sequence)
    if sequence.is_file():
        out = new_folder(sequence.stem, out)
        work = video_in_run_folder(sequence, out, settings, partial(typer.echo, err=True))
        sequence = finish(work, "no run has begun")
    as_sequence(sequence.expanduser(), partial(typer.echo, err=True))
    return new_job(sequence, out, settings)


def _named(sequence: Path | None) -> Path:
    if sequence is not None:
        return sequence
    message = "Name a sequence folder or a video to reconstruct, or a run to go on with: --resume DIR."
    raise UsageError(message)


async def _shown(job: Job, *, verbose: bool, quiet: bool) -> Outcome:
    """The outcome of a job, with its progress on stderr."""
    if quiet:
        return await reconstruct(job, Silent())
    with Shown(Console(stderr=True), verbose=verbose) as progress:
        return await reconstruct(job, progress)


def _end(outcome: Outcome, folder: Path, *, as_json: bool) -> None:
    """Print how a run ended, and end the command so."""
    if as_json:
        typer.echo(redact(json.dumps(outcome_document(outcome, folder), indent=1)))
    else:
        typer.echo(redact("\n".join(outcome_lines(outcome, folder))))
        if outcome.status != "complete":
            typer.echo(redact(outcome.reason), err=True)
    if outcome.status != "complete":
        raise typer.Exit(EXIT_STOPPED)
    if fits_of(outcome).mostly_doubtful:
        raise typer.Exit(EXIT_DOUBTFUL)


def _show_request(sequence: Path | None, settings: Settings, *, as_json: bool) -> None:
    request: DryRun = finish(dry_run(_named(sequence), settings), "no run has begun")
    typer.echo(
        redact(
            json.dumps(asdict(request), indent=1) if as_json else "\n".join(dry_run_lines(request)),
        )
    )


@app.command("replay")
def replay_command(
    recorded: Annotated[Path, typer.Argument(parser=options.path, help="Folder of a recorded run.")],
    sequence: Annotated[
        Path | None, typer.Option(parser=options.path, help="Where the sequence is now, if it has moved.")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Drive the server through a recorded run without a model, and say where its answers differ."""
    found = finish(replay_run(recorded, sequence), "the recorded run is as it was")
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=1))
    else:
        for difference in found.differences[:_SHOWN]:
            typer.echo(f"event {difference.seq}, {difference.tool}: {difference.what}")
        typer.echo(f"{found.calls} calls replayed, {len(found.differences)} answered differently.")
    if found.differences:
        raise typer.Exit(EXIT_DIFFERENT)


@app.command("batch")
@options.with_settings
def batch_command(
    given: options.Given,
    source: Annotated[
        Path,
        typer.Argument(
            parser=options.path,
            help="Folder of sequences, a file that lists folders, or an experiment in YAML.",
        ),
    ],
    models: options.Models = None,
    variants: options.Variants = None,
    seeds: options.Seeds = None,
    jobs: options.Jobs = None,
    tries: options.Tries = None,
    max_batch_cost: options.MaxBatchCost = None,
    dask: options.Dask = None,
    shard: options.ShardOption = None,
    out: Annotated[
        Path | None, typer.Option(parser=options.path, help="Where the run folders go; runs if left out.")
    ] = None,
    config: options.Config = None,
    as_json: options.AsJson = False,
) -> None:
    """Reconstruct many sequences; finished ones are skipped, unfinished ones continued."""
    said = BatchOptions(
        given,
        config,
        out,
        models or (),
        variants or (),
        seeds or (),
        jobs,
        tries,
        max_batch_cost,
        dask,
        shard,
    )
    if code := carry_out_batch(source, said, as_json=as_json):
        raise typer.Exit(code)


@app.command("critic-accuracy")
@options.with_settings
def critic_accuracy_command(
    given: options.Given,
    source: Annotated[
        Path,
        typer.Argument(
            parser=options.path,
            help="Folder of sequences that hold their program, or a file that lists folders.",
        ),
    ],
    count: Annotated[int, typer.Option(min=1, help="Right states to show, and as many wrong ones.")] = 25,
    out: Annotated[
        Path | None,
        typer.Option(
            parser=options.path, help="Folder of the record; runs/critic-accuracy-TIME if left out."
        ),
    ] = None,
    config: options.Config = None,
    as_json: options.AsJson = False,
) -> None:
    """Measure how often a critic takes right states for a match and wrong ones for none."""
    settings = settings_from(given, config)
    sequences = sequences_with_truth(sequences_of(source))
    require_models(settings)
    folder = new_folder("critic-accuracy", out)
    say = partial(typer.echo, err=True)
    found = finish(
        critic_accuracy(sequences, count, settings.seed, settings, folder, say), f"the record is in {folder}"
    )
    typer.echo(redact(json.dumps(asdict(found), indent=1) if as_json else "\n".join(accuracy_lines(found))))
    if found.stopped:
        typer.echo(redact(found.stopped), err=True)
        raise typer.Exit(EXIT_STOPPED)


app.command("evaluate")(evaluate_command)
app.command("import-purelandfold")(import_purelandfold_command)


@app.command("export-logs")
def export_logs_command(
    runs: Annotated[
        list[Path], typer.Argument(parser=options.path, help="Run folders, or folders of them, at any depth.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", parser=options.path, help="Folder for logs in Inspect's format."),
    ] = None,
    kind: Annotated[Literal["eval", "json"], typer.Option("--format", help="eval or json.")] = "eval",
    images: Annotated[bool, typer.Option(help="Keep the pictures in the logs.")] = True,
    spans: Annotated[
        bool, typer.Option("--spans", help="Send OpenTelemetry spans to OTEL_EXPORTER_OTLP_ENDPOINT.")
    ] = False,
) -> None:
    """Write recorded runs as logs of Inspect, or send them as OpenTelemetry spans."""
    if out is None and not spans:
        message = "Name a folder for the logs with -o, or give --spans."
        raise UsageError(message)
    if out is not None:
        for file in write_inspect_logs(exported_runs(runs), out, kind, images=images):
            typer.echo(file)
    if spans:
        typer.echo(f"{send_spans(exported_runs(runs))} spans sent.")


@app.command("models")
@options.with_settings
def models_command(
    given: options.Given,
    names: Annotated[
        list[str] | None, typer.Argument(help="Ids of models; those of the settings if left out.")
    ] = None,
    config: options.Config = None,
    as_json: options.AsJson = False,
) -> None:
    """Say which models the settings name, whether their keys are there, what they can do, and what they cost."""
    table = model_table(settings_from(given, config), names or [])
    typer.echo(
        json.dumps(asdict(table), indent=1) if as_json else redact("\n".join(model_lines(table))),
    )


app.command("report")(report_command)
app.command("study")(study_command)
app.command("study-score")(study_score_command)


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: whatever goes wrong is one line, with the exit code for its kind."""
    end_cleanly(partial(app, args=arguments, standalone_mode=False))
