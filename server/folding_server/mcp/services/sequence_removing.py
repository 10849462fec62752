"""Removing a sequence that was added, unless a run needs its photos."""

from typing import TYPE_CHECKING

from folding_server.errors import PhotoError, RunError
from folding_server.mcp.auth import caller
from folding_server.mcp.services.sequence_adding import fingerprint_of

if TYPE_CHECKING:
    from folding_server.mcp.context import AppContext


def remove_from_library(app: "AppContext", name: str) -> None:
    """Remove a sequence that the caller has added. The files that it was made from stay.

    PhotoError if the caller has added none of this name, or it cannot be removed; RunError if a run was opened on it.
    """
    from folding_server.frames.manifest import check_name  # noqa: PLC0415  (loads numpy and Pillow)

    added = app.added_sequences()
    with app.placing:
        if not added.holds(check_name(name)):
            raise PhotoError(
                f"the sequence {name!r:.80} cannot be removed: only one that add_sequence made for you can; list_sequences "
                "names those there are"
            )
        existing = added.find(name)
        fingerprint = fingerprint_of(existing) if existing else None
        run_id = fingerprint and app.store.own_run_on(caller(), name, fingerprint)
        if run_id:
            raise RunError(
                f"the sequence {name!r} is kept, since run {run_id} was opened on it and could not be taken up without its photos"
            )
        try:
            added.remove(name)
        except OSError as error:
            raise PhotoError(
                f"the sequence {name!r} could not be removed ({error.strerror or 'the disk cannot be written'}), and is as it "
                "was: call again"
            ) from error
