"""Means of scores with their spread."""

from collections.abc import Iterable, Sequence
from statistics import fmean

import numpy as np
from folding_schemas.evaluation import METRICS, MetricName, Scores, Summary

from folding_client.evaluation.evaluation_constants import EvaluationConstants

DIGITS = 6
"""Decimals of the figures in the results: the same on every machine."""


def rounded_score(value: float) -> float:
    """A figure as the results hold it."""
    return round(float(value), DIGITS) + 0.0


def summary(values: Sequence[float], constants: EvaluationConstants) -> Summary:
    """Mean, standard deviation, and the percentile bootstrap interval of the mean (Efron 1979), resampled by a fixed seed."""
    if not values:
        return Summary(count=0, mean=None, deviation=None, low=None, high=None)
    found = np.array(values, float)
    chance = np.random.default_rng(constants.bootstrap_seed)
    drawn = chance.integers(len(found), size=(constants.resamples, len(found)))
    tail = (1 - constants.confidence) / 2
    low, high = np.quantile(found[drawn].mean(axis=1), [tail, 1 - tail])
    return Summary(
        count=len(found),
        mean=rounded_score(found.mean()),
        deviation=rounded_score(found.std(ddof=1)) if len(found) > 1 else 0.0,
        low=rounded_score(low),
        high=rounded_score(high),
    )


def score_summaries(scores: Iterable[Scores], constants: EvaluationConstants) -> dict[MetricName, Summary]:
    """The summary of each metric over many scores."""
    listed = list(scores)
    return {metric: summary([each[metric] for each in listed], constants) for metric in METRICS}


def score_means(scores: Iterable[Scores]) -> Scores:
    """The mean of each metric; nothing of none."""
    listed = list(scores)
    if not listed:
        return {}
    return {metric: rounded_score(fmean(each[metric] for each in listed)) for metric in METRICS}
