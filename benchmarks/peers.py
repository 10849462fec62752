"""Run other people's MCP programs against the server: ``scripts/peers [NAME...]`` prints a table on stderr, JSON on stdout.

Each peer has an environment of its own, made at first use from the package registries with the version that
``mcp_peers/versions.py`` pins, in ``--cache`` (default: ``$XDG_CACHE_HOME/foldingagent-peers``). Models are scripts on a
local port. It ends with 1 if anything that should pass does not, and with 2 if a peer is unknown.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from mcp_peers import clients, command_line_hosts, conformance, frameworks, inspector
from mcp_peers.checks import LONGEST_DETAIL, Check, Peer, PeerReport, Place
from mcp_peers.environments import PeerBroken, cache_folder
from rich.console import Console
from rich.table import Table

PEERS: Sequence[Peer] = (
    *conformance.PEERS,
    *inspector.PEERS,
    *clients.PEERS,
    *frameworks.PEERS,
    *command_line_hosts.PEERS,
)
TABLE_WIDTH = 120
"""Columns of the table, also where stderr is a file."""


def report_on(peer: Peer, cache: Path) -> PeerReport:
    """Run a peer. One that cannot be installed, fails or hangs has a check that did not pass."""
    began = time.monotonic()
    checks: list[Check] = []
    with tempfile.TemporaryDirectory(prefix=f"{peer.name}-", ignore_cleanup_errors=True) as scratch:
        try:
            for check in peer.run(Place(cache, Path(scratch))):
                checks.append(check)  # noqa: PERF402 - those before a failure are kept
        except (
            PeerBroken,
            AssertionError,
            OSError,
            LookupError,
            ValueError,
            subprocess.SubprocessError,
        ) as error:
            checks.append(Check("runs to its end", passed=False, detail=f"{type(error).__name__}: {error}"))
    return PeerReport(peer, checks, time.monotonic() - began)


def chosen(names: Sequence[str]) -> list[Peer]:
    """The peers with these names, all without any. ValueError for a name that none has."""
    known = {peer.name: peer for peer in PEERS}
    for name in names:
        if name not in known:
            raise ValueError(f"there is no peer {name!r}; the peers are {', '.join(known)}")
    return [known[name] for name in names or known]


def told(reports: Sequence[PeerReport], console: Console) -> None:
    """The reports as a table, and below it each check that did not pass."""
    drawn = Table("peer", "version", "", "checks", "time", "what")
    for report in reports:
        passed = f"{len(report.checks) - len(report.failed)} of {len(report.checks)}"
        verdict = "FAILED" if report.failed else "ok"
        drawn.add_row(
            report.peer.name,
            report.peer.version,
            verdict,
            passed,
            f"{report.seconds:.0f} s",
            report.peer.what,
        )
    console.print(drawn)
    for report in reports:
        for check in report.failed:
            words = " ".join(check.detail.split())[:LONGEST_DETAIL]
            console.print(f"{report.peer.name}: {check.name}: {words}", markup=False, highlight=False)


def main() -> None:
    """Run the chosen peers and tell what they found."""
    parser = argparse.ArgumentParser(prog="scripts/peers", description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="a peer to run; all if none is named")
    parser.add_argument("--list", action="store_true", help="list the peers with their versions and run none")
    parser.add_argument("--cache", type=Path, default=cache_folder(), help="where environments are kept")
    given = parser.parse_args()
    try:
        peers = chosen(given.names)
    except ValueError as error:
        parser.error(str(error))
    if given.list:
        print("\n".join(f"{peer.name:24}{peer.version:10}{peer.what}" for peer in peers))
        return
    given.cache.mkdir(parents=True, exist_ok=True)
    reports = []
    for peer in peers:
        print(f"peers: {peer.name} {peer.version}", file=sys.stderr)
        reports.append(report_on(peer, given.cache.resolve()))
    told(reports, Console(stderr=True, width=TABLE_WIDTH))
    failed = sum(len(report.failed) for report in reports)
    print(json.dumps({"peers": [report.told() for report in reports], "failed": failed}, indent=1))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
