"""The evaluations of one model and variant together."""

from collections import Counter
from collections.abc import Sequence
from math import ceil
from typing import get_args

import numpy as np
from folding_schemas.evaluation import (
    ClassScores,
    EndingCount,
    GroupEvaluation,
    ProgressPoint,
    RunEvaluation,
    Scores,
    Spending,
    StepClass,
)

from folding_client.evaluation.evaluation_constants import EvaluationConstants
from folding_client.evaluation.score_summaries import rounded_score, score_means, score_summaries, summary


def group_evaluation(
    group: tuple[str, str], runs: Sequence[RunEvaluation], constants: EvaluationConstants
) -> GroupEvaluation:
    """All figures of a row. Denominators are the planned sequences, those that failed included."""
    model, variant = group
    stepped = [run for run in runs if run.steps]
    return GroupEvaluation(
        label=model if variant == "agent" else f"{model} {variant}",
        model=model,
        variant=variant,
        planned=len(runs),
        completed=sum(run.complete for run in runs),
        last=score_summaries((run.steps[-1].scores for run in stepped), constants),
        last_completed=score_summaries((run.steps[-1].scores for run in stepped if run.complete), constants),
        steps=score_summaries((score_means(step.scores for step in run.steps) for run in stepped), constants),
        progress=progress_curve(stepped, constants.progress_points),
        by_class=_by_class(stepped, constants),
        spending=_spending([run for run in runs if run.run is not None], constants),
        endings=_endings(runs),
        runs=list(runs),
    )


def progress_curve(runs: Sequence[RunEvaluation], points: int) -> list[ProgressPoint]:
    """The mean over all sequences at even shares of their steps: at each share, a sequence counts with the step that it has
    come to by then, so that every sequence counts at every point.
    """
    return [
        ProgressPoint(
            progress=rounded_score(share),
            means=score_means(run.steps[ceil(share * len(run.steps) - 1e-9) - 1].scores for run in runs),
        )
        for share in np.arange(1, points + 1) / points
    ]


def _by_class(runs: Sequence[RunEvaluation], constants: EvaluationConstants) -> list[ClassScores]:
    scores: dict[StepClass, list[Scores]] = {name: [] for name in get_args(StepClass)}
    for step in (step for run in runs for step in run.steps):
        scores[step.action_class].append(step.scores)
    return [
        ClassScores(action_class=name, steps=len(each), scores=score_summaries(each, constants))
        for name, each in scores.items()
        if each
    ]


def _spending(runs: Sequence[RunEvaluation], constants: EvaluationConstants) -> Spending:
    return Spending(
        queries=summary([run.queries for run in runs], constants),
        input_tokens=summary([run.input_tokens for run in runs], constants),
        output_tokens=summary([run.output_tokens for run in runs], constants),
        cost=summary([run.cost for run in runs if run.cost is not None], constants),
        seconds=summary([run.seconds for run in runs], constants),
    )


def _endings(runs: Sequence[RunEvaluation]) -> list[EndingCount]:
    """How the runs ended, the most frequent first."""
    counts = Counter((run.status, run.reason) for run in runs)
    return [
        EndingCount(status=status, reason=reason, sequences=count)
        for (status, reason), count in sorted(counts.items(), key=lambda each: (-each[1], each[0]))
    ]
