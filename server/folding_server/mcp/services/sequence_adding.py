"""Adding a sequence from the files of a user, under a name that no other has and that no run depends on."""

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import anyio
from folding_schemas.results import SequenceOutcome

from folding_server.errors import PhotoError, RunError
from folding_server.mcp.auth import caller
from folding_server.mcp.services.long_calls import aside
from folding_server.mcp.services.sequence_jobs import MadeSequence, SequenceWork, writing_sequences
from folding_server.mcp.services.sequence_material import material_at, title_of

if TYPE_CHECKING:
    from folding_server.frames.added_sequences import AddedSequence, AddedSequences
    from folding_server.frames.sequence_building import BuiltSequence
    from folding_server.frames.sequence_folder import DeclaredSheet
    from folding_server.mcp.context import AppContext

Making: TypeAlias = Callable[[SequenceWork, Path], Awaitable[MadeSequence]]
"""Writes a sequence into an empty folder, wherever that is computed."""


@dataclass(frozen=True)
class SequenceWish:
    """What a caller asks for: paths as typed; None for what is left to the server."""

    paths: tuple[str, ...]
    name: str | None = None
    keyframes: tuple[int, ...] | None = None
    front_color: str | None = None
    back_color: str | None = None
    still_seconds: float | None = None


@dataclass(frozen=True)
class AddedAnswer:
    """What came of it; ``asked`` is the name that the sequence would have if it were free."""

    name: str
    asked: str
    outcome: SequenceOutcome
    kept: "AddedSequence"
    made: MadeSequence


@dataclass(frozen=True)
class _Planned:
    """What is to be made, of which ``source``, and the ``title`` that it is to be found under."""

    added: "AddedSequences"
    source: str
    title: str
    work: SequenceWork


async def add_to_library(app: "AppContext", wish: SequenceWish, make: Making, *, shown: bool) -> AddedAnswer:
    """Make a sequence of a film or of photos, for the caller, with a contact sheet where it is ``shown``.

    If the call is cancelled, nothing is left. PhotoError if the files may not or cannot be read, the name is another
    sequence's, or the disk is full; RunError if an owner may keep or compute nothing more.
    """
    planned = await aside(_planned, app, wish, shown)
    async with _empty_folder(planned.added) as folder:
        made = await make(planned.work, folder)
        return await aside(_keep, app, planned, folder, made)


def _planned(app: "AppContext", wish: SequenceWish, shown: bool) -> _Planned:
    """What is to be made, once everything that the caller said can be."""
    from folding_server.frames.added_sequences import source_digest  # noqa: PLC0415  (loads numpy and Pillow)
    from folding_server.frames.keyframes import check_still_seconds  # noqa: PLC0415
    from folding_server.frames.manifest import check_name  # noqa: PLC0415
    from folding_server.frames.sequence_folder import require_colors  # noqa: PLC0415

    if wish.name is not None:
        check_name(wish.name)
    if wish.still_seconds is not None:
        check_still_seconds(wish.still_seconds)
    material = material_at(wish.paths, app.allowed_folders())
    added = app.added_sequences()
    _check_room(app, added)
    with writing_sequences():
        source = source_digest(list(material.files))
        before = added.made_from(source)
    paper = _paper(wish, before)
    require_colors(paper)
    title = wish.name or (before.title if before else title_of(wish.paths))
    if wish.name is not None:
        _check_free(app, added, wish.name, source)
    work = SequenceWork(material, wish.keyframes, replace(paper, name=title), shown, wish.still_seconds)
    return _Planned(added, source, title, work)


@asynccontextmanager
async def _empty_folder(added: "AddedSequences") -> AsyncIterator[Path]:
    """A folder to write a sequence into, made and removed beside the event loop."""
    making = added.making()
    with writing_sequences():
        folder = await aside(making.__enter__)
    try:
        yield folder
    finally:
        with anyio.CancelScope(shield=True):
            await aside(making.__exit__, None, None, None)


def _keep(app: "AppContext", planned: _Planned, folder: Path, made: MadeSequence) -> AddedAnswer:
    """Put what was made in its place, under a name that no other sequence has."""
    added, sheet = planned.added, planned.work.sheet
    with writing_sequences(), app.placing:
        name, outcome = _name_for(app, added, planned.source, planned.title, made.built, sheet)
        existing = added.find(name)
        kept = (
            existing
            if outcome == "unchanged" and existing
            else added.keep(folder, name, planned.source, planned.title)
        )
    return AddedAnswer(name, planned.title, outcome, kept, made)


def _paper(wish: SequenceWish, before: "AddedSequence | None") -> "DeclaredSheet":
    """The colours: those of the earlier version where a correction says nothing of them."""
    from folding_server.frames.sequence_folder import DeclaredSheet  # noqa: PLC0415

    known = before.manifest if before else None
    return DeclaredSheet(
        front_color=wish.front_color or (known.front_color if known else None),
        back_color=wish.back_color or (known.back_color if known else None),
    )


def _check_room(app: "AppContext", added: "AddedSequences") -> None:
    """Raise RunError if the caller's sequences take up as much as an owner may have."""
    owner, most = caller(), app.settings.limits.bytes
    if owner is not None and most is not None:
        app.settings.limits.check_sequence_bytes(owner, added.bytes_stored())


def _check_free(app: "AppContext", added: "AddedSequences", name: str, source: str) -> None:
    """Raise PhotoError if the name a caller chose is that of a sequence made from something else."""
    existing = added.find(name)
    if name in app.library.served_names() or (existing is not None and existing.source != source):
        raise PhotoError(
            f"there is a sequence {name!r} already, made from something else: give another name, or none"
        )


def _name_for(
    app: "AppContext",
    added: "AddedSequences",
    source: str,
    title: str,
    built: "BuiltSequence",
    paper: "DeclaredSheet",
) -> tuple[str, SequenceOutcome]:
    """The first name that may be used, the title or the title with a number, and what using it does.

    One of another sequence may not, nor one of an earlier version that runs were opened on.
    """
    served = app.library.served_names()
    for name in _names(title):
        existing = added.find(name)
        if name in served or (existing is not None and existing.source != source):
            continue
        if existing is None:
            return name, "added"
        if _same(existing, built, paper):
            return name, "unchanged"
        if not _has_runs(app, name, existing):
            return name, "replaced"
    raise RunError("no name is left for the sequence; give another one")


def _names(title: str) -> Iterator[str]:
    """A title, and the title with 2, 3 and so on behind it."""
    yield title
    yield from (f"{title} {number}" for number in count(2))


def _same(existing: "AddedSequence", built: "BuiltSequence", paper: "DeclaredSheet") -> bool:
    known = existing.manifest
    return (known.keyframes, known.front_color, known.back_color) == (
        built.keyframes,
        paper.front_color,
        paper.back_color,
    )


def _has_runs(app: "AppContext", name: str, existing: "AddedSequence") -> bool:
    """Whether runs were opened on a sequence as it is, which could not be taken up again once it is another."""
    fingerprint = fingerprint_of(existing)
    return fingerprint is not None and app.store.has_runs(name, fingerprint)


def fingerprint_of(existing: "AddedSequence") -> str | None:
    """What runs that are opened on an added sequence keep of it; None if it cannot be read any more."""
    from folding_server.frames.sequences import load_sequence  # noqa: PLC0415

    try:
        return load_sequence(existing.folder).fingerprint()
    except PhotoError:
        return None
