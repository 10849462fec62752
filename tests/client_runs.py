"""Running the client in tests: sequences of small pictures, one folding server for all, runs from start to
end.
"""

import asyncio
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from folding_client.models.retries import RetryPolicy
from folding_client.progress import Silent
from folding_client.reconstruct import Outcome, new_job, reconstruct, resumed_job
from folding_client.record.event_log import read_events
from folding_client.settings import Settings
from lasting import LASTING
from paths import DATA
from PIL import Image, ImageDraw
from providers.base import Says

PLANTED_KEY = "planted-key-0123456789"
HASTY = RetryPolicy(tries=3, first_wait=0.01, longest_wait=5)
MATCH = Says(
    json.dumps(
        {
            "verdict": "MATCH",
            "analysis": "Both show the same.",
            "anchor_check": "no anchor provided",
            "discrepancies": [],
        }
    )
)
MISMATCH = Says(
    json.dumps(
        {
            "verdict": "MISMATCH",
            "analysis": "The flap is too long.",
            "anchor_check": "broken",
            "discrepancies": ["flap 0.1 too long"],
        }
    )
)
ANCHOR = {
    "moving_element": "the flap",
    "static_reference": "the right edge",
    "relationship": "its tip touches the edge",
}


def figure(name: str) -> list[list[dict[str, Any]]]:
    """The steps of a program printed in the paper."""
    (file,) = (DATA / "programs").glob(f"figure_{name}_*.json")
    steps: list[list[dict[str, Any]]] = json.loads(file.read_text())["steps"]
    return steps


@cache
def _home() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="folding-tests-"))
    LASTING.callback(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def sequence(frames: int) -> Path:
    """A sequence of small plain pictures: enough for whatever does not look at them closely."""
    folder = _home() / "sequences" / f"plain{frames}"
    (folder / "frames").mkdir(parents=True)
    for index in range(frames):
        picture = Image.new("RGB", (64, 48), (20, 20, 20))
        ImageDraw.Draw(picture).rectangle((16, 8, 40 + index, 40), fill=(200, 30, 30))
        picture.save(folder / "frames" / f"{index:06d}.jpg")
    manifest = {
        "name": folder.name,
        "frames": "frames",
        "front_color": "red",
        "back_color": "white",
        "keyframes": list(range(frames)),
    }
    (folder / "keyframes.json").write_text(json.dumps(manifest))
    return folder


def shortened(source: Path, folder: Path, frames: int) -> Path:
    """The first frames of a sequence as a sequence of its own."""
    manifest = json.loads((source / "keyframes.json").read_text())
    folder.mkdir()
    shutil.copytree(source / "frames", folder / "frames")
    (folder / "keyframes.json").write_text(
        json.dumps(manifest | {"name": folder.name, "keyframes": manifest["keyframes"][:frames]})
    )
    return folder


@cache
def server_url() -> str:
    """The address of a folding server over HTTP that serves every sequence of these tests."""
    for frames in (2, 3, 4, 7, 9):
        sequence(frames)
    served_here = served(sequences=_home() / "sequences", data=_home() / "store")
    return LASTING.enter_context(served_here)


@contextmanager
def served(*options: str, sequences: Path, data: Path) -> Iterator[str]:
    """The address of a folding server over HTTP, for as long as the context lasts."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    folders = ["--sequences", str(sequences), "--data", str(data)]
    words = [sys.executable, "-m", "folding_server", "--http", f"127.0.0.1:{port}", *folders, *options]
    with tempfile.TemporaryFile("w+") as log:
        server = subprocess.Popen(words, stderr=log)
        try:
            _wait_for(port, server)
            yield f"http://127.0.0.1:{port}/mcp"
        finally:
            server.terminate()
            server.wait()


def _wait_for(port: int, server: subprocess.Popen[bytes]) -> None:
    while server.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.02)
    raise RuntimeError(f"the folding server ended with {server.returncode}")


def settings(**given: Any) -> Settings:
    """Settings for a run on the shared server, impatient with its provider."""
    return Settings(**{"server_url": server_url(), "retries": HASTY, **given})


def run(frames: int, out: Path, **given: Any) -> Outcome:
    """Reconstruct a plain sequence into a run folder."""
    os.environ["OPENAI_API_KEY"] = PLANTED_KEY
    return asyncio.run(reconstruct(new_job(sequence(frames), out, settings(**given)), Silent()))


def resume(out: Path, **given: Any) -> Outcome:
    """Go on with a run."""
    return asyncio.run(reconstruct(resumed_job(out, None, settings(**given)), Silent()))


def events(out: Path, *kinds: str) -> list[dict[str, Any]]:
    """The events of a run, or those of some kinds."""
    return [event for event in read_events(out / "events.jsonl") if not kinds or event["kind"] in kinds]


def program(out: Path) -> list[list[dict[str, Any]]]:
    """The steps of the program that a run recovered."""
    steps: list[list[dict[str, Any]]] = json.loads((out / "program.json").read_text())["steps"]
    return steps


def calls(*actions: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Actions of a program as tool calls."""
    return [
        (action["action"], {key: value for key, value in action.items() if key != "action"})
        for action in actions
    ]


def act(*actions: dict[str, Any]) -> Says:
    """A reply that carries out actions."""
    return Says(calls=calls(*actions))


def ask(frame: int, kind: str = "fold") -> Says:
    """A reply that asks the critic."""
    anchor = {"fold_anchor": ANCHOR} if kind == "fold" else {}
    return Says(calls=[("ask_critic", {"frame": frame, "action_classes": [kind], **anchor})])


def save(frame: int) -> Says:
    """A reply that saves a frame."""
    return Says(calls=[("save_checkpoint", {"frame": frame})])


def restore(frame: int) -> Says:
    """A reply that restores a checkpoint."""
    return Says(calls=[("restore_checkpoint", {"frame": frame})])


def solved(steps: Sequence[Sequence[dict[str, Any]]], first: int = 2) -> Iterable[Says]:
    """Replies that carry out the steps to frames ``first``, ``first + 1``, ..., each approved by the
    critic.
    """
    for frame, step in enumerate(steps, start=first):
        kind = step[-1]["action"]
        yield from (act(*step), ask(frame, kind), MATCH, save(frame))
