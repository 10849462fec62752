"""Paths as users type them."""

from pathlib import Path

import typer


def typed_path(text: str) -> Path:
    """A path as given, where ``~`` is the user's own folder although no shell has seen it."""
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        raise typer.BadParameter(f"{text!r} begins with a user who has no folder here") from error
