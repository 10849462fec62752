"""TSS, topological structure similarity, on the crease pattern."""

from collections import Counter

import numpy as np

from folding_client.evaluation.compared_state import ComparedState
from folding_client.evaluation.counting_similarity import count_similarity, histogram_similarity
from folding_client.evaluation.evaluation_constants import EvaluationConstants


def topological_parts(
    state: ComparedState, truth: ComparedState, constants: EvaluationConstants
) -> dict[str, float]:
    """The terms: numbers of vertices, edges (degrees, components), faces (number, sides), letters."""
    decay = constants.count_decay
    degrees = histogram_similarity(Counter(state.degrees.tolist()), Counter(truth.degrees.tolist()))
    sides = histogram_similarity(Counter(map(len, state.faces)), Counter(map(len, truth.faces)))
    return {
        "TSS.NV": count_similarity(len(state.sheet), len(truth.sheet), decay),
        "TSS.EC": (degrees + count_similarity(pieces(state), pieces(truth), decay)) / 2,
        "TSS.FR": (count_similarity(len(state.faces), len(truth.faces), decay) + sides) / 2,
        "TSS.DSC": histogram_similarity(Counter(state.letters), Counter(truth.letters)),
    }


def topological_similarity(parts: dict[str, float], constants: EvaluationConstants) -> float:
    """Their weighted sum."""
    weights = constants.topology
    return (
        weights.vertices * parts["TSS.NV"]
        + weights.edges * parts["TSS.EC"]
        + weights.faces * parts["TSS.FR"]
        + weights.letters * parts["TSS.DSC"]
    )


def pieces(state: ComparedState) -> int:
    """How many pieces the graph of vertices and edges has."""
    label = np.arange(len(state.sheet))
    for u, v in state.edges:
        if label[u] != label[v]:
            label[label == label[v]] = label[u]
    return len(np.unique(label))
