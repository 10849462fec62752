"""The scores of runs, read from what ``foldingagent evaluate --json`` printed."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from folding_schemas.run_record import RecordPart

from folding_client.json_files import read_json_file

EVALUATION_FILE = "evaluation.json"
"""Where an evaluation is looked for in a folder of runs."""
SHOWN_METRICS = ("CV", "TSS", "GS", "CS", "FFS", "CPD", "SIM")
"""The order in which metrics are shown; others follow."""


class _ScoredStep(RecordPart):
    frame: int
    scores: dict[str, float]
    equal: bool = False


class _ScoredRun(RecordPart):
    sequence: str
    run: str | None
    steps: list[_ScoredStep] = []


class _ScoredGroup(RecordPart):
    runs: list[_ScoredRun]


class _Evaluation(RecordPart):
    groups: list[_ScoredGroup]


@dataclass(frozen=True)
class RunScores:
    """The scores of a run by frame, and of its sequence's last frame; ``exact`` are the frames that are the truth."""

    by_frame: dict[int, dict[str, float]] = field(default_factory=dict)
    exact: frozenset[int] = frozenset()

    @property
    def last(self) -> dict[str, float]:
        """The scores of the last frame of the truth."""
        return self.by_frame[max(self.by_frame)] if self.by_frame else {}

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metrics that were measured."""
        measured = {name for scores in self.by_frame.values() for name in scores}
        return (*(name for name in SHOWN_METRICS if name in measured), *sorted(measured - {*SHOWN_METRICS}))


class Evaluations:
    """What evaluations say of runs."""

    def __init__(self, files: Iterable[Path]) -> None:
        self._runs: list[_ScoredRun] = [
            run for file in files for group in _evaluation(file).groups for run in group.runs
        ]

    def of(self, folder: Path, sequence: str) -> RunScores:
        """The scores of the run in a folder; none if no evaluation tells of it."""
        for run in self._runs:
            parts = Path(run.run).parts if run.run else ()
            if run.run is not None and run.sequence == sequence and folder.parts[-len(parts) :] == parts:
                return RunScores(
                    {step.frame: step.scores for step in run.steps},
                    frozenset(step.frame for step in run.steps if step.equal),
                )
        return RunScores()


def evaluation_files(roots: Iterable[Path], named: Path | None) -> list[Path]:
    """The evaluation that is named, or those that lie in the folders of runs."""
    if named is not None:
        return [named]
    return [root / EVALUATION_FILE for root in roots if (root / EVALUATION_FILE).is_file()]


def _evaluation(file: Path) -> _Evaluation:
    return read_json_file(_Evaluation, file, "an evaluation", "what foldingagent evaluate --json printed")
