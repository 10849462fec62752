"""What a peer finds: checks with a name, whether each passed, and what was seen if not."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LONGEST_DETAIL = 400
"""Characters of what was seen that are told: enough to recognise an error by."""


@dataclass(frozen=True)
class Check:
    """One thing that a peer should find. ``detail`` says what it found."""

    name: str
    passed: bool
    detail: str = ""

    def told(self) -> dict[str, Any]:
        """The check as JSON; the detail only where it failed."""
        told: dict[str, Any] = {"name": self.name, "passed": self.passed}
        return told if self.passed else {**told, "detail": self.detail[:LONGEST_DETAIL]}


@dataclass(frozen=True)
class Place:
    """Where a peer works: the folder with the environments, and an empty one that is removed afterwards."""

    cache: Path
    scratch: Path


@dataclass(frozen=True)
class Peer:
    """A peer: the name it is asked for by, its version, what it does here, and the doing."""

    name: str
    version: str
    what: str
    run: Callable[[Place], Iterable[Check]]


@dataclass(frozen=True)
class PeerReport:
    """What a peer found, and how long it took."""

    peer: Peer
    checks: Sequence[Check]
    seconds: float

    @property
    def failed(self) -> list[Check]:
        """The checks that did not pass."""
        return [check for check in self.checks if not check.passed]

    def told(self) -> Mapping[str, Any]:
        """The report as JSON."""
        return {
            "peer": self.peer.name,
            "version": self.peer.version,
            "seconds": round(self.seconds, 1),
            "checks": [check.told() for check in self.checks],
        }


def prefixed(prefix: str, checks: Iterable[Check]) -> Iterator[Check]:
    """Checks under names that say in which of several ways they were made."""
    for check in checks:
        yield Check(f"{prefix}: {check.name}", check.passed, check.detail)
