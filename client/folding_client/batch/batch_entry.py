"""How one run of a batch fared, for people, for the index and as JSON."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_client.record.fits import fit_summary
from folding_client.record.redaction import redact

DONE = frozenset({"complete", "skipped"})
"""The statuses of runs that nothing is left to do for."""


@dataclass(frozen=True)
class BatchEntry:
    """How one sequence fared: ``status`` is complete, skipped (was complete before), stopped, failed, or waiting (not begun)."""

    sequence: str
    status: str
    reason: str
    frames_saved: int
    frames: int
    seconds: float
    run: str
    steps: int = 0
    matching: int = 0
    doubtful: tuple[int, ...] = ()
    tokens: int = 0
    cost: float | None = None
    model: str = ""
    variant: str = ""
    seed: int = 0

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to do."""
        return self.status in DONE

    @property
    def mostly_doubtful(self) -> bool:
        """Whether more than half of the steps do not fit their photos."""
        return 2 * len(self.doubtful) > self.steps

    @property
    def text(self) -> str:
        """The line for people."""
        fits = f", {self.matching} of {self.steps} steps match" if self.steps else ""
        spent = f", {self.tokens:,} tokens" if self.tokens else ""
        price = "" if self.cost is None else f", ${self.cost:.4f}"
        reason = f": {self.reason}" if self.reason else ""
        return (
            f"{self.sequence}: {self.status}, {self.frames_saved} of {self.frames} frames{fits}, "
            f"{self.seconds:.1f} s{spent}{price}{reason}"
        )


def described_entry(name: str, status: str, reason: str, run: Mapping[str, Any], folder: Path) -> BatchEntry:
    """The entry of a run by what ``run.json`` says of it."""
    summary, totals = run["outcome"], run.get("totals", {})
    fits = fit_summary(run.get("fits", {}))
    costs = [each["cost"] for each in totals.values() if each["cost"] is not None]
    settings = run.get("settings", {})
    chosen = settings.get("defaulted", {}) | settings.get("given", {})
    return BatchEntry(
        name,
        status,
        redact(reason),
        summary["frames_saved"],
        summary["frames"],
        summary["seconds"],
        str(folder),
        fits.steps,
        fits.matching,
        tuple(fits.doubtful),
        sum(each["input_tokens"] + each["output_tokens"] for each in totals.values()),
        sum(costs) if costs else None,
        run.get("models", {}).get("agent", ""),
        chosen.get("variant", ""),
        chosen.get("seed", 0),
    )
