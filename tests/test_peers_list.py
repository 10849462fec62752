"""``scripts/peers`` tells which programs of others it can run, and refuses names that it does not know.

Running them takes minutes and the package registries; that is not part of the tests.
"""

import subprocess
import sys

import peers
import pytest
from mcp_peers import versions
from paths import ROOT


def command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "benchmarks/peers.py", *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_every_peer_is_listed_with_its_version() -> None:
    listed = command("--list")
    assert listed.returncode == 0, listed.stderr
    told = [tuple(line.split()[:2]) for line in listed.stdout.splitlines()]
    assert told == [(peer.name, peer.version) for peer in peers.PEERS]
    pinned = {value for name, value in vars(versions).items() if name.isupper()}
    assert {version for _, version in told} == pinned - {versions.NODE}


def test_some_peers_can_be_chosen_and_no_others() -> None:
    assert [peer.name for peer in peers.chosen(["codex", "inspector"])] == ["codex", "inspector"]
    with pytest.raises(ValueError, match="there is no peer 'codecs'; the peers are conformance, inspector"):
        peers.chosen(["codecs"])
