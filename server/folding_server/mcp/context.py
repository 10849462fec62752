"""The app context: what the tools share.

It finds the run that a call means, and the paper and the photos that go with it.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, Self, TypeAlias
from uuid import UUID

from folding_schemas.attempt_limits import TECHNICAL_RETURN
from folding_schemas.request_id import REQUEST_ID
from mcp.server.mcpserver import Context

from folding_server.errors import FoldingError, RunError
from folding_server.mcp.auth import caller
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.mcp.tool_record import ToolSelection
from folding_server.simulator import Paper
from folding_server.store.limits import BUDGET, NO_LIMITS, OwnerLimits
from folding_server.store.non_blocking import WouldBlock, may_block
from folding_server.store.rules import check_same_sequence
from folding_server.workers.job_queue import OWNER_WAITING, WAITING, QueueLimits

if TYPE_CHECKING:
    from folding_server.frames.added_sequences import AddedSequences
    from folding_server.frames.allowed_folders import AllowedFolders
    from folding_server.frames.photo_cache import PhotoCache
    from folding_server.frames.sequences import Library, Sequence
    from folding_server.store.change import Change
    from folding_server.store.owners import RunSummary
    from folding_server.store.run_store import RunStore
    from folding_server.store.views import RunView
    from folding_server.workers.worker_pool import WorkerPool

_logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServerSettings:
    """What a server is started with.

    ``data`` is the folder for its database unless ``database``, a SQLAlchemy URL, names another. Sequences
    are served from the folders ``sequences`` alone, and those that callers have added from the files below the folders
    ``allowed``, which no other caller may read. ``shared`` is true where many hosts reach one process:
    then every call has to name its run. ``tool_set``, ``read_only`` and ``for_evaluation`` choose the tools that are offered; ``limits`` hold for
    each owner of tokens. Long calls are computed by ``vision_workers`` processes, or with 0 by threads of this one;
    ``vision_queue`` of them may wait. ``attempts`` is how many a frame has in runs that are opened without a number of their own.
    """

    data: Path
    database: str | None = None
    sequences: tuple[Path, ...] = ()
    allowed: tuple[Path, ...] = ()
    shared: bool = False
    tool_set: ToolSelection = "all"
    read_only: bool = False
    for_evaluation: bool = False
    limits: OwnerLimits = NO_LIMITS
    vision_workers: int = 0
    vision_queue: int = WAITING
    attempts: int = BUDGET


class AppContext:
    """The shared state of one server process.

    Runs live in the store; here are only caches and the newest run. The store and the library are
    opened when first asked for, so that a server starts without what they load. ``workers`` may be shared with others: then
    whoever made them closes them.
    """

    def __init__(self, settings: ServerSettings, workers: "WorkerPool | None" = None) -> None:
        self.settings = settings
        self.replays = ReplayCache()
        self._shared_workers = workers
        self._workers: WorkerPool | None = None
        self._store: RunStore | None = None
        self.placing = Lock()
        """Held while an added sequence is given its name and its place."""
        self._libraries: dict[str | None, Library] = {}
        self._photos: PhotoCache | None = None
        self._newest: str | None = None
        self._guard = Lock()

    @property
    def store(self) -> "RunStore":
        """The store of all runs. RunError if its database cannot be used."""
        if (opened := self._store) is not None:
            return opened
        from folding_server.store.run_store import RunStore  # noqa: PLC0415  (loads SQLAlchemy)

        with self._guard:
            if self._store is None:
                url, limits = self.settings.database, self.settings.limits
                self._store = RunStore(url, limits) if url else RunStore.in_folder(self.settings.data, limits)
            return self._store

    @property
    def library(self) -> "Library":
        """The sequences that may be served to the caller: everybody's, and those that the caller has added.

        PhotoError if one of their folders is missing.
        """
        return self._library_of(caller())

    def _library_of(self, owner: str | None) -> "Library":
        """The sequences that an owner may be served, or whoever calls without a token."""
        from folding_server.frames.added_sequences import added_folder  # noqa: PLC0415  (loads numpy and Pillow)
        from folding_server.frames.photo_cache import PhotoCache  # noqa: PLC0415
        from folding_server.frames.sequences import Library  # noqa: PLC0415

        if not may_block():
            raise WouldBlock
        with self._guard:
            if owner not in self._libraries:
                added = added_folder(self.settings.data, owner)
                self._photos = self._photos or PhotoCache()
                self._libraries[owner] = Library(self.settings.sequences, added, self._photos)
            return self._libraries[owner]

    def added_sequences(self) -> "AddedSequences":
        """The sequences that the caller has added, to add others."""
        from folding_server.frames.added_sequences import AddedSequences  # noqa: PLC0415

        return AddedSequences(self.settings.data, caller())

    def allowed_folders(self) -> "AllowedFolders":
        """The folders whose files may be read for a caller; never what the server itself keeps."""
        from folding_server.frames.allowed_folders import AllowedFolders  # noqa: PLC0415

        return AllowedFolders(self.settings.allowed, self.settings.data, short=self.settings.shared)

    @property
    def workers(self) -> "WorkerPool":
        """What computes long calls. Processes start when they are first needed."""
        from folding_server.workers.worker_pool import usual_pool  # noqa: PLC0415

        with self._guard:
            if self._shared_workers is not None:
                return self._shared_workers
            if self._workers is None:
                limits = self.settings.limits
                self._workers = usual_pool(
                    self.settings.vision_workers,
                    QueueLimits(
                        self.settings.vision_queue,
                        OWNER_WAITING if limits.vision_waiting is None else limits.vision_waiting,
                        limits.vision_at_once,
                    ),
                )
            return self._workers

    def prepare(self) -> None:
        """Open the store and the library now, so that what is wrong with them shows before anyone calls."""
        _ = self.store, self.library

    def open(
        self, sequence: str | None, request_id: str | None = None, attempts: int | None = None
    ) -> "RunView":
        """Start a run of a sequence, or a free fold; or answer with the run that the request has started before.

        ``attempts`` is how many a frame has, if not as many as the server was started with. PhotoError if there is no such
        sequence, RunError if it has changed since the request was sent first.
        """
        from folding_server.diagram.palette import colors_of  # noqa: PLC0415  (loads shapely)

        if sequence is None:
            if attempts is not None:
                raise RunError(
                    "A free fold has no attempts to count; leave attempts out, or name a sequence."
                )
            free = colors_of(None, None)
            return self._open(
                self.store.create(
                    front_color=free.front, back_color=free.back, request_id=request_id, owner=caller()
                )
            )
        photos = self.library.open(sequence)
        colors = colors_of(photos.front_color, photos.back_color)
        run = self.store.create(
            sequence=photos.name,
            frames=photos.frame_count,
            fingerprint=photos.fingerprint(),
            front_color=colors.front,
            back_color=colors.back,
            budget=attempts or self.settings.attempts,
            request_id=request_id,
            owner=caller(),
        )
        check_same_sequence(run, photos.fingerprint())
        return self._open(run)

    def resume(self, run_id: str, sequence: str | None = None, attempts: int | None = None) -> "RunView":
        """Take up a run again.

        RunError if there is none, or it is of another sequence or has other attempts, or its photos have changed.
        """
        run = self.run(run_id)
        if attempts is not None and attempts != run.budget:
            has = f"{run.budget} attempts a frame" if run.budget else "no attempts to count"
            raise RunError(f"Run {run_id} has {has}, not {attempts}; leave attempts out to resume it.")
        if sequence is not None and sequence != run.sequence:
            kind = f"of sequence {run.sequence!r}" if run.sequence else "a free fold"
            raise RunError(
                f"Run {run_id} is {kind}, not of {sequence!r:.80}; leave sequence out to resume it."
            )
        if run.sequence is not None:
            check_same_sequence(run, self.sequence(run).fingerprint())
        return self._open(run)

    def run(self, run_id: str | None) -> "RunView":
        """The run that a call means, as it stands.

        RunError if it is unknown, or none is named and none is meant.
        """
        return self.store.load(self._named(run_id))

    @property
    def newest(self) -> str | None:
        """The id of the run opened last in this process."""
        return self._newest

    @contextmanager
    def change(self, ctx: "ToolContext", run_id: str | None) -> Iterator["Change"]:
        """One change of the run that a call means, decided on and recorded in one transaction of the store.

        Folding the paper up to where it stands can take long after a restart, so it is done before the
        transaction begins; a call that may not wait gives up instead. RunError if the run is unknown, none is meant, or the call's request id is none.
        """
        run_id, request_id = self._named(run_id), request_id_of(ctx)
        if may_block():
            self.paper(self.store.last_seen(run_id))
        with self.store.change(run_id, request_id) as change:
            yield change

    async def on_disk(self) -> None:
        """Wait until what was carried out in this event loop is on the disk: now it may be answered."""
        if self._store is not None:
            await self._store.on_disk()

    def paper(self, run: "RunView") -> Paper:
        """The current state of a run."""
        return self.replays.after(run.sheet, run.actions)

    def list_runs(self, limit: int, before: str | None = None) -> "list[RunSummary]":
        """A page of the caller's own runs, or of all where callers have no tokens, newest first.

        Those after run ``before``; RunError if there is no such run.
        """
        return self.store.list_runs(caller(), limit, before)

    def told(self, error: FoldingError) -> str:
        """What the caller is told of a mistake: over HTTP without places of this machine, which go to the log."""
        if not self.settings.shared or error.elsewhere == str(error):
            return str(error)
        _logger.warning("Refused: %s", error)
        return error.elsewhere

    def limited_owner(self) -> str | None:
        """The caller's owner, if there is a limit to the time of their vision; else None."""
        return None if self.settings.limits.vision_seconds is None else caller()

    def count_vision(self, owner: str, seconds: float) -> None:
        """Count the time of a call for its owner. An answer that was computed is not lost for it."""
        try:
            self.store.add_vision(owner, seconds)
        except FoldingError as error:
            _logger.warning("The vision time of %s was not counted: %s", owner, error)

    def sequence(self, run: "RunView") -> "Sequence":
        """The photos of a run, which may be one that its owner has added: whoever reaches a run sees its photos.

        RunError for a free fold.
        """
        if run.sequence is None:
            raise RunError(
                f"Run {run.run_id} is a free fold without photos; call open_run with a sequence to have some."
            )
        return self._library_of(self.store.owner_of(run.run_id)).open(run.sequence)

    def close(self) -> None:
        """Give back the database's connections, and end worker processes."""
        with self._guard:
            if self._workers is not None:
                self._workers.close()
                self._workers = None
            if self._store is not None:
                self._store.close()
                self._store = None

    def __enter__(self) -> Self:
        """Nothing is opened yet."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the store and the workers."""
        self.close()

    def _open(self, run: "RunView") -> "RunView":
        self._newest = run.run_id
        return run

    def require_own(self, run_id: str) -> None:
        """Raise RunError, as for a run that there is not, if the run belongs to another than the caller."""
        self.store.require_owner(run_id, caller())

    def _named(self, run_id: str | None) -> str:
        """The run id given, or that of the run opened last in this process.

        RunError where that says nothing, and where the run belongs to another than the caller.
        """
        if run_id is not None:
            self.require_own(run_id)
            return run_id
        if self.settings.shared:
            raise RunError("This server serves many hosts at once; pass the run_id that open_run answered.")
        if self._newest is None:
            raise RunError(
                "No run has been opened since the server started; call open_run, or pass a run_id from list_runs."
            )
        return self._newest


ToolContext: TypeAlias = Context[AppContext, Any]
"""What a tool is told about the call it answers; it holds the app context."""


def app_context(ctx: ToolContext) -> AppContext:
    """The app context of the server that a call reached."""
    return ctx.request_context.lifespan_context


def request_id_of(ctx: ToolContext) -> str | None:
    """The UUID that the caller gave this call, so as to send it again if need be. RunError if it is none."""
    given = (ctx.request_context.meta or {}).get(REQUEST_ID)
    if given is None:
        return None
    try:
        return str(UUID(str(given)))
    except ValueError as error:
        raise RunError(
            f"{REQUEST_ID} {given!r:.80} is not possible: it must be a UUID made for this call; "
            f"send one, or none at all."
        ) from error


def is_technical(ctx: ToolContext) -> bool:
    """Whether the client goes back for a technical reason, as it says in the call's ``_meta``. RunError for another word."""
    given = (ctx.request_context.meta or {}).get(TECHNICAL_RETURN, False)
    if not isinstance(given, bool):
        raise RunError(f"{TECHNICAL_RETURN} {given!r:.80} is not possible; send true, or leave it out.")
    return given
