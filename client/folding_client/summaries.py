"""What is printed of a run when it has ended: for people and as JSON."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from folding_schemas.actions import Program, action_text

from folding_client.progress import spent
from folding_client.reconstruct import Outcome
from folding_client.record.fits import FitSummary, fit_summary
from folding_client.record.totals import Totals


def fits_of(outcome: Outcome) -> FitSummary:
    """How the steps of a run fit its photos."""
    return fit_summary(outcome.run.get("fits", {}))


def outcome_document(outcome: Outcome, folder: Path) -> dict[str, Any]:
    """What ``run --json`` prints."""
    fits = fits_of(outcome)
    return {
        "run": str(folder),
        "status": outcome.status,
        "reason": outcome.reason,
        "program": _program(folder),
        "outcome": outcome.run["outcome"],
        "totals": outcome.run["totals"],
        "fits": outcome.run["fits"],
        "steps": fits.steps,
        "matching": fits.matching,
        "doubtful": list(fits.doubtful),
    }


def outcome_lines(outcome: Outcome, folder: Path) -> Iterator[str]:
    """The program, with a remark at each step that does not fit; then how many frames are saved, how many steps match, and what
    it took.
    """
    program, fits = _program(folder), fits_of(outcome)
    if program is not None:
        yield f"Program of {program['name']}:"
        for frame, step in enumerate(Program.model_validate(program).steps, start=2):
            fit = fits.doubtful.get(frame)
            doubt = "" if fit is None else "  (doubtful)" if fit.matches else "  (not a match)"
            yield f"  {frame - 1} -> {frame}  {'; '.join(map(action_text, step)) or 'nothing'}{doubt}"
    if fits.mostly_doubtful:
        yield "Most steps of this program do not fit their photos."
    if fits.text:
        yield f"{fits.text}."
    if used := spent(_totals(outcome.run["totals"])):
        yield f"{used}."
    summary = outcome.run["outcome"]
    saved = f"{summary['frames_saved']} of {summary['frames']} frames saved"
    yield f"{saved} in {summary['seconds']:.1f} s: {folder}"


def _totals(described: Mapping[str, Mapping[str, Any]]) -> dict[str, Totals]:
    return {role: Totals(**each) for role, each in described.items()}


def _program(folder: Path) -> dict[str, Any] | None:
    file = folder / "program.json"
    if not file.exists():
        return None
    program: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return program
