"""Models are mostly symmetrical: what was folded on one side is looked for where its mirror image lies on the other."""

from math import cos, pi, sin, sqrt

import numpy as np
from folding_schemas.actions import Action, AddVertex, Fold, Rotate, Unfold
from folding_server.simulator import new_paper, replay
from folding_server.vision.solver.lines import axes_of, landmark_lines
from folding_server.vision.solver.symmetry import mirrored, sheet_axes, symmetry_axes
from hypothesis import given
from hypothesis.strategies import floats

DIAGONAL: tuple[Action, ...] = (Rotate(angle=45), Fold(edge=(1, 3), direction=-1), Unfold())
ONE_SIDE: tuple[Action, ...] = (
    *DIAGONAL,
    AddVertex(edge=(3, 4), position=0.62),
    AddVertex(edge=(4, 1), position=0.23),
    Fold(edge=(5, 6), direction=-1),
)
"""A sheet creased along a diagonal, one corner beside it folded over along a line that no landmark gives."""


def lines(*rows: tuple[float, float]) -> np.ndarray:
    """Lines by the angle of their normal and their offset."""
    return np.array([(cos(angle), sin(angle), offset) for angle, offset in rows])


def is_among(line: np.ndarray, others: np.ndarray) -> bool:
    """Whether a line is one of the others, either side moving."""
    return bool(min(np.abs(others - line).max(axis=1).min(), np.abs(others + line).max(axis=1).min()) < 1e-6)


@given(floats(0, pi), floats(-1, 1), floats(0, pi), floats(-1, 1))
def test_mirrored_twice_a_line_is_itself(angle: float, offset: float, about: float, at: float) -> None:
    line, axis = lines((angle, offset)), lines((about, at))
    assert np.allclose(mirrored(mirrored(line, axis), axis), line)


@given(floats(0, pi), floats(-1, 1), floats(0, pi), floats(-1, 1), floats(-2, 2))
def test_the_mirror_image_of_a_line_holds_those_of_its_points(
    angle: float, offset: float, about: float, at: float, along: float
) -> None:
    (nx, ny, k), (ax, ay, c) = lines((angle, offset))[0], lines((about, at))[0]
    point = np.array([nx * k - ny * along, ny * k + nx * along])
    image = point - 2 * (ax * point[0] + ay * point[1] - c) * np.array([ax, ay])
    mx, my, m = mirrored(lines((angle, offset)), lines((about, at)))[0]
    assert abs(mx * image[0] + my * image[1] - m) < 1e-9


def test_a_crease_along_a_diagonal_of_the_sheet_is_an_axis_wherever_it_lies() -> None:
    axes = sheet_axes(replay(DIAGONAL))
    assert len(axes) == 1
    assert is_among(axes[0], lines((0.0, 0.5)))
    assert len(sheet_axes(new_paper())) == 0


def test_most_points_need_partners() -> None:
    kite = np.array([(0.0, 0.0), (0.4, 0.7), (-0.4, 0.7), (0.0, 1.0), (0.2, 0.4), (-0.2, 0.4)])
    upright, lying = lines((0.0, 0.0), (pi / 2, 0.5))
    assert symmetry_axes(kite, np.array([lying, upright])).tolist() == [upright.tolist()]


def test_a_square_is_symmetrical_about_its_middles_and_its_diagonals() -> None:
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)])
    candidates = lines((0.0, 0.5), (pi / 2, 0.5), (pi / 4, sqrt(0.5)), (3 * pi / 4, 0.0), (pi / 3, 0.6))
    assert {tuple(axis) for axis in symmetry_axes(corners, candidates).tolist()} == {
        tuple(axis) for axis in candidates[:4].tolist()
    }


def test_where_one_side_was_folded_the_same_on_the_other_is_a_landmark() -> None:
    paper = replay(ONE_SIDE)
    (ux, uy), (vx, vy) = (paper.folded_vertices_coords[v] for v in (5, 6))
    length = np.hypot(vx - ux, vy - uy)
    nx, ny = -(vy - uy) / length, (vx - ux) / length
    crease = np.array([(nx, ny, nx * ux + ny * uy)])
    assert len(axes_of(paper)) >= 1
    assert is_among(mirrored(crease, lines((0.0, 0.5)))[0], landmark_lines(paper))
