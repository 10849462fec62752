"""Every planned sequence of every model against its truth."""

import json
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from folding_schemas.evaluation import EvaluationReport, RunEvaluation, StepScores

from folding_client.evaluation.compared_state import ComparedState
from folding_client.evaluation.evaluation_constants import CONSTANTS, EvaluationConstants
from folding_client.evaluation.grouping import group_evaluation
from folding_client.evaluation.measuring_server import MeasuringServer, measuring_server
from folding_client.evaluation.recorded_states import RunToScore, runs_in
from folding_client.evaluation.score_summaries import rounded_score
from folding_client.evaluation.scoring_states import StateScorer, StateScores
from folding_client.evaluation.sequence_truth import SequenceTruth, truths_in
from folding_client.interrupts import ToolRefused, UsageError

Say = Callable[[str], None]
NOT_SAVED = "the frame is not saved"
REFUSED = "what was recorded for the frame is refused"


async def evaluation(
    sources: Sequence[Path],
    truth: Path,
    names: Sequence[str],
    say: Say,
    constants: EvaluationConstants = CONSTANTS,
) -> EvaluationReport:
    """Score the runs in folders against the truth in another; with ``names``, of these sequences alone.

    Every sequence of the truth is planned for every model and variant that has a run: what has none counts as failed.
    UsageError if there are no runs, no truth, or none of one for the other.
    """
    require_scipy()
    truths, runs = truths_in(truth, names), runs_in(sources)
    known = [run for run in runs if run.sequence in truths]
    if unknown := sorted({run.sequence for run in runs} - truths.keys()):
        say(f"Left out, since the truth does not have them: {', '.join(unknown)}.")
    if not known:
        message = f"None of the runs is of a sequence in {truth}; it holds {', '.join(truths)}."
        raise UsageError(message)
    async with measuring_server() as server:
        evaluated = await _Evaluating(server, constants, say).evaluated(known, truths)
    return EvaluationReport(
        format=1,
        version=version("foldingagent-mcp"),
        configuration=constants.described(),
        sequences=list(truths),
        groups=[group_evaluation(group, runs_of, constants) for group, runs_of in evaluated.items()],
        blindness=json.loads(files(__package__).joinpath("blindness.json").read_text("utf-8"))["told"],
    )


def require_scipy() -> None:
    """UsageError, with what to install, without scipy."""
    try:
        import scipy  # noqa: F401
    except ImportError as error:
        message = "Evaluation needs scipy; pip install 'foldingagent-mcp[evaluate]' brings it."
        raise UsageError(message) from error


class _Evaluating:
    """Goes through sequences, each true state measured once for all runs."""

    def __init__(self, server: MeasuringServer, constants: EvaluationConstants, say: Say) -> None:
        self._server = server
        self._constants = constants
        self._say = say

    async def evaluated(
        self, runs: Sequence[RunToScore], truths: Mapping[str, SequenceTruth]
    ) -> dict[tuple[str, str], list[RunEvaluation]]:
        """The evaluations by model and variant; what has no run of a sequence has failed it."""
        found: dict[tuple[str, str], list[RunEvaluation]] = {
            group: [] for group in sorted({(run.model, run.variant) for run in runs})
        }
        for name, truth in truths.items():
            scorers = await self._scorers(truth)
            for group, evaluations in found.items():
                own = [run for run in runs if run.sequence == name and (run.model, run.variant) == group]
                for run in own or (None,):
                    evaluations.append(await self._run(run, truth, scorers))
            self._say(f"{name}: {truth.frames} frames evaluated")
        return found

    async def _scorers(self, truth: SequenceTruth) -> dict[int, StateScorer]:
        """A scorer for each frame from 2 on whose state is known. UsageError if a true state cannot be made or read."""
        try:
            states = await self._true_states(truth)
        except ToolRefused as refusal:
            message = f"The truth of {truth.name} cannot be used: {refusal}"
            raise UsageError(message) from refusal
        for frame, state in states.items():
            if state.folded is None:
                message = f"The true state of frame {frame} of {truth.name} does not fold: {state.problem}"
                raise UsageError(message)
            if not state.compiles:
                self._say(f"{truth.name}: the true state of frame {frame} does not compile: {state.problem}")
        return {frame: StateScorer(state, self._constants) for frame, state in states.items()}

    async def _true_states(self, truth: SequenceTruth) -> dict[int, ComparedState]:
        if truth.state_files:
            return {
                frame: await self._server.of_fold_file(file.read_text(encoding="utf-8"))
                for frame, file in truth.state_files.items()
                if frame > 1
            }
        steps = [step or () for step in truth.steps]
        states = await self._server.of_steps(steps, truth.sheet)
        if len(states) < len(steps):
            message = f"step {len(states) + 1} of its program is refused."
            raise ToolRefused(message)
        return dict(enumerate(states, start=2))

    async def _run(
        self, run: RunToScore | None, truth: SequenceTruth, scorers: Mapping[int, StateScorer]
    ) -> RunEvaluation:
        states = [] if run is None else await self._run_states(run)
        steps = [
            _step(
                frame,
                truth,
                scorer,
                states[frame - 2] if frame - 2 < len(states) else None,
                saved=run is not None and frame <= run.frames_saved,
            )
            for frame, scorer in scorers.items()
        ]
        return _run_evaluation(run, truth, steps)

    async def _run_states(self, run: RunToScore) -> list[ComparedState | None]:
        """The state of each saved frame from 2 on; None where what was saved cannot be read."""
        if not run.patterns:
            return list(await self._server.of_steps(run.steps))
        states: list[ComparedState | None] = []
        for text in run.patterns[1:]:
            try:
                states.append(await self._server.of_fold_file(text))
            except ToolRefused:
                states.append(None)
        return states


def _step(
    frame: int, truth: SequenceTruth, scorer: StateScorer, state: ComparedState | None, *, saved: bool
) -> StepScores:
    found: StateScores = scorer.scored(state)
    return StepScores(
        frame=frame,
        action_class=truth.classes[frame],
        saved=saved,
        equal=found.equal,
        problem=state.problem if state is not None else REFUSED if saved else NOT_SAVED,
        scores={metric: rounded_score(value) for metric, value in found.scores.items()},
        parts={name: rounded_score(value) for name, value in found.parts.items()},
    )


def _run_evaluation(run: RunToScore | None, truth: SequenceTruth, steps: list[StepScores]) -> RunEvaluation:
    saved = 0 if run is None else run.frames_saved
    return RunEvaluation(
        sequence=truth.name,
        run=run and run.path,
        status=run.status if run else "not run",
        reason=run.reason if run else "",
        frames=truth.frames,
        frames_saved=saved,
        complete=saved >= truth.frames,
        queries=run.queries if run else 0,
        input_tokens=run.input_tokens if run else 0,
        output_tokens=run.output_tokens if run else 0,
        cost=run.cost if run else None,
        seconds=run.seconds if run else 0.0,
        steps=steps,
    )
