"""Transforms, graphs and planar faces of the geometry that every package uses."""

from math import cos, radians, sin

import networkx as nx
import numpy as np
import pytest
from folding_server.geometry.graph import component_of, components, edge_faces, sides, without_dead_ends
from folding_server.geometry.isometry import IDENTITY, Isometry, mirror, mirror_line, turn
from folding_server.geometry.line import Point, line_through
from folding_server.geometry.planar import boundary_cycles
from folding_server.geometry.point_batch import transformed
from folding_server.geometry.similarity import Similarity, turned_between
from hypothesis import given
from hypothesis import strategies as st

COORDINATES = st.floats(-3, 3)
POINTS = st.tuples(COORDINATES, COORDINATES)
ISOMETRIES = st.builds(
    lambda degrees, center, mirrored: turn(degrees, center).after(
        mirror(line_through((0, 0), (1, 2))) if mirrored else IDENTITY
    ),
    st.floats(-180, 180),
    POINTS,
    st.booleans(),
)


def scaling(scale: float, degrees: float) -> Similarity:
    """A scaling and a clockwise turn about the origin."""
    c, s = scale * cos(radians(degrees)), scale * sin(radians(degrees))
    return Similarity(c, s, -s, c, 0.0, 0.0)


SIMILARITIES = st.builds(
    lambda scale, degrees, isometry: scaling(scale, degrees).after(isometry),
    st.floats(0.2, 5),
    st.floats(-180, 180),
    ISOMETRIES,
)


@given(SIMILARITIES, POINTS)
def test_the_inverse_of_a_similarity_undoes_its_scale_too(motion: Similarity, point: Point):
    assert motion.inverse()(motion(point)) == pytest.approx(point, abs=1e-9)
    assert motion.inverse().scale == pytest.approx(1 / motion.scale)


@given(ISOMETRIES, SIMILARITIES)
def test_an_isometry_after_a_similarity_keeps_its_scale_and_its_type(isometry: Isometry, motion: Similarity):
    both = isometry.after(motion)
    assert type(both) is Similarity
    assert both.scale == pytest.approx(motion.scale)
    assert type(isometry.after(isometry)) is Isometry
    assert type(motion.after(isometry)) is Similarity


@given(ISOMETRIES)
def test_the_inverse_of_an_isometry_is_that_of_the_similarity_it_is(isometry: Isometry):
    assert type(isometry.inverse()) is Isometry
    assert isometry.inverse() == pytest.approx(Similarity(*isometry).inverse(), abs=1e-12)


@given(st.floats(-180, 180), POINTS)
def test_the_line_of_a_mirror_is_the_one_it_was_made_from(degrees: float, point: Point):
    line = line_through(point, (point[0] + cos(radians(degrees)), point[1] + sin(radians(degrees))))
    found = mirror_line(mirror(line))
    assert any(found == pytest.approx(way, abs=1e-6) for way in (line, line.opposite()))


@given(SIMILARITIES, st.lists(POINTS, min_size=1, max_size=4))
def test_many_points_go_where_each_goes(motion: Similarity, points: list[Point]):
    assert transformed(np.array(points), motion) == pytest.approx(
        np.array([motion(point) for point in points]), abs=1e-12
    )


@given(st.floats(-180, 180), st.floats(0.2, 5), ISOMETRIES)
def test_the_angle_between_similarities_is_that_of_the_turn(degrees: float, scale: float, isometry: Isometry):
    assert turned_between(IDENTITY, scaling(scale, degrees)) == pytest.approx(abs(degrees), abs=1e-5)
    assert turned_between(isometry, isometry) == 0


GRAPHS = st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12)), max_size=15)


@given(GRAPHS)
def test_components_are_those_that_networkx_finds(edges: list[tuple[int, int]]):
    graph = nx.Graph(edges)
    graph.add_nodes_from(range(13))
    found = components(range(13), edges)
    assert found == sorted(map(sorted, nx.connected_components(graph)))
    assert component_of(range(13), edges) == {node: part[0] for part in found for node in part}


def test_an_edge_lists_the_faces_beside_it_and_a_face_its_sides_from_its_first_vertex():
    assert list(sides((4, 1, 2))) == [(4, 1), (1, 2), (2, 4)]
    beside = edge_faces({7: (1, 2, 3), 9: (3, 2, 4)})
    assert beside[2, 3] == (7, 9)
    assert {edge for edge, faces in beside.items() if len(faces) == 1} == {(1, 2), (1, 3), (2, 4), (3, 4)}


def test_edges_that_end_nowhere_bound_no_face():
    square = [(0, 1), (1, 2), (2, 3), (0, 3)]
    whiskers = [(0, 4), (4, 5), (6, 7)]
    assert without_dead_ends([*whiskers, *square]) == square
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5), (0.6, 0.5), (2, 2), (3, 3)]
    assert boundary_cycles(corners, [*whiskers, *square], ()) == ((0, 1, 2, 3),)
