"""Creases that all meet in one vertex: decided by crimps as by the search for layers, named where they do not fold, and quick."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate
from math import atan2, cos, inf, pi, sin
from random import Random

import pytest
from folding_server.interchange.arrangement import arranged
from folding_server.interchange.drawn_line import DrawnLine
from folding_server.simulator.foldability import Counting, CreasePattern, check_pattern
from folding_server.simulator.foldability.big_little_big import big_little_big
from folding_server.simulator.foldability.classes import ContradictionError
from folding_server.simulator.foldability.constraints import conditions
from folding_server.simulator.foldability.equations import rows_of
from folding_server.simulator.foldability.flat_faces import lay_flat
from folding_server.simulator.foldability.orders import Orders
from folding_server.simulator.foldability.search import first_order
from folding_server.simulator.foldability.sectors import VertexSectors, sectors_around
from folding_server.simulator.foldability.single_vertex import layers_cross, sector_stack
from folding_server.simulator.foldability.single_vertex_pattern import single_vertex_order
from hypothesis import given, settings
from hypothesis import strategies as st

Point = tuple[float, float]
HALF = 200.0
CORNERS = ((-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF))
EQUAL = 1e-6
"""Radians: angles of these patterns are whole multiples of far more, or equal."""


def to_rim(at: Point, turn: float) -> Point:
    """Where a ray from a point of the sheet of 400 leaves it."""
    run = cos(turn), sin(turn)
    far = min(
        ((HALF if r > 0 else -HALF) - c) / r if abs(r) > 1e-12 else inf for c, r in zip(at, run, strict=True)
    )
    return at[0] + far * run[0], at[1] + far * run[1]


def rays(
    angles: Sequence[float], letters: Sequence[str], at: Point = (0.0, 0.0), first: float = 0.1
) -> CreasePattern:
    """Creases from vertex 0, with these angles from each to the next, in radians, the first in direction ``first``."""
    turns = [first + angle for angle in accumulate([0.0, *angles[: len(letters) - 1]])]
    vertices = [at, *(to_rim(at, turn) for turn in turns), *CORNERS]
    inner = max(map(abs, at)) < HALF
    outline = sorted(range(inner, len(vertices)), key=lambda v: atan2(vertices[v][1], vertices[v][0]))
    border = list(zip(outline, [*outline[1:], outline[0]], strict=True))
    spokes = [(0, k + 1) for k in range(len(letters))]
    return CreasePattern(tuple(vertices), (*spokes, *border), (*letters, *"B" * len(border)))


@st.composite
def around_a_vertex(draw: st.DrawFn) -> CreasePattern:
    """Angles of which the alternate ones add up to half a turn, few sizes among them, and letters that may fold."""
    half = draw(st.integers(2, 4))
    parts = [draw(st.lists(st.integers(1, 3), min_size=half, max_size=half)) for _ in range(2)]
    wholes = [sum(part) for part in parts]
    common = wholes[0] * wholes[1]
    angles = [pi * row[k] * (common // sum(row)) / common for k in range(half) for row in parts]
    mountains = draw(st.sampled_from([half - 1, half + 1]))
    letters = draw(st.permutations("M" * mountains + "V" * (2 * half - mountains)))
    free = draw(st.sets(st.integers(0, 2 * half - 1)))
    return rays(angles, "".join("U" if k in free else letter for k, letter in enumerate(letters)))


@st.composite
def on_an_edge(draw: st.DrawFn) -> CreasePattern:
    """Creases from a point of the sheet's edge."""
    parts = draw(st.lists(st.integers(1, 3), min_size=4, max_size=7))
    angles = [pi * part / sum(parts) for part in parts]
    letters = draw(st.text("MVU", min_size=len(parts) - 1, max_size=len(parts) - 1))
    return rays(angles[1:], letters, (-30.0, -200.0), angles[0])


def the_sectors(pattern: CreasePattern) -> VertexSectors:
    (around,) = sectors_around(pattern, 2)
    return around


def some_order(pattern: CreasePattern) -> bool:
    """Whether the search for layers, which knows nothing of vertices, finds an order."""
    try:
        return first_order(Orders(conditions(lay_flat(pattern), 1e-4)))
    except ContradictionError:
        return False


def holds(pattern: CreasePattern, stack: list[int]) -> bool:
    """Whether a stack of the faces meets all conditions on the layers that the search has to meet."""
    found = conditions(lay_flat(pattern), 1e-4)
    rank = {face: height for height, face in enumerate(stack)}

    def below(x: int, y: int) -> bool:
        return rank[x] < rank[y]

    known = all(below(x, y) for x, y in rows_of(found.known, 2).tolist())
    equal = all(below(a, b) == below(c, d) for a, b, c, d in rows_of(found.equal, 4).tolist())
    even = all(
        sum(below(row[k], row[k + 1]) for k in range(0, 8, 2)) % 2 == 0
        for row in rows_of(found.even, 8).tolist()
    )
    return known and equal and even


@settings(max_examples=60, deadline=None)
@given(st.one_of(around_a_vertex(), on_an_edge()))
def test_crimps_decide_as_the_search_for_layers_does(pattern: CreasePattern) -> None:
    around = the_sectors(pattern)
    stack = sector_stack(around, EQUAL)
    assert (stack is not None) == some_order(pattern)
    if stack is not None and len(pattern.cycles) == len(around.angles):
        assert not layers_cross(around, stack, EQUAL)
        faces = [around.corners[sector][0] for sector in stack]
        mirrored = lay_flat(pattern).mirrored[around.corners[0][0]]
        assert holds(pattern, faces[::-1] if mirrored else faces)


@settings(max_examples=40, deadline=None)
@given(around_a_vertex(), st.randoms(use_true_random=False))
def test_a_stack_whose_layers_cross_is_told_from_one_whose_layers_do_not(
    pattern: CreasePattern, random: Random
) -> None:
    """Any stack, letters aside: what crosses is what the conditions on layers forbid."""
    free = replace(pattern, edges_assignment=tuple("U" if a in "MV" else a for a in pattern.edges_assignment))
    around = the_sectors(free)
    stack = random.sample(range(len(around.angles)), len(around.angles))
    faces = [around.corners[sector][0] for sector in stack]
    assert layers_cross(around, stack, EQUAL) != holds(free, faces)


@pytest.mark.parametrize(
    ("degrees", "letters"),
    [([60, 20, 30, 60, 90, 100], "VMVVVM"), ([70, 80, 70, 50, 40, 50], "VMVVMV")],
)
def test_a_vertex_that_cannot_fold_alone_is_named_with_its_place(degrees: list[int], letters: str) -> None:
    """The smallest angle folds away, and leaves one that is smaller than those beside it between two valleys."""
    pattern = rays([degree * pi / 180 for degree in degrees], letters)
    report = check_pattern(pattern)
    assert not big_little_big(pattern)
    assert report.reason.startswith(
        "Single-vertex folding fails at vertex 0 at (0, 0): The 6 creases that meet here"
    )
    assert [(fault.kind, fault.vertices, fault.places) for fault in report.faults] == [
        ("Single-vertex folding", (0,), ((0.0, 0.0),))
    ]
    assert check_pattern(rays([degree * pi / 180 for degree in degrees], "U" * 6)).foldable


def test_a_crease_so_short_that_its_direction_is_uncertain_is_no_reason_to_refuse() -> None:
    """Read with such a short crease, angles of 30 and 135 degrees may be equal, and big-little-big would fail."""
    pattern = rays([pi / 4, pi / 6, pi * 3 / 4, pi * 5 / 6], "MVMM", (0.0, HALF - 0.047), pi / 2)
    assert big_little_big(pattern)
    assert check_pattern(pattern).foldable


def test_a_vertex_on_the_edge_of_the_sheet_is_named_too() -> None:
    pattern = rays([pi / 6, 0.0], "VV", (-30.0, -200.0), pi * 7 / 18)
    (fault,) = check_pattern(pattern).faults
    assert fault.places == ((-30.0, -200.0),)
    assert "at the edge of the sheet, 0 mountains and 2 valleys" in fault.detail
    assert check_pattern(rays([pi / 6, 0.0], "VM", (-30.0, -200.0), pi * 7 / 18)).foldable


@pytest.mark.slow
@pytest.mark.parametrize("letters", ["MM" + "VM" * 499, "U" * 1000], ids=["lettered", "without letters"])
@pytest.mark.parametrize("at", [(0.0, 0.0), (37.0, 61.0)], ids=["in the middle", "off centre"])
def test_a_thousand_creases_at_one_point_fold_flat(letters: str, at: Point) -> None:
    pattern = rays([2 * pi / 1000] * 1000, letters, at)
    report = check_pattern(pattern, counting=Counting(seconds=0.5))
    assert (report.foldable, report.states, report.capped) == (True, 1, "U" in letters)
    assert sorted(report.stack or ()) == list(range(1000))


def test_all_orders_of_a_thousand_creases_are_not_promised() -> None:
    """Mountains and valleys in another order leave more than one order of the layers, which is said."""
    letters = [*"M" * 101, *"V" * 99]
    Random(3).shuffle(letters)
    report = check_pattern(rays([pi / 100] * 200, "".join(letters)), counting=Counting(seconds=0.5))
    assert report.reason == "The pattern folds flat: at least 1 layer order."


def test_creases_from_the_edge_fold_flat_quickly() -> None:
    pattern = rays([pi / 1001] * 1000, "VM" * 500, (-30.0, -200.0), pi / 1001)
    report = check_pattern(pattern, counting=Counting(seconds=0.5))
    assert (report.foldable, report.states, report.capped) == (True, 1, False)


@pytest.mark.parametrize("letters", ["MM" + "VM" * 79, "VM" * 79 + "MM"])
def test_the_quick_order_is_that_of_the_search(letters: str) -> None:
    """160 creases: all of them are found one after the other, and the search for layers finds the same stack."""
    pattern = rays([pi / 80] * 160, letters)
    quick, searched = (
        check_pattern(pattern, counting=counting) for counting in (Counting(seconds=0.5), Counting(None))
    )
    assert (quick.stack, quick.lying, quick.states) == (searched.stack, searched.lying, searched.states)


def marked(marks: Sequence[tuple[Point, Point]], at: Point, letters: str) -> CreasePattern:
    """Creases from a point of a square sheet at equal angles, with marks."""
    turns = [0.1 + 2 * pi * k / len(letters) for k in range(len(letters))]
    creases = zip((to_rim(at, turn) for turn in turns), letters, strict=True)
    sides = zip(CORNERS, (*CORNERS[1:], CORNERS[0]), strict=True)
    return arranged(
        [DrawnLine(p, q, "B") for p, q in sides]
        + [DrawnLine(at, end, "M" if letter == "M" else "V") for end, letter in creases]
        + [DrawnLine(p, q, "F") for p, q in marks]
    )


MARKS = {
    "from the vertex": [((11.0, 7.0), (HALF, 60.0)), ((11.0, 7.0), (-HALF, HALF))],
    "across": [((-HALF, 40.0), (HALF, 90.0)), ((-100.0, -HALF), (-80.0, HALF))],
    "through the vertex": [((-HALF, 7.0), (HALF, 7.0))],
    "beside the creases": [((150.0, 191.0), (170.0, 199.0)), ((-HALF, -150.0), (HALF, -150.0))],
}


@pytest.mark.parametrize(
    "marks",
    [
        pytest.param(marks, id=name, marks=[pytest.mark.slow] * (name == "across"))
        for name, marks in MARKS.items()
    ],
)
def test_marks_do_not_change_how_creases_at_one_point_lie(marks: list[tuple[Point, Point]]) -> None:
    """The quick order meets every condition that the search for layers asks of the faces between the marks."""
    pattern = marked(marks, (11.0, 7.0), "MM" + "VM" * 79)
    flat = lay_flat(pattern)
    found = single_vertex_order(flat)
    assert found is not None
    assert len(pattern.cycles) > 160
    assert sorted(found.stack) == list(range(len(pattern.cycles)))
    assert holds(pattern, list(found.stack))
    searched = conditions(flat, 1e-4)
    assert {frozenset(pair) for pair in found.lying} == {frozenset(pair) for pair in searched.pairs.tolist()}


def test_a_crease_that_changes_its_letter_at_a_mark_is_not_one_crease() -> None:
    pattern = marked([((-HALF, 40.0), (HALF, 90.0))], (11.0, 7.0), "MM" + "VM" * 79)
    outer = max(
        (
            edge
            for edge, letter in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
            if letter == "M"
        ),
        key=lambda edge: min(pattern.vertices_coords[v][1] for v in edge),
    )
    changed = tuple(
        "V" if edge == outer else letter
        for edge, letter in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
    )
    assert single_vertex_order(lay_flat(pattern)) is not None
    assert single_vertex_order(lay_flat(replace(pattern, edges_assignment=changed))) is None


def test_a_face_that_reaches_out_of_its_sector_is_not_taken_for_a_sector() -> None:
    """A sheet with an arm that bends around: far from the vertex other layers meet than near it."""
    assert single_vertex_order(lay_flat(with_arm(()))) is not None
    assert single_vertex_order(lay_flat(with_arm(((-3, 0), (-3, 3), (0, 3), (0, 2.5), (-2.5, 2.5))))) is None


def with_arm(arm: tuple[Point, ...], creases: int = 150) -> CreasePattern:
    """Creases from a vertex on the edge to the rim of a half disc; ``arm`` goes on from the end of that edge."""
    rim = [(cos(0.9 * pi * k / creases), sin(0.9 * pi * k / creases)) for k in range(creases + 1)]
    vertices = [(0.0, 0.0), *rim, *reversed(((-1.0, 0.0), *arm))]
    outline = [(k, (k + 1) % len(vertices)) for k in range(len(vertices))]
    spokes = [(0, k + 1) for k in range(1, creases + 1)]
    return CreasePattern(tuple(vertices), (*outline, *spokes), (*"B" * len(outline), *"VM" * (creases // 2)))
