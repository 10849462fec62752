"""What lies near what, found for many faces and edges at once: as each pair by itself says."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
import shapely
from folding_server.geometry.planar import all_crossings
from folding_server.simulator.foldability.constraints import Contacts
from folding_server.simulator.foldability.flat_faces import lay_flat
from folding_server.simulator.foldability.near_contacts import HALVINGS
from folding_server.simulator.foldability.pair_table import PairTable
from folding_server.simulator.foldability.pattern import pattern_of
from folding_server.simulator.foldability.tolerances import first_tolerance
from folding_server.simulator.validity.half_planes import half_planes, lengths_inside
from hypothesis import given, settings
from hypothesis import strategies as st
from papers import random_paper

POINTS = st.tuples(st.integers(0, 4), st.integers(0, 4))
Crossing = tuple[int, int]


def _side(a: tuple[int, int], b: tuple[int, int], p: tuple[int, int]) -> int:
    found = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    return (found > 0) - (found < 0)


def _meet(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int], d: tuple[int, int]) -> bool:
    """Whether two segments have a point in common, in whole numbers."""
    turns = _side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b)
    if any(turns):
        return turns[0] * turns[1] <= 0 and turns[2] * turns[3] <= 0
    return all(max(min(a[k], b[k]), min(c[k], d[k])) <= min(max(a[k], b[k]), max(c[k], d[k])) for k in (0, 1))


def _meet_elsewhere(points: list[tuple[int, int]], first: Crossing, second: Crossing) -> bool:
    """Whether two edges meet elsewhere than in a common vertex."""
    common = set(first) & set(second)
    if not common:
        return _meet(*(points[v] for v in (*first, *second)))
    if len(common) == 2:
        return True
    (v,) = common
    here = points[v]
    a, b = (points[w] for w in {*first, *second} - {v})
    ahead = (a[0] - here[0]) * (b[0] - here[0]) + (a[1] - here[1]) * (b[1] - here[1])
    return _side(here, a, b) == 0 and ahead > 0


@given(st.lists(POINTS, min_size=2, max_size=9), st.data())
@settings(max_examples=150)
def test_edges_that_meet_elsewhere_than_in_a_vertex_are_those_of_which_each_two_do(points, data):
    vertex = st.integers(0, len(points) - 1)
    edges = data.draw(
        st.lists(st.tuples(vertex, vertex).filter(lambda e: points[e[0]] != points[e[1]]), max_size=14)
    )
    pairs = combinations(range(len(edges)), 2)
    assert all_crossings(points, edges) == [
        (i, j) for i, j in pairs if _meet_elsewhere(points, edges[i], edges[j])
    ]


@pytest.mark.parametrize("order", [1, -1], ids=["coarse first", "fine first"])
@pytest.mark.parametrize("seed", [2, 8, 10, 15])
def test_contacts_at_a_finer_tolerance_are_the_same_whether_looked_up_before_or_not(seed, order):
    flat = lay_flat(pattern_of(random_paper(seed, 7)))
    finest = first_tolerance(flat)
    row = [Contacts(flat, finest * 2**HALVINGS)]
    for tolerance in (finest * 32, finest * 16, finest):
        row.append(Contacts(flat, tolerance, row[-1]))
    for contacts in row[::order]:
        alone = Contacts(flat, contacts.tolerance)
        assert alone.size > (0, 0, 0)
        for kind in ("pairs", "known", "equal", "even"):
            found, expected = (np.unique(getattr(each, kind), axis=0) for each in (contacts, alone))
            assert found.tolist() == expected.tolist()


@given(st.sets(st.tuples(st.integers(0, 20), st.integers(0, 20)).filter(lambda pair: pair[0] < pair[1])))
def test_pairs_are_found_in_the_table_and_in_the_list_of_many_faces(pairs):
    rows = np.array(sorted(pairs), int).reshape(-1, 2)
    x, y = np.divmod(np.arange(21 * 21), 21)
    expected = [(min(i, j), max(i, j)) in pairs for i, j in zip(x.tolist(), y.tolist(), strict=True)]
    for faces in (21, 40_000):
        assert PairTable(rows, faces).has(x, y).tolist() == expected


COORDINATES = st.integers(-40, 40).map(lambda whole: float(Fraction(whole, 20)))
PLACES = st.tuples(COORDINATES, COORDINATES)


@given(st.lists(PLACES, min_size=3, max_size=9), st.lists(st.tuples(PLACES, PLACES), min_size=1, max_size=12))
@settings(max_examples=60)
def test_as_much_of_a_segment_lies_in_a_convex_face_as_shapely_says(corners, segments):
    outline = shapely.MultiPoint(corners).convex_hull
    triangle = shapely.Polygon([(-1, -1), (1, -1), (0, 1)])
    outlines = np.array([triangle, outline if outline.geom_type == "Polygon" else triangle])
    ends = np.array(segments, float)
    for face in (0, 1):
        inside = lengths_inside(ends, np.full(len(ends), face), half_planes(outlines), 0.01)
        core = shapely.buffer(outlines[face], -0.01, join_style="mitre", mitre_limit=1000)
        assert inside == pytest.approx(
            shapely.length(shapely.intersection(shapely.linestrings(ends), core)), abs=1e-6
        )
