"""``foldingagent``: reconstruct sequences, resume and replay runs."""

import asyncio
import json
import signal
import sys
from collections.abc import Coroutine, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from folding_schemas.actions import Program, action_text
from pydantic import ValidationError
from rich.console import Console

from folding_client import options
from folding_client.batch.runner import BatchEntry, Listener, run_batch, sequences_of
from folding_client.interrupts import Interrupt, UsageError
from folding_client.progress import Shown
from folding_client.reconstruct import Job, Outcome, new_folder, new_job, reconstruct, resumed_job
from folding_client.record.folder import RunFolder, file_trouble
from folding_client.record.redaction import redact
from folding_client.record.replay import replay_run
from folding_client.settings import Settings
from folding_client.videos import sequence_of_video

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Reconstruct folding programs from photos of origami.",
)
_Answer = TypeVar("_Answer")
EXIT_STOPPED = 3
_SHOWN = 20
_DONE = frozenset({"complete", "skipped"})
EXIT_INTERRUPTED = 130


@app.callback()
def _commands(_version: options.VersionOption = False) -> None:
    """Reconstruct folding programs from photos of origami."""


@app.command()
@options.with_settings
def run(
    given: options.Given,
    sequence: options.SequenceFolder = None,
    out: options.Out = None,
    resume: options.Resume = None,
    as_json: options.AsJson = False,
) -> None:
    """Reconstruct a sequence or a video, or go on with a run."""
    settings = _settings(given)
    if sequence is not None and sequence.is_file() and resume is None:
        out = new_folder(sequence.stem, out)
        sequence = _finish(_sequence_of(sequence, out, settings), "no run has begun")
    job = _job(sequence, out, resume, settings)
    with Shown(Console(stderr=True)) as progress:
        again = f"the run folder is complete so far, go on with --resume {job.folder.path}"
        outcome = _finish(reconstruct(job, progress), again)
    _show(outcome, job.folder.path, as_json=as_json)
    if outcome.status != "complete":
        raise typer.Exit(EXIT_STOPPED)


async def _sequence_of(video: Path, out: Path, settings: Settings) -> Path:
    """The sequence folder of a video, written into the run folder to be; nothing is left of it if that fails or is
    cut short.
    """
    if settings.server_url is not None:
        message = (
            f"A running server cannot be handed the video {video.name}; leave out --server-url, or write its "
            "keyframes where that server looks for sequences."
        )
        raise UsageError(message)
    folder = RunFolder(out)
    folder.claim()
    try:
        return await sequence_of_video(video, out / "sequence", partial(typer.echo, err=True))
    except (UsageError, asyncio.CancelledError):
        folder.discard()
        raise
    finally:
        folder.release()


def _job(sequence: Path | None, out: Path | None, resume: Path | None, settings: Settings) -> Job:
    if resume is not None:
        if out is not None:
            message = f"A run goes on in its own folder, {resume}; leave out --out, or start a new run without --resume."
            raise UsageError(message)
        return resumed_job(resume, sequence, settings)
    if sequence is not None:
        return new_job(sequence, out, settings)
    message = "Name a sequence folder or a video to reconstruct, or a run to go on with: --resume DIR."
    raise UsageError(message)


@app.command("replay")
def replay_command(
    recorded: Annotated[Path, typer.Argument(parser=options.path, help="Folder of a recorded run.")],
    sequence: Annotated[
        Path | None, typer.Option(parser=options.path, help="Where the sequence is now, if it has moved.")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Drive the server through a recorded run without a model, and say where its answers differ."""
    found = _finish(replay_run(recorded, sequence), "the recorded run is as it was")
    if as_json:
        typer.echo(json.dumps(asdict(found), indent=1))
    else:
        for difference in found.differences[:_SHOWN]:
            typer.echo(f"event {difference.seq}, {difference.tool}: {difference.what}")
        typer.echo(f"{found.calls} calls replayed, {len(found.differences)} answered differently.")
    if found.differences:
        raise typer.Exit(1)


@app.command("batch")
@options.with_settings
def batch_command(
    given: options.Given,
    source: Annotated[
        Path, typer.Argument(parser=options.path, help="Folder of sequences, or a file that lists folders.")
    ],
    jobs: Annotated[int | None, typer.Option(min=1, help="Sequences at a time; 1 if left out.")] = None,
    dask: Annotated[str | None, typer.Option(help="Address of a Dask scheduler whose workers do it.")] = None,
    out: Annotated[Path, typer.Option(parser=options.path, help="Where the run folders go.")] = Path("runs"),
    as_json: options.AsJson = False,
) -> None:
    """Reconstruct many sequences; finished ones are skipped, unfinished ones continued."""
    settings = _settings(given)
    work = _batch(sequences_of(source), out.resolve(), settings, jobs, dask)
    lines = _finish(work, "the same command goes on from here")
    if as_json:
        typer.echo(json.dumps([asdict(line) for line in lines], indent=1))
    else:
        done = sum(line.status in _DONE for line in lines)
        typer.echo(f"{done} of {len(lines)} sequences complete: {out}")
    if any(line.status not in _DONE for line in lines):
        raise typer.Exit(EXIT_STOPPED)


def _batch(
    sequences: list[Path], out: Path, settings: Settings, jobs: int | None, dask: str | None
) -> Coroutine[Any, Any, list[BatchEntry]]:
    """The work of a batch, in this process or on a cluster."""
    if dask is None:
        return run_batch(sequences, out, settings, jobs or 1, _Printed())
    if jobs is not None:
        message = (
            "--jobs is for work in this process; with --dask the cluster has as many at a time as threads."
        )
        raise UsageError(message)
    from folding_client.batch.cluster import run_on_cluster

    return run_on_cluster(dask, sequences, out, settings, _Printed())


class _Printed(Listener):
    """Says on stderr how each sequence ended."""

    def ended(self, line: BatchEntry) -> None:
        """One line per sequence."""
        reason = f": {line.reason}" if line.reason else ""
        typer.echo(
            f"{line.sequence}: {line.status}, {line.frames_saved} of {line.frames} frames, "
            f"{line.seconds:.1f} s{reason}",
            err=True,
        )


def _settings(given: options.Given) -> Settings:
    try:
        return Settings.model_validate(given)
    except ValidationError as error:
        first = error.errors()[0]
        option = "--" + str(first["loc"][0]).replace("_", "-") if first["loc"] else ""
        said = f"{option} cannot be {first['input']!r}: {first['msg']}." if option else f"{first['msg']}."
        message = said.removeprefix("Value error, ")
        raise UsageError(message) from error


def _finish(work: Coroutine[Any, Any, _Answer], afterwards: str) -> _Answer:
    """Run to the end. SIGTERM ends it as Ctrl-C does: with one line that says what can be done ``afterwards``."""
    try:
        return asyncio.run(_cancelled_by_sigterm(work))
    except (KeyboardInterrupt, asyncio.CancelledError):
        typer.echo(f"Interrupted; {afterwards}.", err=True)
        raise typer.Exit(EXIT_INTERRUPTED) from None


async def _cancelled_by_sigterm(work: Coroutine[Any, Any, _Answer]) -> _Answer:
    task = asyncio.current_task()
    if task is not None and sys.platform != "win32":  # where asyncio has no signal handlers
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, task.cancel)
    return await work


def _show(outcome: Outcome, folder: Path, *, as_json: bool) -> None:
    program = _read(folder / "program.json") if (folder / "program.json").exists() else None
    if as_json:
        document = {
            "run": str(folder),
            "status": outcome.status,
            "reason": outcome.reason,
            "program": program,
            "outcome": outcome.run["outcome"],
            "totals": outcome.run["totals"],
        }
        typer.echo(redact(json.dumps(document, indent=1)))
        return
    if program is not None:
        typer.echo(f"Program of {program['name']}:")
        notes = {saved["frame"]: saved["notes"] or "" for saved in _read(folder / "checkpoints.json")}
        for frame, step in enumerate(Program.model_validate(program).steps, start=2):
            doubt = f"  ({notes[frame]})" if "not a match" in notes.get(frame, "") else ""
            typer.echo(f"  {frame - 1} -> {frame}  {'; '.join(map(action_text, step)) or 'nothing'}{doubt}")
    summary = outcome.run["outcome"]
    saved = f"{summary['frames_saved']} of {summary['frames']} frames saved"
    typer.echo(f"{saved} in {summary['seconds']:.1f} s: {folder}")
    if outcome.status != "complete":
        typer.echo(redact(outcome.reason), err=True)


def _read(file: Path) -> Any:  # noqa: ANN401
    return json.loads(file.read_text(encoding="utf-8"))


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: a user's mistake is one line and exit code 2, a file that cannot be written one line and 3."""
    try:
        app(args=arguments)
    except Interrupt as error:
        typer.echo(redact(str(error)), err=True)
        sys.exit(2 if isinstance(error, UsageError) else EXIT_STOPPED)
    except OSError as error:
        typer.echo(redact(f"{file_trouble(error)}, then go on with --resume or the same command."), err=True)
        sys.exit(EXIT_STOPPED)
