"""Our server, as peers start it: over stdio by its command, or over HTTP as a process of its own."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
SEQUENCE = "cat"
"""The sequence that peers look at."""
END_SECONDS = 10
"""How long the server may take to end: it promises 4."""
NOWHERE = "http://127.0.0.1:9"
"""A proxy at which nothing listens: whatever a peer sends beyond this machine fails."""
QUIET: Mapping[str, str] = {
    **dict.fromkeys(
        ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "http_proxy", "https_proxy", "all_proxy"), NOWHERE
    ),
    **dict.fromkeys(("NO_PROXY", "no_proxy"), "127.0.0.1,localhost,::1"),
    "NODE_USE_ENV_PROXY": "1",
    "DO_NOT_TRACK": "1",
    "OTEL_SDK_DISABLED": "true",
    "NO_UPDATE_NOTIFIER": "1",
}
"""Environment variables that keep a peer on this machine."""


def environment(home: Path, **others: str) -> dict[str, str]:
    """The environment of a peer: the search path, a home of its own, no way beyond this machine."""
    return {"PATH": os.environ["PATH"], "HOME": str(home), **QUIET, **others}


def stdio_command(data: Path) -> list[str]:
    """The words that start the server over stdio, with runs in ``data`` and the examples as sequences."""
    return [sys.executable, "-m", "folding_server", "--data", str(data), "--sequences", str(EXAMPLES)]


@contextmanager
def http_url(data: Path) -> Iterator[str]:
    """The address of a server process that listens on a free local port."""
    command = [*stdio_command(data), "--http", "127.0.0.1:0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"http://\S+", line)
            assert found, line
            yield found.group()
        finally:
            process.terminate()
            process.communicate(timeout=END_SECONDS)


def enter(host: str, file: Path, data: Path) -> None:
    """Enter the server into a host's configuration, by its own command ``install``."""
    words = [
        "install",
        "--host",
        host,
        "--file",
        str(file),
        "--data",
        str(data),
        "--sequences",
        str(EXAMPLES),
    ]
    subprocess.run([sys.executable, "-m", "folding_server", *words], check=True, capture_output=True)


def finished(
    command: Sequence[str | Path], env: Mapping[str, str], cwd: Path, seconds: float
) -> subprocess.CompletedProcess[str]:
    """A peer's process that has ended. TimeoutExpired after ``seconds``."""
    return subprocess.run(
        [str(word) for word in command],
        capture_output=True,
        text=True,
        env=dict(env),
        cwd=cwd,
        timeout=seconds,
        check=False,
        stdin=subprocess.DEVNULL,
    )
