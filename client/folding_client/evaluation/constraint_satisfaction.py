"""CS, constraint satisfaction: how many conditions of each kind the layers have to meet, against the truth's."""

from folding_client.evaluation.compared_state import ComparedState
from folding_client.evaluation.counting_similarity import count_similarity
from folding_client.evaluation.evaluation_constants import EvaluationConstants


def constraint_parts(
    state: ComparedState, truth: ComparedState, constants: EvaluationConstants
) -> dict[str, float]:
    """The terms: numbers of taco-taco, taco-tortilla and transitivity conditions; vertices that can lie flat."""
    decay = constants.count_decay
    ours, theirs = state.constraints, truth.constraints
    return {
        "CS.TT": count_similarity(ours.taco_taco, theirs.taco_taco, decay),
        "CS.TTo": count_similarity(ours.taco_tortilla, theirs.taco_tortilla, decay),
        "CS.Trans": count_similarity(ours.transitivity, theirs.transitivity, decay),
        "CS.FF": state.locally_flat,
    }


def constraint_satisfaction(parts: dict[str, float], constants: EvaluationConstants) -> float:
    """Their weighted sum."""
    weights = constants.constraints
    return (
        weights.taco_taco * parts["CS.TT"]
        + weights.taco_tortilla * parts["CS.TTo"]
        + weights.transitivity * parts["CS.Trans"]
        + weights.locally_flat * parts["CS.FF"]
    )
