"""Whether two states are one: same creases with the same letters, folded to the same place, layers in the same order."""

import numpy as np

from folding_client.evaluation.compared_state import ComparedState, Places
from folding_client.evaluation.pattern_dissimilarity import QUARTERS


def state_equal(state: ComparedState, truth: ComparedState, within: float) -> bool:
    """Whether a state is the truth, up to the numbers of vertices and faces and a quarter turn of the sheet; vertices may
    be ``within`` sheet units.
    """
    if state.compiles != truth.compiles or (state.folded is None) != (truth.folded is None):
        return False
    return any(_same(state.turned(quarters), truth, within) for quarters in QUARTERS)


def _same(state: ComparedState, truth: ComparedState, within: float) -> bool:
    matched = _matched(state, truth, within)
    if matched is None or not _same_edges(state, truth, matched):
        return False
    faces = {frozenset(face): index for index, face in enumerate(truth.faces)}
    found = [faces.get(frozenset(int(matched[v]) for v in face)) for face in state.faces]
    if None in found or len(found) != len(faces):
        return False
    order = np.array(found, np.intp)
    return not (state.over & truth.over[np.ix_(order, order)].T).any()


def _matched(state: ComparedState, truth: ComparedState, within: float) -> Places | None:
    """(v,): the true vertex of each vertex; None unless each has one, on the sheet and folded."""
    if len(state.sheet) != len(truth.sheet):
        return None
    apart = np.hypot(*(state.sheet[:, None] - truth.sheet[None, :]).transpose(2, 0, 1))
    matched: Places = apart.argmin(axis=1)
    if apart.min(axis=1).max() > within or len(np.unique(matched)) < len(matched):
        return None
    if state.folded is not None and truth.folded is not None:
        drift = np.hypot(*(state.folded - truth.folded[matched]).T)
        if drift.max() > within:
            return None
    return matched


def _same_edges(state: ComparedState, truth: ComparedState, matched: Places) -> bool:
    ours = {
        frozenset(matched[edge].tolist()): letter
        for edge, letter in zip(state.edges, state.letters, strict=True)
    }
    theirs = {
        frozenset(edge.tolist()): letter for edge, letter in zip(truth.edges, truth.letters, strict=True)
    }
    return ours == theirs
