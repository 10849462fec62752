"""Foldability of small patterns: counts that are known, conditions that fail, and orders that the validators accept."""

from dataclasses import replace
from itertools import permutations
from math import cos, radians, sin

import networkx as nx
import pytest
from folding_server.errors import ProgramError
from folding_server.simulator import Paper, add_vertex, fold, new_paper
from folding_server.simulator.foldability import CreasePattern, check_paper, check_pattern
from folding_server.simulator.foldability.constraints import Conditions, conditions
from folding_server.simulator.foldability.equations import ContradictionError, equations
from folding_server.simulator.foldability.flat_faces import lay_flat
from folding_server.simulator.foldability.general_solver import solve
from folding_server.simulator.foldability.orders import Orders
from folding_server.simulator.foldability.search import (
    count_orders,
    first_order,
    outwards,
    parts,
    search_part,
)
from folding_server.simulator.validity import violations
from hypothesis import example, given, settings
from hypothesis import strategies as st
from papers import random_paper

STAMPS = {1: 1, 2: 2, 3: 6, 4: 16, 5: 50, 6: 144, 7: 462}
"""Ways to fold a strip of stamps (OEIS A000136)."""
MAPS = {(2, 2): 8, (2, 3): 60, (2, 4): 320, (3, 3): 1368}
"""Ways to fold a map (OEIS A001415, A001418)."""


def grid(columns: int, rows: int, assignments: str = "U", width: tuple[float, ...] = ()) -> CreasePattern:
    """A map with creases lettered in turn, column lines first; columns may differ in width."""
    widths = width or (1.0,) * columns
    xs = [sum(widths[:i]) for i in range(columns + 1)]
    vertices = tuple((x, float(j)) for j in range(rows + 1) for x in xs)
    upwards = [
        (j * (columns + 1) + i, (j + 1) * (columns + 1) + i) for i in range(columns + 1) for j in range(rows)
    ]
    across = [
        (j * (columns + 1) + i, j * (columns + 1) + i + 1) for j in range(rows + 1) for i in range(columns)
    ]
    inner = [e for e in upwards if 0 < e[0] % (columns + 1) < columns] + across[columns:-columns]
    edges = tuple(upwards + across)
    given = {edge: assignments[k % len(assignments)] for k, edge in enumerate(inner)}
    return CreasePattern(vertices, edges, tuple(given.get(edge, "B") for edge in edges))


def star(angles: list[float], assignments: str) -> CreasePattern:
    """One vertex, 0, in a polygon whose corners 1, 2, ... lie in these directions, in degrees."""
    n = len(angles)
    rim = [(cos(radians(a)), sin(radians(a))) for a in angles]
    spokes = [(0, k + 1) for k in range(n)]
    outline = [(k + 1, (k + 1) % n + 1) for k in range(n)]
    return CreasePattern(((0.0, 0.0), *rim), (*spokes, *outline), (*assignments, *"B" * n))


@pytest.mark.parametrize(("stamps", "ways"), STAMPS.items())
def test_a_strip_of_stamps_folds_in_the_known_number_of_ways(stamps, ways):
    report = check_pattern(grid(stamps, 1))
    assert (report.foldable, report.states, report.capped) == (True, ways, False)


@pytest.mark.parametrize(("size", "ways"), MAPS.items())
def test_a_map_folds_in_the_known_number_of_ways(size, ways):
    assert check_pattern(grid(*size), cap=2000).states == ways


def test_counting_stops_at_the_cap_and_says_so():
    report = check_pattern(grid(7, 1), cap=100)
    assert (report.states, report.capped) == (100, True)
    assert "at least 100" in report.reason
    one = check_pattern(grid(7, 1), cap=1)
    assert (one.states, one.capped) == (1, True)
    assert check_pattern(grid(2, 1, "V"), cap=1).capped is False


def test_a_square_without_creases_has_one_state():
    report = check_pattern(grid(1, 1))
    assert (report.foldable, report.states, report.stack) == (True, 1, (0,))


def test_a_mark_is_not_folded():
    report = check_pattern(grid(2, 1, "F"))
    assert (report.foldable, report.states, report.lying) == (True, 1, ())


@pytest.mark.parametrize(("assignment", "order"), [("V", (0, 1)), ("M", (1, 0))])
def test_a_letter_says_which_face_of_a_book_lies_on_top(assignment, order):
    assert check_pattern(grid(2, 1, assignment)).lying == (order,)


@pytest.mark.parametrize(
    ("widths", "assignments", "foldable"),
    [((1.0, 0.5, 1.0), "VV", False), ((1.0, 2.0, 1.0), "VV", True), ((1.0, 0.5, 1.0), "VM", True)],
)
def test_a_short_panel_cannot_be_rolled_up_between_two_long_ones(widths, assignments, foldable):
    report = check_pattern(grid(3, 1, assignments, widths))
    assert report.foldable == foldable
    if not foldable:
        assert "no order of the layers" in report.reason


def test_four_mountains_break_maekawa_and_the_vertex_is_named():
    report = check_pattern(replace(grid(2, 2, "M"), names=tuple(range(10, 19))))
    (found,) = report.violations
    assert (found.vertex, found.condition, report.foldable) == (14, "Maekawa", False)


def test_an_odd_number_of_creases_breaks_maekawa_even_without_letters():
    report = check_pattern(star([0, 120, 240], "UUU"))
    assert [found.vertex for found in report.violations] == [0]
    assert "odd" in report.reason


def test_unlettered_creases_may_be_what_maekawa_needs():
    assert check_pattern(star([0, 90, 180, 270], "MMUU")).foldable
    assert not check_pattern(star([0, 90, 180, 270], "MMUM")).violations


def test_angles_that_do_not_alternate_break_kawasaki():
    report = check_pattern(star([0, 80, 180, 290], "MMMV"))
    assert [(found.vertex, found.condition) for found in report.violations] == [(0, "Kawasaki")]


def test_the_smallest_angle_between_two_mountains_does_not_fold():
    """Kawasaki and Maekawa hold, but the smallest sector cannot lie on both neighbours' backs (big-little-big)."""
    angles = [0, 40, 150, 290]
    verdicts = {
        assignments: check_pattern(star(angles, assignments)).foldable
        for assignments in ("MMMV", "VMMM", "MVMM", "MMVM")
    }
    assert verdicts == {"MMMV": False, "VMMM": True, "MVMM": True, "MMVM": False}


def test_edges_that_cross_are_no_crease_pattern():
    square = CreasePattern(
        ((0, 0), (1, 0), (1, 1), (0, 1)), ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3)), (*"BBBBVV",)
    )
    report = check_pattern(square)
    assert not report.foldable
    assert "0-2 and 1-3" in report.reason


def test_a_crease_that_ends_inside_the_sheet_cannot_be_folded():
    dangling = CreasePattern(
        ((0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5)), ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4)), (*"BBBBV",)
    )
    assert "0-4" in check_pattern(dangling).reason
    assert check_pattern(replace(dangling, edges_assignment=(*"BBBBF",))).foldable


def test_two_sheets_are_not_one():
    apart = CreasePattern(
        ((0, 0), (1, 0), (0, 1), (5, 0), (6, 0), (5, 1)),
        ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)),
        (*"BBBBBB",),
    )
    assert "more than one sheet" in check_pattern(apart).reason


def test_a_ring_that_does_not_close_up_is_refused():
    """Four corners of a frame around a hole: every vertex is on the outline, yet the last face misses the first."""
    outer = [(0, 0), (3, 0), (3, 3), (0, 3)]
    inner = [(1, 1), (2, 1), (2, 2.2), (1, 2)]
    edges = (
        [(k, (k + 1) % 4) for k in range(4)]
        + [(4 + k, 4 + (k + 1) % 4) for k in range(4)]
        + [(k, k + 4) for k in range(4)]
    )
    faces = [(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]
    ring = CreasePattern(tuple(outer + inner), tuple(edges), (*"BBBBBBBBVVVV",), tuple(faces))
    assert "do not close up" in check_pattern(ring).reason
    straight = replace(ring, vertices_coords=(*outer, (1, 1), (2, 1), (2, 2), (1, 2)))
    assert "close up" not in check_pattern(straight).reason


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"edges_vertices": ((0, 1), (1, 2), (2, 3), (3, 3))}, "Edge 3 joins vertex 3 with itself"),
        ({"edges_assignment": (*"BBBX",)}, "'X'"),
        ({"edges_assignment": (*"BBB",)}, "3 letters"),
        ({"edges_vertices": ((0, 1), (1, 2), (2, 3), (3, 9))}, "vertex 9"),
    ],
)
def test_a_pattern_that_cannot_be_read_says_why(changes, named):
    square = {
        "vertices_coords": ((0, 0), (1, 0), (1, 1), (0, 1)),
        "edges_vertices": ((0, 1), (1, 2), (2, 3), (3, 0)),
        "edges_assignment": (*"BBBB",),
    }
    with pytest.raises(ProgramError, match=named):
        CreasePattern(**{**square, **changes})


def folded_twice(first: float, second: float) -> Paper:
    """A strip's worth of creases: a fold across and a fold of the upper part, five or six faces."""
    paper = add_vertex(add_vertex(new_paper(), (4, 1), first), (3, 2), first + 0.1)
    paper = fold(paper, (5, 6), 1)
    paper = add_vertex(add_vertex(paper, (4, 3), second), (1, 2), second)
    return fold(paper, (7, 8), 1)


@pytest.mark.parametrize("paper", [folded_twice(0.5, 0.5), folded_twice(0.6, 0.3), folded_twice(0.3, 0.4)])
def test_the_number_of_orders_is_that_of_all_stacks_the_validators_accept(paper):
    assignments = dict(paper.edges())
    stacks = [replace(paper, order=stack) for stack in permutations(paper.order)]
    accepted = [p for p in stacks if dict(p.edges()) == assignments and not violations(p)]
    report = check_paper(paper)
    orders = {tuple(p.rank[x] < p.rank[y] for x, y in report.lying) for p in accepted}
    assert report.foldable
    assert report.states == len(orders)
    assert (True,) * len(report.lying) in orders


def test_a_found_stack_folds_the_paper_with_its_letters():
    paper = folded_twice(0.6, 0.3)
    stacked = replace(paper, order=check_paper(paper).stack)
    assert violations(stacked) == []
    assert dict(stacked.edges()) == dict(paper.edges())


@pytest.mark.parametrize("pattern", [grid(5, 1), grid(2, 3), grid(3, 3)])
def test_the_general_solver_decides_a_part_as_the_search_does(pattern):
    orders = Orders(conditions(lay_flat(pattern), 1e-4))
    assert solve(orders, orders.open_classes())
    assert not orders.open_classes()


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.sampled_from([0.4, 0.7, 1.0, 1.3]), min_size=2, max_size=6),
    st.text("MVU", min_size=1, max_size=5),
)
def test_a_part_is_decided_the_same_from_its_first_class_outwards(widths, letters):
    """Each class once, and a way is found where there is one, in whatever order classes are tried."""
    try:
        orders = Orders(conditions(lay_flat(grid(len(widths), 1, letters, tuple(widths))), 1e-4))
    except ContradictionError:
        return
    for part in parts(orders, orders.open_classes()):
        row, length = outwards(orders, part), len(orders.trail)
        assert sorted(row) == sorted(part)
        found = search_part(orders, row)
        orders.undo(length)
        assert search_part(orders, part) == found
        orders.undo(length)


def test_a_search_ends_when_it_has_done_as_much_as_it_may_and_leaves_the_orders_as_they_were():
    """What was tried and taken back counts as well."""
    pairs, opposite = frozenset({(0, 1), (0, 2), (1, 2)}), frozenset({((0, 1), (2, 0))})
    together = Conditions(3, pairs, (), opposite, frozenset(), cells=(1, 1, 1), reached=(0, 1, 2))
    orders = Orders(together)
    part = orders.open_classes()
    assert search_part(orders, part, effort=0) is None
    assert orders.open_classes() == part
    assert orders.work > 1
    assert search_part(orders, part) is not None


@pytest.mark.parametrize("decide", [first_order, lambda orders: solve(orders, orders.open_classes())])
def test_three_faces_of_one_cell_cannot_lie_in_a_circle(decide):
    circle = frozenset({((0, 1), (1, 2)), ((1, 2), (2, 0))})
    pairs = frozenset({(0, 1), (0, 2), (1, 2)})
    together = Conditions(3, pairs, (), circle, frozenset(), cells=(1, 1, 1), reached=(0, 1, 2))
    assert not decide(Orders(together))
    assert decide(Orders(replace(together, cells=(0b011, 0b101, 0b110))))


def test_a_long_panel_stays_out_of_a_short_fold_whatever_the_letters():
    report = check_pattern(grid(3, 1, "U", (1.0, 0.5, 1.0)))
    assert report.states == 2
    assert ((0, 1) in report.lying) == ((1, 2) in report.lying)


def test_counting_leaves_the_orders_as_they_were():
    orders = Orders(conditions(lay_flat(grid(4, 1)), 1e-4))
    before = (list(orders.over), list(orders.value))
    assert count_orders(orders, 100) == (16, False)
    assert (orders.over, orders.value) == before


def test_statements_that_contradict_each_other_have_no_solution():
    with pytest.raises(ContradictionError):
        equations([(0, 1), (0, 2)], [((0, 1), (0, 2)), ((0, 1), (2, 0))], [])
    with pytest.raises(ContradictionError):
        equations([(0, 1), (0, 2)], [((0, 1), (0, 2))], [((0, 1), (2, 0), (0, 1), (0, 1))])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 5))
@example(seed=289, folds=5).via("the first order found goes in a circle")
def test_what_was_folded_folds_flat_and_the_stack_found_is_one_the_validators_accept(seed, folds):
    paper = random_paper(seed, folds)
    report = check_paper(paper, cap=1)
    assert report.foldable
    if report.stack is None:
        assert not nx.is_directed_acyclic_graph(nx.DiGraph(report.lying))
        return
    first_up = not paper.back_up(min(paper.faces))
    stacked = replace(paper, order=report.stack if first_up else report.stack[::-1])
    assert violations(stacked) == []
    assert dict(stacked.edges()) == dict(paper.edges())


@pytest.mark.parametrize(("assignments", "stack"), [("VM", (0, 1, 2)), ("MV", (2, 1, 0))])
def test_a_pleat_too_thin_to_overlap_anything_goes_where_its_creases_say(assignments, stack):
    report = check_pattern(grid(3, 1, assignments, (0.5, 5e-5, 0.5)))
    assert (report.foldable, report.lying, report.stack) == (True, (), stack)
