"""A run from start to end: its folder, the server, the agent, the results."""

import asyncio
import json
import platform
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from folding_schemas.results import RunInfo
from pydantic import ValidationError

from folding_client.assembly import RoleModels, make_role_models, make_worker, needed_tools
from folding_client.exports.live_spans import span_listeners
from folding_client.interrupts import RunStopped, StepFailed, ToolRefused, UsageError
from folding_client.models.requirements import require_models
from folding_client.outputs import write_outputs
from folding_client.progress import Progress
from folding_client.protocol.connection import ServerAddress
from folding_client.protocol.requests import undecided
from folding_client.protocol.server_client import ServerClient
from folding_client.record.event_log import Event, read_events
from folding_client.record.folder import RunFolder, file_trouble
from folding_client.record.recorder import RECORD_FORMAT, Recorder
from folding_client.record.redaction import MARK
from folding_client.run_limits import SharedLimit, in_time
from folding_client.search.hybrid import SOLVER
from folding_client.settings import ROLES, Settings


@dataclass(frozen=True)
class Job:
    """A sequence to reconstruct, or a run to go on with: ``sequence`` is the folder, ``folder`` the run's. ``shared`` is a
    limit that other runs count to as well.
    """

    sequence: Path
    folder: RunFolder
    settings: Settings
    resumes: bool = False
    shared: SharedLimit | None = None

    @property
    def name(self) -> str:
        """What the server calls the sequence."""
        return sequence_name(self.sequence)


@dataclass(frozen=True)
class Outcome:
    """How a run ended: ``status`` is complete, stopped, or interrupted."""

    status: str
    reason: str
    run: dict[str, Any]


def sequence_name(folder: Path) -> str:
    """What the server calls a sequence: the name in its manifest, else that of its folder."""
    try:
        manifest = json.loads((folder / "keyframes.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return folder.name
    name = manifest.get("name") if isinstance(manifest, dict) else None
    return name if isinstance(name, str) and name else folder.name


def new_job(sequence: Path, out: Path | None, settings: Settings) -> Job:
    """A job for a new run. UsageError if the sequence folder is none, or the run folder is taken."""
    folder = _sequence(sequence)
    run = RunFolder(new_folder(folder.name, out))
    run.create()
    return Job(folder, run, settings)


def new_folder(name: str, out: Path | None) -> Path:
    """Where a new run of what is called ``name`` goes: ``out`` if given. UsageError if a run is there already."""
    stamp = datetime.now(UTC).strftime("%Y%m%d-%H%M%S")
    folder = (out or Path("runs") / f"{name}-{stamp}").expanduser().resolve()
    RunFolder(folder).require_free()
    return folder


def resumed_job(path: Path, sequence: Path | None, settings: Settings) -> Job:
    """A job that goes on with a recorded run, with its settings but for those given now.

    UsageError if the sequence or a model given is not the run's, or the run is complete.
    """
    folder = RunFolder(path.expanduser().resolve())
    folder.description("settings", "outcome")
    folder.hold()
    try:
        return _resumed_job(path, folder, sequence, settings)
    except UsageError:
        folder.release()
        raise


def _resumed_job(path: Path, folder: RunFolder, sequence: Path | None, settings: Settings) -> Job:
    about = folder.description("settings", "outcome")
    recorded = Path(about["sequence"]["folder"])
    if sequence is not None and sequence.expanduser().resolve() != recorded:
        message = (
            f"{path} is a run of {recorded}, not of {sequence}; resume it without a sequence, or start "
            "a new run."
        )
        raise UsageError(message)
    if about["outcome"]["status"] == "complete":
        message = f"{path} is complete already; start a new run to do it again."
        raise UsageError(message)
    _require_redacted_anew(path, about["settings"]["given"], settings)
    return Job(_sequence(recorded), folder, _merged(path, about["settings"], settings), resumes=True)


def _require_redacted_anew(path: Path, given: dict[str, Any], settings: Settings) -> None:
    """UsageError if a setting of the run was recorded without its password, and is not given now."""
    for name, value in given.items():
        if MARK in str(value) and name not in settings.model_fields_set:
            option = name.replace("_", "-")
            message = f"The record of {path} holds --{option} without its password; give --{option} again."
            raise UsageError(message)


def _merged(path: Path, recorded: dict[str, Any], settings: Settings) -> Settings:
    """The recorded settings with what is given now; models and variant cannot change."""
    try:
        Settings.model_validate(recorded["given"])
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        message = (
            f"{path} was made with settings that this version does not know ({where}: {first['msg']}); "
            "start a new run."
        )
        raise UsageError(message) from error
    given = {name: getattr(settings, name) for name in settings.model_fields_set}
    for name in ("model", "critic", "overview", "selector", "variant", "few_shot", "attempts", "seed"):
        before = recorded["given"].get(name, recorded["defaulted"].get(name))
        if name in given and given[name] != before:
            message = (
                f"{path} was made with {_given(name, before)}, not {given[name]}; "
                f"resume it without that option, or start a new run."
            )
            raise UsageError(message)
    return Settings.model_validate(recorded["given"] | {name: _plain(value) for name, value in given.items()})


def _given(name: str, value: object) -> str:
    """A setting as a refusal names it."""
    return f"no {name} given" if value is None else f"{name} {value}"


def _plain(value: Any) -> Any:  # noqa: ANN401
    return value.model_dump() if hasattr(value, "model_dump") else value


def _sequence(path: Path) -> Path:
    folder = path.expanduser().resolve()
    if not folder.is_dir():
        message = (
            f"There is no sequence folder {path}; name a folder that holds a keyframes.json, or a video."
        )
        raise UsageError(message)
    if not (folder / "keyframes.json").is_file():
        message = f"{path} holds no keyframes.json and fewer than two photos, so it is no sequence; name a folder that holds one."
        raise UsageError(message)
    return folder


async def reconstruct(job: Job, progress: Progress) -> Outcome:
    """Carry a job out. Whatever ends it, the run folder is complete up to the last event.

    UsageError if the job cannot begin: a new run then leaves no folder. A stop on the way is an outcome.
    """
    try:
        return await _recorded(job, progress)
    except UsageError:
        job.folder.discard()
        raise
    finally:
        job.folder.release()


async def _recorded(job: Job, progress: Progress) -> Outcome:
    """Carry a job out and keep a record of it."""
    job.folder.hold()
    require_models(job.settings)
    about = about_run(job)
    recorder = Recorder(job.folder, about, progress, span_listeners(about, _recorded_before(job)))
    try:
        role_models = make_role_models(job.settings, recorder, job.shared)
        async with run_server(job, recorder) as server:
            return await _worked(job, role_models, server, recorder, progress)
    except (RunStopped, StepFailed, ToolRefused) as stop:
        return _ended(recorder, "stopped", str(stop))
    except asyncio.CancelledError:
        _ended(recorder, "interrupted", "interrupted; resume to go on")
        raise
    except OSError as error:
        _ended_by_a_file(recorder, f"{file_trouble(error)}, then resume")
        raise
    finally:
        recorder.close()


def _recorded_before(job: Job) -> Iterator[Event]:
    """The events of a run that is resumed."""
    if job.resumes and job.folder.events.exists():
        yield from read_events(job.folder.events)


async def _worked(
    job: Job, role_models: RoleModels, server: ServerClient, recorder: Recorder, progress: Progress
) -> Outcome:
    info = await opened_run(job, server, recorder)
    worker = make_worker(
        role_models, job.settings, server, recorder, progress, (info.front_color, info.back_color)
    )
    try:
        info = await in_time(worker.run(), job.settings.max_time, recorder.seconds)
    except (RunStopped, StepFailed, ToolRefused) as stop:
        recorder.event("stopped", cause=type(stop).__name__, reason=str(stop))
        if worker.simulates:
            await _save_what_is_there(server, recorder)
        raise
    if worker.simulates:
        await write_outputs(server, recorder, info)
    return _ended(recorder, "complete", "", info)


async def opened_run(job: Job, server: ServerClient, recorder: Recorder) -> RunInfo:
    """The job's run, opened on a server; what was on its way when it was cut short is settled first. UsageError if the
    server refuses it.
    """
    await _settle(job, server, recorder)
    try:
        info = await server.open_run(job.name, recorder.about.get("run_id"), job.settings.attempts)
    except ToolRefused as refusal:
        raise UsageError(str(refusal)) from refusal
    if job.resumes and info.pending:
        info = await _back_at_its_checkpoint(server, info)
    recorder.about |= {"run_id": info.run_id, "server_version": server.version}
    recorder.about["sequence"] |= {"frames": info.frames}
    recorder.event("resumed" if job.resumes else "opened", run_id=info.run_id, saved=info.saved)
    recorder.outcome("running", "", len(info.saved), info.frames)
    return info


async def _settle(job: Job, server: ServerClient, recorder: Recorder) -> None:
    """Have the call answered that was on its way when the run was cut short, and record what that decided."""
    if recorder.unanswered is not None:
        await server.answer(recorder.unanswered)
    if not job.resumes:
        return
    saved = undecided(read_events(job.folder.events), recorder.about["run_id"])
    if saved is not None:
        by = SOLVER if job.settings.hybrid and saved.by == "client" else job.settings.role("agent")
        recorder.event("step_over", frame=saved.frame, complete=saved.complete, by=by)


async def _back_at_its_checkpoint(server: ServerClient, info: RunInfo) -> RunInfo:
    """The run without the actions of the step that was cut short."""
    await server.return_to((info.next_frame or info.frames + 1) - 1)
    return await server.where()


async def _save_what_is_there(server: ServerClient, recorder: Recorder) -> None:
    """Results of an unfinished run, as far as the server still answers."""
    try:
        await server.settle()
        info = await server.where()
        recorder.outcome("stopped", "", len(info.saved), info.frames)
        if info.saved:
            await write_outputs(server, recorder, info)
    except (RunStopped, ToolRefused) as failure:
        recorder.event("outputs_missing", reason=str(failure))


def _ended(recorder: Recorder, status: str, reason: str, info: RunInfo | None = None) -> Outcome:
    before = recorder.about.get("outcome", {})
    saved, frames = (
        (len(info.saved), info.frames) if info else (before.get("frames_saved", 0), before.get("frames", 0))
    )
    recorder.event("ended", status=status, reason=reason)
    recorder.outcome(status, reason, saved, frames)
    return Outcome(status, reason, recorder.about)


def _ended_by_a_file(recorder: Recorder, reason: str) -> None:
    """Say in the log and in ``run.json`` that the run stopped, in each as far as it can be written."""
    before = recorder.about.get("outcome", {})
    with suppress(OSError):
        recorder.event("ended", status="stopped", reason=reason)
    with suppress(OSError):
        recorder.outcome("stopped", reason, before.get("frames_saved", 0), before.get("frames", 0))


@asynccontextmanager
async def run_server(job: Job, recorder: Recorder) -> AsyncIterator[ServerClient]:
    """The folding server for a job, started and ended with it; its stderr goes to ``server.log``."""
    address = ServerAddress(job.sequence, job.folder.store, job.settings.server_url)
    with (job.folder.path / "server.log").open("a", encoding="utf-8") as log:
        server = ServerClient(address, recorder, log)
        try:
            await server.start()
            server.require(sorted(needed_tools(job.settings)))
            yield server
        finally:
            await server.close()


def about_run(job: Job) -> dict[str, Any]:
    """What ``run.json`` says of a run beside its outcome."""
    if job.resumes:
        return job.folder.description() | {"settings": job.settings.described()}
    roles = {role: job.settings.role(role) for role in ROLES} | {"agent": job.settings.model}
    return {
        "format": RECORD_FORMAT,
        "created": datetime.now(UTC).isoformat(),
        "sequence": {"name": job.name, "folder": str(job.sequence)},
        "models": roles,
        "settings": job.settings.described(),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """The versions of what takes part in a run; litellm's only where it is installed."""
    named = ["foldingagent-mcp", "mcp", *(["litellm"] if find_spec("litellm") else [])]
    return {name: version(name) for name in named} | {"python": platform.python_version()}
