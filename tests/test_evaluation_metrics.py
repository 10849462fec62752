"""The metrics on states whose scores are known."""

from dataclasses import replace
from math import exp, pi

import numpy as np
import pytest
from corrupted_states import MISTAKES, corrupted, told_by
from evaluated import EXAMPLES, after, example_states, pleat, relabelled, scored
from folding_client.evaluation.compared_state import compared_state, inside
from folding_client.evaluation.counting_similarity import count_similarity, histogram_similarity
from folding_client.evaluation.evaluation_constants import CONSTANTS
from folding_client.evaluation.hausdorff import closest_hausdorff, hausdorff
from folding_client.evaluation.layer_agreement import layer_agreement, layer_pairs
from folding_client.evaluation.pattern_dissimilarity import matching_cost
from folding_client.evaluation.score_summaries import summary
from folding_client.evaluation.scoring_states import StateScorer
from folding_client.evaluation.state_equality import state_equal
from folding_schemas.actions import Flip, Fold, Rotate, Unfold
from hypothesis import given, settings
from hypothesis import strategies as st

SIMILARITIES = ("CV", "TSS", "GS", "CS", "FFS", "SIM")


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_state_scores_one_against_itself(name: str) -> None:
    for measured in example_states(name)[::3]:
        state = compared_state(measured)
        own = scored(state, state)
        assert own.equal
        assert own.scores["CPD"] == pytest.approx(0, abs=1e-9)
        assert [own.scores[metric] for metric in SIMILARITIES] == pytest.approx([1.0] * 6, abs=1e-9)


def test_a_crease_further_off_scores_lower() -> None:
    truth = pleat(0.0)
    by_shift = [scored(pleat(off), truth).scores for off in (0.0, 0.01, 0.05, 0.2)]
    for metric in ("GS", "FFS", "SIM"):
        values = [scores[metric] for scores in by_shift]
        assert values == sorted(values, reverse=True)
        assert len(set(values)) == 4
    costs = [scores["CPD"] for scores in by_shift]
    assert costs == sorted(costs)
    assert len(set(costs)) == 4


@pytest.mark.parametrize("seed", range(3))
def test_other_numbers_of_vertices_edges_and_faces_change_nothing(seed: int) -> None:
    measured = example_states("cat")[5]
    truth, changed = compared_state(measured), relabelled(measured, seed)
    own = scored(changed, truth)
    assert own.equal
    assert own.scores["CPD"] == pytest.approx(0, abs=1e-6)
    assert [own.scores[metric] for metric in SIMILARITIES] == pytest.approx([1.0] * 6, abs=1e-9)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_corners_of_the_sheet_called_otherwise_change_nothing(quarters: int) -> None:
    truth = compared_state(example_states("cat")[5])
    other = scored(truth.turned(quarters), truth)
    assert other.equal
    assert other.scores["CPD"] == pytest.approx(0, abs=1e-6)
    assert other.scores["FFS"] == pytest.approx(1)
    assert other.scores["TSS"] == pytest.approx(1)


def test_a_pattern_that_looks_the_same_turned_is_not_taken_for_another_order_of_layers() -> None:
    """Quartered along both middles, the sheet has a pattern that a turn leaves almost as it is, but the layers tell."""
    diagonal = after(Fold(edge=(4, 2), direction=1))
    for quarters in range(4):
        assert scored(diagonal.turned(quarters), diagonal).parts["FFS.LCR"] == 1


def test_a_state_that_does_not_compile_has_the_published_scores() -> None:
    truth = pleat(0.0)
    broken = replace(truth, problem="its layers cross")
    scores = scored(broken, truth).scores
    assert (scores["CV"], scores["GS"], scores["CS"], scores["FFS"]) == (0, 0.2, 0.2, 0.3)
    assert (scores["TSS"], scores["CPD"]) == pytest.approx((1, 0), abs=1e-9)


def test_a_state_of_which_nothing_is_known_has_every_crease_and_vertex_unmatched() -> None:
    truth = pleat(0.0)
    scores = scored(None, truth).scores
    assert (scores["TSS"], scores["CV"]) == (0, 0)
    assert scores["CPD"] == 30 * (len(truth.creases) + len(truth.sheet))


def test_a_model_turned_over_keeps_its_pattern_and_loses_the_order_of_its_layers() -> None:
    found = scored(pleat(0.0, Flip(axis="x")), pleat(0.0))
    assert not found.equal
    assert found.scores["TSS"] == pytest.approx(1)
    assert found.scores["CPD"] == pytest.approx(0, abs=1e-9)
    assert found.parts["FFS.LCR"] == 0
    assert found.parts["CS.TT"] == 1


def test_a_turned_model_has_the_same_folded_state_and_lies_otherwise() -> None:
    folded = Fold(edge=(4, 2), direction=-1)
    found = scored(after(folded, Rotate(angle=31)), after(folded))
    assert found.scores["FFS"] == pytest.approx(1, abs=1e-4)
    assert found.scores["GS"] < 0.9


def test_letters_are_counted_by_how_long_their_creases_are() -> None:
    """Half of the pleat's length is folded otherwise: the distributions differ by its share."""
    truth, opened = after(Fold(edge=(4, 2), direction=1)), after(Fold(edge=(4, 2), direction=1), Unfold())
    assert scored(opened, truth).parts["GS.AS"] == 0
    assert scored(opened, truth).parts["TSS.DSC"] == pytest.approx(1 - 1 / 5)


class TestParts:
    @pytest.mark.parametrize(
        ("a", "b", "similarity"),
        [(4, 4, 1.0), (0, 0, 1.0), (0, 2, exp(-1)), (4, 6, exp(-0.25)), (6, 4, exp(-0.25))],
    )
    def test_counts_are_compared_by_the_smaller(self, a: int, b: int, similarity: float) -> None:
        assert count_similarity(a, b, 0.5) == pytest.approx(similarity)

    def test_histograms_are_normalised(self) -> None:
        assert histogram_similarity({"M": 2, "V": 2}, {"M": 1, "V": 1}) == 1
        assert histogram_similarity({"M": 1}, {"V": 3}) == 0
        assert histogram_similarity({"M": 3, "V": 1}, {"M": 1, "V": 3}) == pytest.approx(0.5)
        assert histogram_similarity({}, {}) == 1
        assert histogram_similarity({}, {"V": 1}) == 0

    def test_a_matching_leaves_out_what_costs_more_than_being_left_out(self) -> None:
        assert matching_cost(np.array([[1.0, 9.0], [9.0, 2.0]]), 3) == 3
        assert matching_cost(np.array([[9.0]]), 3) == 6
        assert matching_cost(np.array([[1.0, 0.5, 2.0]]), 3) == 6.5
        assert matching_cost(np.empty((0, 2)), 3) == 6

    @settings(max_examples=15, deadline=None)
    @given(st.floats(0, 2 * pi), st.floats(-2, 2), st.floats(-2, 2))
    def test_a_rigid_motion_leaves_no_distance(self, turn: float, dx: float, dy: float) -> None:
        points = np.array([[0, 0], [1, 0], [1.2, 0.7], [0.3, 0.9]])
        c, s = np.cos(turn), np.sin(turn)
        moved = points @ np.array([[c, s], [-s, c]]) + (dx, dy)
        assert closest_hausdorff(moved, points, 1.0, 3) < 1e-3

    def test_a_reflection_is_no_motion(self) -> None:
        points = np.array([[0, 0], [1, 0], [1.2, 0.7], [0.3, 0.9]])
        assert closest_hausdorff(points * [1, -1], points, 1.0, 3) > 0.05

    def test_the_distance_is_two_sided(self) -> None:
        one, two = np.array([[0.0, 0.0]]), np.array([[0.0, 0.0], [3.0, 4.0]])
        assert hausdorff(one, two) == hausdorff(two, one) == 5

    def test_points_are_found_in_a_polygon_with_a_dent(self) -> None:
        dented = np.array([[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]], float)
        found = inside(np.array([[1.0, 1.0], [2.0, 3.0], [3.5, 3.0], [5.0, 1.0]]), [dented])
        assert found[:, 0].tolist() == [True, False, True, False]

    def test_pairs_of_layers_are_drawn_where_layers_lie_over_each_other(self) -> None:
        truth = after(Fold(edge=(4, 2), direction=-1))
        pairs = layer_pairs(truth, CONSTANTS)
        assert len(pairs.upper) == CONSTANTS.layer_pairs
        assert np.allclose(pairs.upper, pairs.lower[:, ::-1])
        assert (pairs.upper[:, 0] > pairs.upper[:, 1]).all()

    def test_a_flat_sheet_has_no_layers_to_compare(self) -> None:
        flat = after(Rotate(angle=10))
        assert len(layer_pairs(flat, CONSTANTS).upper) == 0
        assert layer_agreement(flat, layer_pairs(flat, CONSTANTS)) == (1, 1)

    def test_a_bootstrap_is_the_same_every_time_and_holds_the_mean(self) -> None:
        values = [0.2, 0.9, 0.4, 0.6, 0.95]
        found = summary(values, CONSTANTS)
        assert found == summary(values, CONSTANTS)
        assert found.mean is not None and found.low is not None and found.high is not None
        assert 0.2 < found.low < found.mean < found.high < 0.95
        assert summary([], CONSTANTS).mean is None
        assert summary([0.5], CONSTANTS).deviation == 0


def _told(
    count: int, seed: int, names: tuple[str, ...], mistakes: tuple[str, ...] = tuple(MISTAKES)
) -> dict[str, int]:
    """How many states with each mistake ``state_equal`` and some metric told from the truth."""
    states = [measured for name in names for measured in example_states(name)[2:]]
    told = dict.fromkeys(mistakes, 0)
    for mistake, measured, state in corrupted(states, count, seed, mistakes):
        truth = compared_state(measured)
        scorer = StateScorer(truth)
        found = scorer.scored(state)
        assert not state_equal(state, truth, CONSTANTS.equal_within)
        told[mistake] += bool(told_by(found, scorer.scored(truth)))
    return told


@pytest.mark.parametrize("mistake", MISTAKES)
def test_states_with_a_mistake_are_told_from_the_truth(mistake: str) -> None:
    assert _told(12, 1, ("cat",), (mistake,)) == {mistake: 12}


@pytest.mark.slow
def test_six_hundred_states_with_a_mistake_are_told_from_the_truth() -> None:
    assert _told(600, 2, EXAMPLES) == dict.fromkeys(MISTAKES, 120)
