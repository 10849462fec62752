"""All metrics of one state against the truth."""

from dataclasses import dataclass
from math import exp

from folding_schemas.evaluation import METRICS, Scores

from folding_client.evaluation.compared_state import ComparedState
from folding_client.evaluation.constraint_satisfaction import constraint_parts, constraint_satisfaction
from folding_client.evaluation.evaluation_constants import CONSTANTS, EvaluationConstants
from folding_client.evaluation.geometric_similarity import geometric_parts, geometric_similarity
from folding_client.evaluation.hausdorff import closest_hausdorff
from folding_client.evaluation.layer_agreement import LayerPairs, layer_agreement, layer_pairs
from folding_client.evaluation.pattern_dissimilarity import dissimilarities, nothing_matched
from folding_client.evaluation.state_equality import state_equal
from folding_client.evaluation.topological_similarity import topological_parts, topological_similarity


@dataclass(frozen=True)
class StateScores:
    """The metrics by name, the terms they are made of, and whether the state is the truth."""

    scores: Scores
    parts: dict[str, float]
    equal: bool


class StateScorer:
    """Scores states against one true state, of which it draws the pairs of layers once.

    >>> scorer = StateScorer(truth)
    >>> scorer.scored(state).scores["TSS"]
    """

    def __init__(self, truth: ComparedState, constants: EvaluationConstants = CONSTANTS) -> None:
        self.truth = truth
        self.constants = constants
        self._pairs: LayerPairs = layer_pairs(truth, constants)

    def scored(self, state: ComparedState | None) -> StateScores:
        """The scores of a state; of None, of which not even a crease pattern is known, the worst that there are."""
        if state is None:
            nothing = nothing_matched(self.truth, self.constants.pattern)
            return StateScores(self._with_average({"TSS": 0.0, "CPD": nothing}), {}, equal=False)
        parts = topological_parts(state, self.truth, self.constants)
        by_turn = dissimilarities(state, self.truth, self.constants)
        least = min(sum(each.values()) for each in by_turn.values())
        best = [
            turn for turn, each in by_turn.items() if sum(each.values()) <= least + self.constants.same_turn
        ]
        parts |= by_turn[best[0]]
        scores: Scores = {"TSS": topological_similarity(parts, self.constants), "CPD": least}
        if state.compiles and state.folded is not None:
            parts |= self._folded_parts(state, best)
            scores |= self._folded_scores(parts)
        equal = state_equal(state, self.truth, self.constants.equal_within)
        return StateScores(self._with_average(scores), parts, equal)

    def _folded_parts(self, state: ComparedState, turns: list[int]) -> dict[str, float]:
        """The terms of the metrics that need a state that compiles, for the quarter turns that suit its pattern best."""
        constants = self.constants
        assert state.folded is not None and self.truth.folded is not None, "both states lie somewhere"  # noqa: PT018
        distance = closest_hausdorff(state.folded, self.truth.folded, constants.turn_step, constants.refined)
        return {
            **geometric_parts(state, self.truth, constants),
            **constraint_parts(state, self.truth, constants),
            "FFS.HD": exp(-constants.distance_decay * distance),
            "FFS.LCR": max(layer_agreement(state.turned(turn), self._pairs) for turn in turns)[1],
        }

    def _folded_scores(self, parts: dict[str, float]) -> Scores:
        weights = self.constants.folded
        return {
            "CV": 1.0,
            "GS": geometric_similarity(parts, self.constants),
            "CS": constraint_satisfaction(parts, self.constants),
            "FFS": weights.distance * parts["FFS.HD"] + weights.layers * parts["FFS.LCR"],
        }

    def _with_average(self, scores: Scores) -> Scores:
        """All metrics, with the published scores of a state that does not compile where it does not."""
        failed = self.constants.not_compiled
        compiled: Scores = {"CV": 0.0, "GS": failed.geometry, "CS": failed.constraints, "FFS": failed.folded}
        known: Scores = {**compiled, **scores}
        average = (known["TSS"] + known["GS"] + known["CS"] + known["FFS"]) / 4
        known["SIM"] = average
        return {metric: float(known[metric]) for metric in METRICS}
