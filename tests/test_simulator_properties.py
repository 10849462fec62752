"""Laws of folding that hold for every paper: what undoes what, and what does not depend on order."""

from collections.abc import Mapping
from random import Random

import pytest
import shapely
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate
from folding_server.errors import ActionRefused
from folding_server.geometry.line import Point
from folding_server.simulator import (
    Paper,
    add_vertex,
    apply,
    flip,
    fold,
    folded_state,
    new_paper,
    overlapping_pairs,
    replay,
    rotate,
    unfold,
)
from folding_server.simulator.validity import violations
from hypothesis import assume, given, settings
from hypothesis import strategies as st

FRACTIONS = st.sampled_from([0.25, 1 / 3, 0.5, 0.75]) | st.floats(0.05, 0.95)


@st.composite
def programs(draw: st.DrawFn, folds: int = 4, sheet: Point = (1.0, 1.0)) -> list[Action]:
    """Actions that all succeed: folds through new points on two edges of one face, turned and flipped between."""
    paper, actions = new_paper(sheet), []
    for _ in range(draw(st.integers(1, folds))):
        for action in draw(
            st.sampled_from([(), (Flip(axis="x"),), (Flip(axis="y=x"),), (Rotate(angle=30.0),)])
        ):
            actions.append(action)
            paper = apply(paper, action)
        cycle = paper.faces[draw(st.sampled_from(sorted(paper.faces)))]
        i, j = draw(st.lists(st.integers(0, len(cycle) - 1), min_size=2, max_size=2, unique=True))
        new = max(paper.vertices_coords)
        steps = [
            AddVertex(edge=(cycle[i - 1], cycle[i]), position=draw(FRACTIONS)),
            AddVertex(edge=(cycle[j - 1], cycle[j]), position=draw(FRACTIONS)),
            Fold(edge=(new + 1, new + 2), direction=draw(st.sampled_from([1, -1]))),
        ]
        try:
            paper = replay([*actions, *steps], sheet)
        except ActionRefused:
            continue
        actions += steps
    assume(any(isinstance(action, Fold) for action in actions))
    return actions


def same_places(one: Paper, other: Paper) -> bool:
    """Whether two papers lie in the same place, to rounding."""
    return one.folded_vertices_coords.keys() == other.folded_vertices_coords.keys() and all(
        p == pytest.approx(other.folded_vertices_coords[v], abs=1e-9)
        for v, p in one.folded_vertices_coords.items()
    )


def same_model(one: Paper, other: Paper) -> bool:
    """Whether two papers are one model: faces by their corners on the sheet, sides up, places and layers."""
    return outlook(one) == outlook(other)


def outlook(paper: Paper) -> tuple[Mapping[object, object], set[tuple[object, object]]]:
    """Where each face lies and which side is up, and which of two overlapping faces is lower, free of ids."""
    name = {f: frozenset(rounded(p) for p in paper.sheet_polygon(f)) for f in paper.faces}
    lies = {name[f]: (paper.back_up(f), frozenset(rounded(p) for p in paper.polygon(f))) for f in paper.faces}
    return lies, {(name[low], name[high]) for low, high in overlapping_pairs(paper)}


def rounded(point: tuple[float, float]) -> tuple[float, float]:
    return round(point[0], 6) + 0.0, round(point[1], 6) + 0.0


@settings(max_examples=40, deadline=None)
@given(programs())
def test_every_paper_is_valid(actions):
    assert violations(replay(actions)) == []


RECTANGLES = [(1.0, 2**0.5), (2.35, 1.0), (0.5, 20.0)]


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(RECTANGLES).flatmap(lambda sheet: st.tuples(st.just(sheet), programs(sheet=sheet))))
def test_a_rectangle_folds_flips_and_opens_like_a_square(drawn):
    sheet, actions = drawn
    paper = replay(actions, sheet)
    assert violations(paper) == []
    assert same_places(flip(flip(paper, "x"), "x"), paper)
    last = max(k for k, action in enumerate(actions) if isinstance(action, Fold))
    before, opened = replay(actions[:last], sheet), unfold(replay(actions[: last + 1], sheet))
    assert all(
        opened.folded_vertices_coords[v] == pytest.approx(place, abs=1e-9)
        for v, place in before.folded_vertices_coords.items()
    )


@settings(max_examples=60, deadline=None)
@given(programs())
def test_unfold_undoes_the_fold_before_it_and_leaves_flat_marks(actions):
    last = max(k for k, action in enumerate(actions) if isinstance(action, Fold))
    before, folded = replay(actions[:last]), replay(actions[: last + 1])
    after = unfold(folded)
    assert violations(after) == []
    whole = {face: part_of(before, after, face) for face in after.faces}
    assert all(
        after.isometries[face] == pytest.approx(before.isometries[whole[face]], abs=1e-9)
        for face in after.faces
    )
    # A vertex is read off one of its faces, which may differ by the tolerance: by another face than before, perhaps.
    assert all(
        any(place == pytest.approx(read, abs=1e-9) for read in readings(before, v))
        for v, place in after.folded_vertices_coords.items()
        if v in before.vertices_coords
    )
    assert all(after.back_up(face) == before.back_up(whole[face]) for face in after.faces)
    assert all(before.rank[whole[low]] < before.rank[whole[high]] for low, high in overlapping_pairs(after))
    assert {
        letter for edge, letter in after.edges() if len({whole[f] for f in after.edge_faces[edge]}) == 1
    } <= {"B", "F"}


def readings(paper: Paper, vertex: int) -> list[Point]:
    """Where each face that has a vertex puts it."""
    return [
        paper.isometries[face](paper.vertices_coords[vertex])
        for face, cycle in paper.faces.items()
        if vertex in cycle
    ]


def part_of(before: Paper, after: Paper, face: int) -> int:
    """The face of the paper before whose part a face is."""
    middle = shapely.Polygon(after.sheet_polygon(face)).representative_point()
    (whole,) = (f for f in before.faces if shapely.Polygon(before.sheet_polygon(f)).contains(middle))
    return whole


@settings(max_examples=40, deadline=None)
@given(programs(), st.sampled_from(["x", "y", "y=x", "y=-x"]))
def test_flipping_twice_is_nothing(actions, axis):
    paper = replay(actions)
    twice = flip(flip(paper, axis), axis)
    assert (twice.order, twice.faces, twice.vertices_coords) == (
        paper.order,
        paper.faces,
        paper.vertices_coords,
    )
    assert same_places(twice, paper)


@settings(max_examples=40, deadline=None)
@given(programs(), st.floats(-360, 360))
def test_turning_there_and_back_is_nothing(actions, angle):
    paper = replay(actions)
    back = rotate(rotate(paper, angle), -angle)
    assert (back.order, back.faces, back.vertices_coords) == (paper.order, paper.faces, paper.vertices_coords)
    assert same_places(back, paper)


@settings(max_examples=40, deadline=None)
@given(programs(), st.sampled_from(["x", "y", "y=x", "y=-x"]), st.floats(-360, 360))
def test_letters_do_not_depend_on_how_the_model_is_held(actions, axis, angle):
    paper = replay(actions)
    assert dict(flip(rotate(paper, angle), axis).edges()) == dict(paper.edges())


@settings(max_examples=40, deadline=None)
@given(programs())
def test_an_action_leaves_the_paper_it_is_given_as_it_was(actions):
    paper, states = new_paper(), []
    papers = [paper]
    for action in actions:
        states.append(folded_state(paper))
        paper = apply(paper, action)
        papers.append(paper)
    assert [folded_state(p) for p in papers[:-1]] == states


@settings(max_examples=30, deadline=None)
@given(programs(), st.data())
def test_undoing_is_replaying_the_prefix(actions, data):
    """Papers are immutable and replay is exact: stepping and replaying any prefix give one state."""
    length = data.draw(st.integers(0, len(actions)))
    paper = new_paper()
    for action in actions[:length]:
        paper = apply(paper, action)
    assert replay(actions[:length]) == paper


def with_marks(size: float) -> Paper:
    """A sheet with two marks near each corner, on the sides that meet there: 5..12."""
    paper = new_paper()
    for u, v in ((1, 2), (2, 3), (3, 4), (4, 1)):
        near = max(paper.vertices_coords) + 1
        paper = add_vertex(paper, (u, v), size)
        paper = add_vertex(paper, (near, v), (1 - 2 * size) / (1 - size))
    return paper


CORNER_FOLDS = [((5, 12), 1), ((6, 7), 1), ((8, 9), -1), ((10, 11), -1)]


@settings(max_examples=40, deadline=None)
@given(st.floats(0.05, 0.45), st.permutations(range(4)), st.permutations(range(4)))
def test_folds_of_flaps_that_do_not_touch_commute(size, one, other):
    assert same_model(corners_folded(size, one), corners_folded(size, other))


def corners_folded(size: float, order: list[int]) -> Paper:
    paper = with_marks(size)
    for k in order:
        paper = fold(paper, *CORNER_FOLDS[k])
    assert violations(paper) == []
    return paper


@settings(max_examples=30, deadline=None)
@given(st.floats(0.05, 0.3), st.integers(0, 3), st.integers(0, 10_000))
def test_unfolding_flaps_in_any_order_gives_the_flat_sheet(size, first, seed):
    paper = corners_folded(size, [0, 1, 2, 3])
    order = CORNER_FOLDS[first:] + CORNER_FOLDS[:first]
    Random(seed).shuffle(order)
    for edge, _ in order:
        paper = unfold(paper, edge)
    assert not any(paper.is_folded(edge) for edge in paper.edge_faces)
    assert same_places(paper, with_marks(size))
