"""A video as a sequence: the folding server proposes its keyframes, in a process of its own."""

import asyncio
import sys
from collections.abc import Callable
from pathlib import Path

from mcp.client.stdio import get_default_environment

from folding_client.interrupts import UsageError
from folding_client.record.folder import RunFolder
from folding_client.settings import Settings

_REFUSAL = "foldingagent-server: "
"""What the line begins with in which the server says why it cannot."""


async def sequence_of_video(video: Path, folder: Path, say: Callable[[str], None]) -> Path:
    """The new sequence folder with the keyframes of a video; ``say`` is given how far the search is.

    UsageError, in the server's words, if the video or the folder cannot be used; no folder is left then.
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "folding_server", "keyframes", str(video.expanduser().resolve()), "--out", str(folder)),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
        env=get_default_environment(),
    )
    try:
        refusal = await _refusal_of(process, say)
        code = await process.wait()
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    if code != 0:
        raise UsageError(
            refusal or f"The keyframes of {video.name} cannot be found: the server ended with {code}."
        )
    return folder


async def _refusal_of(process: asyncio.subprocess.Process, say: Callable[[str], None]) -> str:
    """What the process complains of in the end; everything else that it writes is said on."""
    refusal = ""
    if process.stderr is not None:
        async for line in process.stderr:
            text = line.decode(errors="replace").rstrip()
            if text.startswith(_REFUSAL):
                refusal = text.removeprefix(_REFUSAL)
            else:
                say(text)
    return refusal


async def video_in_run_folder(video: Path, out: Path, settings: Settings, say: Callable[[str], None]) -> Path:
    """The sequence folder of a video, written into the run folder to be; nothing is left of it if that fails or is
    cut short. UsageError as ``sequence_of_video``, and for a server that runs elsewhere.
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
        return await sequence_of_video(video, out / "sequence", say)
    except (UsageError, asyncio.CancelledError):
        folder.discard()
        raise
    finally:
        folder.release()
