"""Calls that are carried out in an event loop, where nothing may wait: for a lock, for another process, for a disk.

::

    try:
        with non_blocking():
            answer = function()     # whatever would wait asks ``may_block`` first, and raises WouldBlock
    except WouldBlock:
        answer = ...                # nothing has changed: call it again in a thread

A call that has changed something cannot be made again, so whatever follows its change may wait.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar


class WouldBlock(Exception):
    """A call that may not wait would have had to. Nothing has changed."""


class _Call:
    """One call in an event loop."""

    changed = False


_CALL: ContextVar[_Call | None] = ContextVar("non_blocking_call", default=None)


@contextmanager
def non_blocking() -> Iterator[None]:
    """Within it nothing may wait, until something has changed; raises WouldBlock instead."""
    token = _CALL.set(_Call())
    try:
        yield
    finally:
        _CALL.reset(token)


def may_block() -> bool:
    """Whether the caller may wait now."""
    call = _CALL.get()
    return call is None or call.changed


def has_changed() -> None:
    """Say that the call has changed something, and so may not be made again."""
    if (call := _CALL.get()) is not None:
        call.changed = True
