"""People fold a little beside what they aim at: how folds along landmarks and beside them are judged."""

from folding_schemas.actions import Actions, AddVertex, Fold
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import new_paper, replay
from folding_server.vision.solver.lines_beside import FARTHEST_BESIDE, with_lines_beside
from folding_server.vision.solver.plan import Plan


def corner_folded(at: float, agreement: float, *, free: bool = False) -> Plan:
    """A corner folded in, along a line through two sides at a share of each."""
    actions: Actions = (
        AddVertex(edge=(1, 2), position=at),
        AddVertex(edge=(1, 4), position=at),
        Fold(edge=(5, 6), direction=1),
    )
    paper = replay(actions)
    return Plan(actions, "fold", paper, IDENTITY, agreement, "").noting(new_crease=1, free_line=float(free))


def test_a_fold_along_a_landmark_counts_for_what_a_line_a_little_beside_explains() -> None:
    landmark, beside = corner_folded(0.5, 0.985), corner_folded(0.506, 0.991, free=True)
    judged, other = with_lines_beside([beside, landmark])
    assert judged.actions == landmark.actions
    assert judged.beside == beside.paper
    assert beside.score < judged.score < beside.score - beside.noted.of("free_line")
    assert other == beside


def test_a_line_far_beside_says_nothing_of_the_landmark() -> None:
    landmark = corner_folded(0.5, 0.985)
    far = corner_folded(0.5 + 1.5 * FARTHEST_BESIDE, 0.995, free=True)
    assert {plan.score for plan in with_lines_beside([landmark, far])} == {landmark.score, far.score}


def test_a_landmark_that_explains_most_stays_as_it_is() -> None:
    landmark, beside = corner_folded(0.5, 0.993), corner_folded(0.506, 0.991, free=True)
    assert [plan.score for plan in with_lines_beside([landmark, beside])] == [landmark.score, beside.score]


def test_what_makes_no_crease_is_not_compared() -> None:
    nothing = Plan((), "none", new_paper(), IDENTITY, 0.98, "")
    beside = corner_folded(0.506, 0.991, free=True)
    assert with_lines_beside([nothing, beside]) == sorted([nothing, beside], key=lambda plan: -plan.score)
