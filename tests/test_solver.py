"""The geometric solver on label images of known papers: every class of transition, drift, noise and hidden parts."""

from itertools import combinations
from math import cos, pi, sin
from random import Random

import pytest
from exactness import exactness
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate, Unfold
from folding_server.errors import ActionRefused
from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.line import Line
from folding_server.simulator import Paper, apply, new_paper, replay
from folding_server.vision.registration.edge_icp import snapped_to_edges
from folding_server.vision.registration.scene import face_stack
from folding_server.vision.solver.movable_layers import AT, NEAR_LINE, MovableLayers
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.realise import nice_fraction, realise
from folding_server.vision.solver.sheet_motions import locate
from folding_server.vision.solver.transition import explain
from hypothesis import given, settings, strategies
from label_views import CLEAN, Spoiling, views
from papers import CAT, figure
from shapely.geometry import Polygon

DRIFTED = Spoiling(shift=(0.02, -0.015), degrees=2.0, noise=0.01)
DIAGONAL: tuple[Action, ...] = (Rotate(angle=45), Fold(edge=(4, 2), direction=-1))
"""A triangle, back up: the first steps of many animals."""


def explained(
    before: tuple[Action, ...], step: tuple[Action, ...], spoiling: Spoiling = DRIFTED
) -> tuple[Paper, Plan]:
    """The true paper after a step, and the solver's best plan for it."""
    paper = replay(before)
    truth = paper
    for action in step:
        truth = apply(truth, action)
    return truth, explain(paper, IDENTITY, views(truth, spoiling))[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "step", "action_class"),
    [
        ((), (Rotate(angle=45),), "rotate"),
        (DIAGONAL, (Flip(axis="x"),), "flip"),
        (DIAGONAL, (Unfold(),), "unfold"),
        ((), (Fold(edge=(1, 3), direction=1),), "fold"),
        (DIAGONAL, (AddVertex(edge=(4, 2), position=0.5), Fold(edge=(5, 1), direction=-1)), "fold"),
        (
            DIAGONAL,
            (
                AddVertex(edge=(4, 1), position=0.3),
                AddVertex(edge=(1, 2), position=0.7),
                Fold(edge=(5, 6), direction=-1),
            ),
            "fold",
        ),
    ],
    ids=["rotate", "flip", "unfold", "diagonal", "half of a triangle", "strip of both layers"],
)
def test_each_class_of_transition_is_recovered_exactly(
    before: tuple[Action, ...], step: tuple[Action, ...], action_class: str
) -> None:
    truth, plan = explained(before, step)
    assert plan.action_class == action_class
    assert exactness(truth, plan.paper).holds(0.005)
    assert plan.agreement > 0.99


@pytest.mark.slow
@pytest.mark.parametrize("layers", ["top", "both"])
def test_the_layers_that_moved_are_told_apart(layers: str) -> None:
    edges = ((4, 3), (2, 3)) if layers == "top" else ((4, 1), (2, 1))
    marks = tuple(AddVertex(edge=edge, position=0.6) for edge in edges)
    truth, plan = explained(DIAGONAL, (*marks, Fold(edge=(5, 6), direction=1)))
    assert len(truth.faces) == (3 if layers == "top" else 4)
    assert exactness(truth, plan.paper).holds(0.01)


@pytest.mark.slow
def test_two_actions_in_one_keyframe_are_found() -> None:
    first = (
        AddVertex(edge=(1, 2), position=0.3),
        AddVertex(edge=(1, 4), position=0.3),
        Fold(edge=(5, 6), direction=1),
    )
    second = (
        AddVertex(edge=(2, 3), position=0.6),
        AddVertex(edge=(3, 4), position=0.4),
        Fold(edge=(7, 8), direction=-1),
    )
    truth, plan = explained((), (*first, *second), CLEAN)
    assert plan.action_class == "compound"
    assert exactness(truth, plan.paper).holds(0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "spoiling", [CLEAN, Spoiling(degrees=2.5), DRIFTED], ids=["still", "turned", "drifted"]
)
def test_folds_from_both_sides_are_found_though_no_side_of_the_sheet_stays(spoiling: Spoiling) -> None:
    left = (
        AddVertex(edge=(1, 2), position=0.12),
        AddVertex(edge=(4, 3), position=0.12),
        Fold(edge=(5, 6), direction=-1),
    )
    right = (
        AddVertex(edge=(2, 5), position=0.2),
        AddVertex(edge=(3, 6), position=0.2),
        Fold(edge=(7, 8), direction=1),
    )
    truth, plan = explained((), (*left, *right), spoiling)
    assert plan.action_class == "compound"
    assert exactness(truth, plan.paper).holds(0.02)


def test_borders_that_stay_hold_the_sheet_where_two_sides_are_folded_away() -> None:
    folded = replay(
        (
            AddVertex(edge=(1, 2), position=0.2),
            AddVertex(edge=(4, 3), position=0.2),
            Fold(edge=(5, 6), direction=-1),
        )
    )
    moved = Spoiling(shift=(0.01, 0.02), degrees=-2.0)
    motion = snapped_to_edges(face_stack(new_paper()), views(folded, moved).fine, IDENTITY)
    for place in ((1.0, 0.0), (1.0, 1.0), (0.3, 0.0), (0.3, 1.0)):
        assert motion(place) == pytest.approx(moved.motion(place), abs=0.004)


def test_a_sheet_that_lies_at_quite_another_angle_is_located() -> None:
    paper = replay((*DIAGONAL, AddVertex(edge=(4, 1), position=0.3), Fold(edge=(5, 2), direction=1)))
    turned = Spoiling(degrees=105.0)
    motion = locate(paper, views(paper, turned).coarse).motion
    for place in paper.folded_vertices_coords.values():
        assert motion(place) == pytest.approx(turned.motion(place), abs=0.01)


def test_a_fold_a_hair_beside_where_a_layer_above_begins_leaves_that_layer_alone() -> None:
    program = figure(CAT)
    cat = replay([action for step in program.steps[:6] for action in step])
    truth = cat
    for action in program.steps[6]:
        truth = apply(truth, action)
    head = {1, 2, 3, 4}
    for gap in (0.0, 0.0004, 0.0008):
        line = Line(0.0, 1.0, truth.folded_vertices_coords[10][1] - gap)
        (moving,) = (m for m in MovableLayers(cat).moving_sets(line) if m.faces == head)
        ((_, folded),) = realise(cat, moving, exact=False)
        assert turned_by(cat, folded) == head


@pytest.mark.parametrize("tilt", [0.0, 0.0004, -0.0004, 0.01, -0.01])
def test_the_side_meant_moves_however_little_a_line_leans_from_the_vertical(tilt: float) -> None:
    paper = new_paper()
    for line in (Line(cos(tilt), sin(tilt), 0.862), Line(-cos(tilt), -sin(tilt), -0.862)):
        (moving,) = MovableLayers(paper).moving_sets(line)
        ((_, folded),) = realise(paper, moving, exact=False)
        (turned,) = (face for face in folded.faces if folded.back_up(face))
        middle = Polygon(folded.sheet_polygon(turned)).representative_point()
        assert line.distance((middle.x, middle.y)) > 0


@pytest.mark.parametrize("height", [0.01, 0.012, 0.02, 0.4])
def test_the_tip_of_a_corner_is_folded_however_short_the_crease(height: float) -> None:
    paper = replay([Rotate(angle=45)])
    top = max(y for _, y in paper.folded_vertices_coords.values())
    (moving,) = MovableLayers(paper).moving_sets(Line(0.0, 1.0, top - height))
    ((_, folded),) = realise(paper, moving, exact=True)
    assert max(y for _, y in folded.folded_vertices_coords.values()) == pytest.approx(top - height)


@pytest.mark.parametrize(
    ("fraction", "length", "taken"), [(0.501, 1.0, 0.5), (0.51, 0.1, 0.51), (0.503, 0.1, 0.5)]
)
def test_a_simple_fraction_is_taken_where_it_is_near_for_the_length_of_the_edge(
    fraction: float, length: float, taken: float
) -> None:
    assert nice_fraction(fraction, length, exact=False) == taken


@settings(max_examples=50)
@given(strategies.integers(0, 10**6))
def test_layer_sets_are_closed_and_each_can_be_folded(seed: int) -> None:
    paper, line = creased_at_random(seed)
    sets = list(MovableLayers(paper).moving_sets(line))
    assert len({moving.faces for moving in sets}) == len(sets)
    for first, second in combinations(sets, 2):
        if second.seed in first.faces:
            assert second.faces <= first.faces
    for moving in sets:
        ways = realise(paper, moving, exact=True)
        assert ways
        for _, folded in ways:
            turned = turned_by(paper, folded)
            assert turned & moving.faces
            assert thin(paper, line, turned - moving.faces)


def test_nearly_every_layer_set_turns_as_it_was_predicted() -> None:
    """Where both places at which the line meets a layer also lie on one above, the fold that names them may turn less."""
    predicted, turned = 0, 0
    for paper, line in map(creased_at_random, range(60)):
        for moving in MovableLayers(paper).moving_sets(line):
            ways = [turned_by(paper, folded) for _, folded in realise(paper, moving, exact=True)]
            predicted += 1
            turned += len(ways) == 1 and thin(paper, line, ways[0] ^ moving.faces)
    assert predicted > 50
    assert turned >= 0.97 * predicted


def creased_at_random(seed: int) -> tuple[Paper, Line]:
    """A paper folded at random, and a line across it that no vertex is near."""
    random = Random(seed)
    while True:
        paper = random_paper(random, 3)
        line = line_across(paper, random)
        if min(abs(line.distance(p)) for p in paper.folded_vertices_coords.values()) > NEAR_LINE:
            return paper, line


def line_across(paper: Paper, random: Random) -> Line:
    """A line at any angle through a place between two vertices of a folded paper."""
    angle, part = random.uniform(0, 2 * pi), random.uniform(0.2, 0.8)
    (x, y), (u, v) = random.sample(sorted(paper.folded_vertices_coords.values()), 2)
    place = (x + part * (u - x), y + part * (v - y))
    return Line(cos(angle), sin(angle), cos(angle) * place[0] + sin(angle) * place[1])


def thin(paper: Paper, line: Line, faces: frozenset[int]) -> bool:
    """Whether faces reach no further over a line than a crease is found exactly."""
    return all(line.distance(p) <= 2 * NEAR_LINE for face in faces for p in paper.polygon(face))


def turned_by(paper: Paper, folded: Paper) -> frozenset[int]:
    """Faces of a paper of which a part lies the other way up after a fold."""
    parent = {face: _holding(paper, folded, face) for face in folded.faces}
    return frozenset(
        parent[face] for face in folded.faces if folded.back_up(face) != paper.back_up(parent[face])
    )


def _holding(paper: Paper, folded: Paper, face: int) -> int:
    """The face of a paper that a face cut from it was part of."""
    part = Polygon(folded.sheet_polygon(face))
    return max(paper.faces, key=lambda f: Polygon(paper.sheet_polygon(f)).intersection(part).area)


def random_paper(random: Random, folds: int) -> Paper:
    """A paper folded along random lines through two of its edges."""
    paper = new_paper()
    for _ in range(folds):
        (a, b), (c, d) = random.sample(sorted(paper.edge_faces), 2)
        fresh = max(paper.vertices_coords) + 1
        try:
            marked = apply(
                apply(paper, AddVertex(edge=(a, b), position=0.4)), AddVertex(edge=(c, d), position=0.7)
            )
            paper = apply(marked, Fold(edge=(fresh, fresh + 1), direction=random.choice((1, -1))))
        except ActionRefused:
            continue
    return paper


def test_a_hair_beyond_a_line_takes_its_layer_along_only_if_the_line_is_exact() -> None:
    """A flap that was folded a little too far lies over the crease along which the other side is folded next."""
    halved = (
        AddVertex(edge=(1, 2), position=0.5),
        AddVertex(edge=(3, 4), position=0.5),
        Fold(edge=(5, 6), direction=1),
        Unfold(),
    )
    too_far = (
        AddVertex(edge=(5, 2), position=0.496),
        AddVertex(edge=(3, 6), position=0.504),
        Fold(edge=(7, 8), direction=1),
    )
    layers, crease = MovableLayers(replay((*halved, *too_far))), Line(-1.0, 0.0, -0.5)
    assert [moving.faces for moving in layers.moving_sets(crease)] == [{1}]
    assert [moving.faces for moving in layers.moving_sets(crease, AT)] == [{3}, {1, 3}]


def test_what_a_hand_hides_does_not_count() -> None:
    hidden = Spoiling(noise=0.01, hidden=(0.35, 0.75, 0.15))
    truth, plan = explained(
        DIAGONAL, (AddVertex(edge=(4, 2), position=0.5), Fold(edge=(5, 1), direction=-1)), hidden
    )
    assert exactness(truth, plan.paper).holds(0.01)


@pytest.mark.slow
def test_nothing_happened_is_an_answer() -> None:
    lopsided = (*DIAGONAL, AddVertex(edge=(4, 1), position=0.4), AddVertex(edge=(4, 2), position=0.2))
    _, plan = explained((*lopsided, Fold(edge=(5, 6), direction=1)), ())
    assert plan.actions == ()


@pytest.mark.slow
def test_a_line_the_photo_cannot_tell_from_a_landmark_is_the_landmark() -> None:
    _, plan = explained(DIAGONAL, (AddVertex(edge=(4, 2), position=0.4999), Fold(edge=(5, 1), direction=-1)))
    assert {action.position for action in plan.actions if isinstance(action, AddVertex)} == {0.5}


def test_the_sheet_is_located_where_it_drifted_to() -> None:
    paper = replay(DIAGONAL)
    motion = locate(paper, views(paper, DRIFTED).coarse).motion
    for place in paper.folded_vertices_coords.values():
        expected = DRIFTED.motion(place)
        assert motion(place) == pytest.approx(expected, abs=0.01)


@pytest.mark.slow
def test_the_first_steps_of_the_cat_are_recovered_from_label_images_alone() -> None:
    program = figure(CAT)
    truth, found, last = new_paper(), new_paper(), IDENTITY
    for number, step in enumerate(program.steps[:5]):
        for action in step:
            truth = apply(truth, action)
        best = explain(found, last, views(truth, Spoiling(degrees=0.5 * number - 2, noise=0.01), number))[0]
        assert best.agreement > 0.99
        found, last = best.paper, best.motion
    assert exactness(truth, found).holds(0.02)
