"""LCR, the order of the layers: pairs of sheet points that coincide in the true folded state, and which lies over which."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from folding_client.evaluation.compared_state import ComparedState, Flags, Places, Reals, common_part, inside
from folding_client.evaluation.evaluation_constants import EvaluationConstants

MOST_BATCHES = 20
"""Batches of ``layer_pairs`` points that are drawn before fewer pairs have to do: of a sheet with few layers, most points lie
alone.
"""


@dataclass(frozen=True)
class LayerPairs:
    """(n, 2) sheet points, (n, 2) those that lie below them in the folded state, and (n, 2) whether the back of the sheet is up
    at the upper and at the lower.
    """

    upper: Reals
    lower: Reals
    mirrored: Flags


def layer_pairs(truth: ComparedState, constants: EvaluationConstants) -> LayerPairs:
    """Pairs of points of the true sheet that coincide when it is folded; none if nothing lies over anything.

    Every two faces that overlap have one, in the middle of what they have in common, so that no small flap is overlooked; the
    rest is drawn evenly over the sheet.
    """
    chance = np.random.default_rng(constants.layer_seed)
    found = [_middles(truth)]
    for _ in range(MOST_BATCHES if truth.over.any() else 0):
        if sum(map(len, found)) >= constants.layer_pairs:
            break
        found.append(_drawn(truth, chance, constants.layer_pairs))
    pairs = np.concatenate(found)[: max(constants.layer_pairs, len(found[0]))]
    outlines = [truth.sheet[list(face)] for face in truth.faces]
    faces = np.stack([_face_at(pairs[:, 0], outlines), _face_at(pairs[:, 1], outlines)], axis=1)
    return LayerPairs(pairs[:, 0], pairs[:, 1], truth.mirrored[faces])


def layer_agreement(state: ComparedState, pairs: LayerPairs) -> tuple[float, float]:
    """The share of the points of the pairs that show the same side in a state as in the truth, and the share of the pairs whose
    order is the same; 1 without pairs.

    Points that fall on one face of the state, or on faces that do not overlap, are not in that order.
    """
    if len(pairs.upper) == 0:
        return 1.0, 1.0
    outlines = [state.sheet[list(face)] for face in state.faces]
    upper, lower = _face_at(pairs.upper, outlines), _face_at(pairs.lower, outlines)
    known = (upper >= 0) & (lower >= 0)
    sides = np.stack([state.mirrored[upper], state.mirrored[lower]], axis=1) == pairs.mirrored
    return float((known[:, None] & sides).mean()), float((known & state.over[upper, lower]).mean())


def _face_at(points: Reals, outlines: list[Reals]) -> Places:
    """(n,): the face that holds each sheet point, -1 if none does."""
    held = inside(points, outlines)
    return np.where(held.any(axis=1), held.argmax(axis=1), -1)


def _middles(truth: ComparedState) -> Reals:
    """(n, 2, 2): for each two faces that overlap, the sheet points of the upper and the lower in the middle of that."""
    assert truth.folded is not None, "the truth lies somewhere"
    found = []
    for upper, lower in np.argwhere(truth.over):
        common = common_part(truth.folded[list(truth.faces[upper])], truth.folded[list(truth.faces[lower])])
        if len(common) >= 3:
            place = common.mean(axis=0) @ [1, 1j]
            found.append(
                [
                    _on_sheet(truth, np.array([place], np.complex128), np.array([face]))[0]
                    for face in (upper, lower)
                ]
            )
    return np.array(found, float).reshape(-1, 2, 2)


def _on_sheet(truth: ComparedState, place: NDArray[np.complex128], face: Places) -> Reals:
    """(n, 2): the sheet points of faces that lie at places of the folded state."""
    factors, offsets = truth.motions
    back = (place - offsets[face]) / factors[face]
    back = np.where(truth.mirrored[face], back.conj(), back)
    return np.stack([back.real, back.imag], axis=1)


def _drawn(truth: ComparedState, chance: np.random.Generator, count: int) -> Reals:
    """(n, 2, 2): of sheet points drawn evenly those that share their place, each with another there; upper, lower."""
    points = chance.random((count, 2)) * truth.sheet.max(axis=0)
    own = _face_at(points, [truth.sheet[list(face)] for face in truth.faces])
    points, own = points[own >= 0], own[own >= 0]
    factors, offsets = truth.motions
    z = points @ [1, 1j]
    place = factors[own] * np.where(truth.mirrored[own], z.conj(), z) + offsets[own]
    other = _another(truth, place, own, chance)
    shared = other >= 0
    points, own, other = points[shared], own[shared], other[shared]
    partners = _on_sheet(truth, place[shared], other)
    above = truth.over[own, other][:, None]
    return np.stack([np.where(above, points, partners), np.where(above, partners, points)], axis=1)


def _another(
    truth: ComparedState, place: NDArray[np.complex128], own: Places, chance: np.random.Generator
) -> Places:
    """(n,): a face at each place that is ordered against the point's own, drawn evenly; -1 if there is none."""
    assert truth.folded is not None, "the truth lies somewhere"
    there = inside(
        np.stack([place.real, place.imag], axis=1), [truth.folded[list(face)] for face in truth.faces]
    )
    ordered: Flags = there & (truth.over | truth.over.T)[own]
    lot = np.where(ordered, chance.random(ordered.shape), -1.0)
    return np.where(ordered.any(axis=1), lot.argmax(axis=1), -1)
