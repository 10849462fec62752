"""GS, geometric similarity, on the folded state."""

from collections import Counter
from math import exp

import numpy as np

from folding_client.evaluation.compared_state import ComparedState, Reals
from folding_client.evaluation.counting_similarity import histogram_similarity
from folding_client.evaluation.evaluation_constants import EvaluationConstants
from folding_client.evaluation.hausdorff import hausdorff

DIHEDRAL_ANGLES = {"M": -180, "F": 0, "V": 180}
"""Degrees by letter, in FOLD's signs."""


def geometric_parts(
    state: ComparedState, truth: ComparedState, constants: EvaluationConstants
) -> dict[str, float]:
    """The terms: positions of the vertices, dihedral angles, proportions."""
    assert state.folded is not None and truth.folded is not None, "both states lie somewhere"  # noqa: PT018
    aspects = _aspect(state.folded), _aspect(truth.folded)
    return {
        "GS.PPS": exp(-constants.distance_decay * hausdorff(_framed(state.folded), _framed(truth.folded))),
        "GS.AS": histogram_similarity(_angles(state), _angles(truth)),
        "GS.SPS": min(aspects) / max(aspects),
    }


def geometric_similarity(parts: dict[str, float], constants: EvaluationConstants) -> float:
    """Their weighted sum."""
    weights = constants.geometry
    return (
        weights.positions * parts["GS.PPS"]
        + weights.angles * parts["GS.AS"]
        + weights.proportions * parts["GS.SPS"]
    )


def _framed(points: Reals) -> Reals:
    """Points about the middle of their bounding box, in units of its diagonal."""
    low, high = points.min(axis=0), points.max(axis=0)
    return np.asarray((points - (low + high) / 2) / np.hypot(*(high - low)))


def _aspect(points: Reals) -> float:
    width, height = np.ptp(points, axis=0)
    return float(width / height)


def _angles(state: ComparedState) -> Counter[object]:
    """The length of the creases by their dihedral angle."""
    found: Counter[object] = Counter()
    for crease in state.creases:
        found[DIHEDRAL_ANGLES.get(state.letters[crease], state.letters[crease])] += state.lengths[crease]
    return found
