"""The conformance suite of the protocol's own makers. What it asks of fixtures that a folding server has not is expected to fail."""

import re
from collections.abc import Iterator
from pathlib import Path

from mcp_peers import versions
from mcp_peers.checks import Check, Peer, Place
from mcp_peers.environments import node_environment, node_path
from mcp_peers.our_server import environment, finished, http_url

BASELINE = Path(__file__).with_name("conformance.yml")
"""The scenarios that are expected to fail, with reasons. One that passes fails the suite, so that the list stays true."""
SECONDS = 300
"""How long the 30 scenarios may take."""
SCENARIOS = 30
"""How many scenarios the suite has in this version."""


def _conformance(place: Place) -> Iterator[Check]:
    """Run the suite."""
    package = "@modelcontextprotocol/conformance"
    commands = node_environment(place.cache, "conformance", {package: versions.CONFORMANCE})
    env = environment(place.scratch, PATH=node_path(commands))
    with http_url(place.scratch / "data") as url:
        words: list[str | Path] = [
            commands / "conformance",
            "server",
            "--url",
            url,
            "--expected-failures",
            BASELINE,
        ]
        done = finished(words, env, place.scratch, SECONDS)
    said = done.stdout + done.stderr
    yield from _scenarios(said)
    yield Check("what fails is expected to fail, and nothing else", done.returncode == 0, said[-400:])


def _scenarios(said: str) -> Iterator[Check]:
    """The scenarios that passed, and whether all were run."""
    found = re.findall(r"^([✓✗]) ([\w-]+): (\d+) passed, (\d+) failed", said, re.MULTILINE)
    for mark, name, *_ in found:
        if mark == "✓":
            yield Check(name, passed=True)
    yield Check("every scenario was run", len(found) == SCENARIOS, f"{len(found)} of {SCENARIOS}")


PEERS = (Peer("conformance", versions.CONFORMANCE, "the protocol's conformance suite", _conformance),)
