"""Adding a sequence from the files of a user, under a name that no other has and that no run depends on."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING

from folding_schemas.results import SequenceOutcome

from folding_server.errors import PhotoError, RunError
from folding_server.mcp.auth import caller
from folding_server.mcp.services.sequence_material import material_at, title_of

if TYPE_CHECKING:
    from folding_server.frames.added_sequences import AddedSequence, AddedSequences
    from folding_server.frames.image_files import EncodedImage
    from folding_server.frames.sequence_building import BuiltSequence
    from folding_server.frames.sequence_folder import DeclaredSheet
    from folding_server.mcp.context import AppContext

MOST_TILES = 72
"""How many images the contact sheet of an answer has, unless there are more keyframes: their numbers stay readable."""

SHEET_SIDE = 1568
"""Pixels of that sheet's longer side: what Claude's models scale larger pictures down to."""


@dataclass(frozen=True)
class SequenceWish:
    """What a caller asks for: paths as typed; None for what is left to the server."""

    paths: tuple[str, ...]
    name: str | None = None
    keyframes: tuple[int, ...] | None = None
    front_color: str | None = None
    back_color: str | None = None


@dataclass(frozen=True)
class AddedAnswer:
    """What came of it; ``asked`` is the name that the sequence would have if it were free."""

    name: str
    asked: str
    outcome: SequenceOutcome
    kept: "AddedSequence"
    built: "BuiltSequence"


def add_to_library(app: "AppContext", wish: SequenceWish, progress: Callable[[float], None]) -> AddedAnswer:
    """Make a sequence of a film or of photos, for the caller.

    PhotoError if the files may not or cannot be read, the name is another sequence's, or the disk is full; RunError if an
    owner may keep or compute nothing more.
    """
    from folding_server.frames.added_sequences import source_digest  # noqa: PLC0415  (loads numpy and Pillow)
    from folding_server.frames.manifest import check_name  # noqa: PLC0415
    from folding_server.frames.sequence_building import build_sequence  # noqa: PLC0415
    from folding_server.frames.sequence_folder import require_colors  # noqa: PLC0415

    if wish.name is not None:
        check_name(wish.name)
    material = material_at(wish.paths, app.allowed_folders())
    added = app.added_sequences()
    _check_room(app, added)
    try:
        source = source_digest(list(material.files))
        before = added.made_from(source)
        paper = _paper(wish, before)
        require_colors(paper)
        title = wish.name or (before.title if before else title_of(wish.paths))
        if wish.name is not None:
            _check_free(app, added, wish.name, source)
        with app.counting_vision(), added.making() as made:
            built = build_sequence(material, wish.keyframes, replace(paper, name=title), made, progress)
            with app.placing:
                name, outcome = _name_for(app, added, source, title, built, paper)
                existing = added.find(name)
                kept = (
                    existing if outcome == "unchanged" and existing else added.keep(made, name, source, title)
                )
    except OSError as error:
        raise PhotoError(
            f"the sequence could not be kept ({error.strerror or 'the disk cannot be written'}), and nothing was changed: "
            "make room on the server's disk and call again"
        ) from error
    return AddedAnswer(name, title, outcome, kept, built)


def contact_sheet_of(answer: AddedAnswer) -> "EncodedImage":
    """The keyframes of an added sequence, framed in red, among images between them, each under its number."""
    from folding_server.frames.contact_sheet import contact_sheet, fewer_images  # noqa: PLC0415
    from folding_server.frames.image_files import encode_for_model  # noqa: PLC0415

    keyframes, labels = answer.built.keyframes, answer.built.labels
    shown = fewer_images(keyframes, list(labels), MOST_TILES)
    sheet = contact_sheet(answer.kept.images, keyframes, shown, labels.__getitem__, SHEET_SIDE)
    return encode_for_model(sheet, SHEET_SIDE, caption=f"Contact sheet of {answer.name}")


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
    from folding_server.frames.sequences import load_sequence  # noqa: PLC0415

    try:
        fingerprint = load_sequence(existing.folder).fingerprint()
    except PhotoError:
        return False
    return app.store.has_runs(name, fingerprint)
