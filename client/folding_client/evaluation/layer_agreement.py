"""LCR, the order of the layers: pairs of sheet points that coincide in the true folded state, and which lies over which."""

from dataclasses import dataclass

import numpy as np

from folding_client.evaluation.compared_state import Bools, ComparedState, Floats, Indices, inside
from folding_client.evaluation.evaluation_constants import EvaluationConstants

MOST_BATCHES = 20
"""Batches of ``layer_pairs`` points that are drawn before fewer pairs have to do: of a sheet with few layers, most points lie
alone.
"""


@dataclass(frozen=True)
class LayerPairs:
    """(n, 2) sheet points, and (n, 2) those that lie below them in the folded state."""

    upper: Floats
    lower: Floats


def layer_pairs(truth: ComparedState, constants: EvaluationConstants) -> LayerPairs:
    """Pairs of points of the true sheet that coincide when it is folded; none if nothing lies over anything."""
    chance = np.random.default_rng(constants.layer_seed)
    upper, lower = [np.empty((0, 2))], [np.empty((0, 2))]
    for _ in range(MOST_BATCHES if truth.over.any() else 0):
        above, below = _drawn(truth, chance, constants.layer_pairs)
        upper.append(above)
        lower.append(below)
        if sum(map(len, upper)) >= constants.layer_pairs:
            break
    count = constants.layer_pairs
    return LayerPairs(np.concatenate(upper)[:count], np.concatenate(lower)[:count])


def layer_agreement(state: ComparedState, pairs: LayerPairs) -> float:
    """The share of the pairs whose order is the same in a state; 1 without pairs.

    Points that fall on one face of the state, or on faces that do not overlap, are not in that order.
    """
    if len(pairs.upper) == 0:
        return 1.0
    outlines = [state.sheet[list(face)] for face in state.faces]
    upper, lower = _face_at(pairs.upper, outlines), _face_at(pairs.lower, outlines)
    known = (upper >= 0) & (lower >= 0)
    return float((known & state.over[upper, lower]).mean())


def _face_at(points: Floats, outlines: list[Floats]) -> Indices:
    """(n,): the face that holds each sheet point, -1 if none does."""
    held = inside(points, outlines)
    return np.where(held.any(axis=1), held.argmax(axis=1), -1)


def _drawn(truth: ComparedState, chance: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Sheet points drawn evenly, those of them that share their place, each with another there; (upper, lower)."""
    points = chance.random((count, 2)) * truth.sheet.max(axis=0)
    own = _face_at(points, [truth.sheet[list(face)] for face in truth.faces])
    points, own = points[own >= 0], own[own >= 0]
    factors, offsets = truth.motions
    z = points @ [1, 1j]
    place = factors[own] * np.where(truth.mirrored[own], z.conj(), z) + offsets[own]
    other = _another(truth, place, own, chance)
    points, own, place, other = (each[other >= 0] for each in (points, own, place, other))
    back = (place - offsets[other]) / factors[other]
    back = np.where(truth.mirrored[other], back.conj(), back)
    partners = np.stack([back.real, back.imag], axis=1)
    above = truth.over[own, other][:, None]
    return np.where(above, points, partners), np.where(above, partners, points)


def _another(truth: ComparedState, place: Floats, own: Indices, chance: np.random.Generator) -> Indices:
    """(n,): a face at each place that is ordered against the point's own, drawn evenly; -1 if there is none."""
    assert truth.folded is not None, "the truth lies somewhere"
    there = inside(
        np.stack([place.real, place.imag], axis=1), [truth.folded[list(face)] for face in truth.faces]
    )
    ordered: Bools = there & (truth.over | truth.over.T)[own]
    lot = np.where(ordered, chance.random(ordered.shape), -1.0)
    return np.where(ordered.any(axis=1), lot.argmax(axis=1), -1)
