"""Sequences of a data set written as folders with truth, their actions derived by the folding server."""

import asyncio
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcp.client.stdio import get_default_environment

from folding_client.data_sets.purelandfold import IMAGE_ENDINGS, Keyframe
from folding_client.interrupts import UsageError
from folding_client.record.folder import write_atomically

GIVEN = "given"
"""The folder of a sequence with the states as the data set has them."""
_SAID = "foldingagent-server: "
"""What the line begins with in which the server says why it cannot."""


@dataclass(frozen=True)
class ImportedSequence:
    """What became of a sequence: its keyframes, how many of its steps were derived, whether they make a program, and why it
    has no truth at all, empty if it has. ``not_derived`` says why for each frame whose step is not known.
    """

    name: str
    frames: int
    derived: int
    program: bool
    problem: str
    not_derived: dict[int, str]

    @property
    def line(self) -> str:
        """The sequence in words."""
        if self.problem:
            return f"{self.name}: no truth: {self.problem}"
        whole = ", a whole program" if self.program else ""
        missing = "".join(f"; frame {frame}: {why}" for frame, why in self.not_derived.items())
        return f"{self.name}: {self.frames} keyframes, {self.derived} of {self.frames - 1} steps derived{whole}{missing}"


async def import_sequences(
    sequences: Mapping[str, Sequence[Keyframe]], out: Path, face_orders: str, say: Callable[[str], None]
) -> list[ImportedSequence]:
    """Write each sequence into a folder of its own below ``out`` and derive its actions. UsageError for a folder that is there."""
    taken = [name for name in sequences if (out / name).exists()]
    if taken:
        message = f"{out / taken[0]} is there already; name another folder with --out."
        raise UsageError(message)
    found = []
    for name, frames in sequences.items():
        write_imported(name, frames, out / name)
        found.append(await _derived(name, frames, out / name, face_orders))
        say(found[-1].line)
    return found


def write_imported(name: str, frames: Sequence[Keyframe], folder: Path) -> None:
    """Write the photos and the states of a sequence: ``frames``, ``keyframes.json`` and ``given``."""
    for below in ("frames", GIVEN):
        (folder / below).mkdir(parents=True, exist_ok=True)
    for number, frame in enumerate(frames, start=1):
        if frame.photo is not None:
            write_atomically(folder / "frames" / f"{number:06}{_ending(frame.photo)}", frame.photo)
        for text, ending in ((frame.fold, ".fold"), (frame.drawing, ".svg")):
            if text is not None:
                write_atomically(folder / GIVEN / f"{number:06}{ending}", text.encode("utf-8"))
    if all(frame.photo is not None for frame in frames):
        manifest = {"name": name, "frames": "frames", "keyframes": list(range(1, len(frames) + 1))}
        write_atomically(folder / "keyframes.json", (json.dumps(manifest) + "\n").encode("utf-8"))


def _ending(photo: bytes) -> str:
    return next((ending for start, ending in IMAGE_ENDINGS.items() if photo.startswith(start)), ".jpg")


async def _derived(name: str, frames: Sequence[Keyframe], folder: Path, face_orders: str) -> ImportedSequence:
    if any(frame.fold is None for frame in frames):
        missing = next(number for number, frame in enumerate(frames, start=1) if frame.fold is None)
        return ImportedSequence(name, len(frames), 0, False, f"keyframe {missing} has no cp.fold", {})
    told, problem = await _derive(name, folder, face_orders)
    if told is None:
        return ImportedSequence(name, len(frames), 0, False, problem, {})
    reasons = {step["frame"]: step["reason"] for step in told["steps"] if step["actions"] is None}
    return ImportedSequence(name, len(frames), told["derived"], told["program"], "", reasons)


async def _derive(name: str, folder: Path, face_orders: str) -> tuple[dict[str, Any] | None, str]:
    """What the server derives of the states in a folder, or why it cannot."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "folding_server", "derive", str(folder / GIVEN), "--out", str(folder)),
        *("--face-orders", face_orders, "--name", name, "--json"),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env=get_default_environment(),
    )
    try:
        out, err = await process.communicate()
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    if process.returncode == 0:
        return json.loads(out), ""
    lines = err.decode(errors="replace").splitlines()
    said = next((line.removeprefix(_SAID) for line in reversed(lines) if line.startswith(_SAID)), "")
    return None, said or f"the server ended with {process.returncode}"
