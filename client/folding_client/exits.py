"""How commands end: exit codes, interrupts, and one sentence in place of a traceback."""

import asyncio
import errno
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import typer
from folding_schemas.wrong_values import usage_sentence

from folding_client.interrupts import Interrupt, UsageError
from folding_client.record.folder import file_trouble
from folding_client.record.redaction import redact

_Answer = TypeVar("_Answer")
EXIT_DIFFERENT = 1
"""A replay answers otherwise than was recorded."""
EXIT_USAGE = 2
"""The command cannot be carried out as given."""
EXIT_STOPPED = 3
"""A run stopped and can be resumed."""
EXIT_DOUBTFUL = 4
"""Every frame is saved, but more than half of the steps do not fit their photos."""
EXIT_FAULT = 70
"""An error of the program itself (``EX_SOFTWARE`` of sysexits.h)."""
EXIT_INTERRUPTED = 130
"""Ctrl-C or SIGTERM, as shells have it for SIGINT."""


def finish(work: Coroutine[Any, Any, _Answer], afterwards: str) -> _Answer:
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


def end_cleanly(command: Callable[[], object]) -> NoReturn:
    """Carry a command out and end the process: with the exit code that it answers, or, whatever it raises, with one line on
    stderr and the exit code for that.
    """
    try:
        code = command()
    except typer.TyperException as error:
        _end(usage_sentence(error), error.exit_code)
    except Interrupt as error:
        _end(str(error), EXIT_USAGE if isinstance(error, UsageError) else EXIT_STOPPED)
    except BrokenPipeError:
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
        )  # nothing more can be said to whoever left
        sys.exit(EXIT_STOPPED)
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            _end(f"A name is too long for a file: {error.filename}. Give a shorter one.", EXIT_USAGE)
        _end(f"{file_trouble(error)}, then go on with --resume or the same command.", EXIT_STOPPED)
    except (KeyboardInterrupt, typer.Abort):
        _end("Interrupted.", EXIT_INTERRUPTED)
    except Exception as error:  # noqa: BLE001 - the boundary of the process
        _end(fault(error), EXIT_FAULT)
    sys.exit(code if isinstance(code, int) else 0)


def fault(error: Exception) -> str:
    """An error of the program itself in a sentence, which names the file where it is written out."""
    said = f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(".: ")
    written = redact("".join(traceback.format_exception(error)))
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", prefix="foldingagent-error-", suffix=".txt", delete=False
        ) as file:
            file.write(written)
    except OSError:
        return f"An error in foldingagent itself, {said}; a run that has begun can be resumed."
    return (
        f"An error in foldingagent itself, {said}; a run that has begun can be resumed. Please report it with "
        f"{Path(file.name)}."
    )


def _end(message: str, code: int) -> NoReturn:
    typer.echo(redact(message), err=True)
    sys.exit(code)
