"""The paper's outline is a polygon whose corners are right to a fraction of a pixel, and says what hides a side."""

import cv2
import numpy as np
import pytest
from folding_server.geometry.isometry import IDENTITY, Isometry, turn
from folding_server.simulator import add_vertex, fold
from folding_server.simulator.paper import Paper, new_paper
from folding_server.vision.outline import Outline
from folding_server.vision.seeing import see_sequence
from shapely import LineString, Polygon, unary_union
from vision_scenes import GRID, SIDE, Look, PhotoList, paint

PIXEL = 1 / GRID.pixels_per_unit
"""One pixel of a painted photo in sheet units."""


def corner_folded() -> Paper:
    """A corner folded in beyond the far side: the outline is not convex."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.3), (3, 4), 0.6)
    return fold(paper, (5, 6), 1)


def distances(outline: Outline, corners: list[tuple[float, float]]) -> list[float]:
    """How far each true corner is from the nearest that was found."""
    found = np.array(outline.corners)
    return [float(np.linalg.norm(found - corner, axis=1).min()) for corner in corners]


@pytest.mark.slow
@pytest.mark.parametrize("motion", [IDENTITY, turn(7.0, (0.5, 0.5)), turn(-33.0, (0.4, 0.5))])
def test_corners_are_where_the_sides_meet(motion: Isometry) -> None:
    triangle = fold(new_paper(), (1, 3), 1)
    photos = [paint(new_paper(), Look()), paint(triangle, Look(), motion, seed=1)]
    (outline,) = see_sequence(PhotoList(photos)).outlines(2)
    assert len(outline.corners) == 3
    assert all(outline.seen)
    assert max(distances(outline, [motion(p) for p in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))])) < 0.5 * PIXEL


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [-41.0, 5.5, 36.0])
def test_noise_makes_no_corner_on_a_straight_side(degrees: float) -> None:
    dark = Look(back=(58, 64, 71), table=(130, 135, 138))
    triangle, motion = fold(new_paper(), (1, 3), 1), turn(degrees, (0.5, 0.5))
    photos = [paint(new_paper(), dark), paint(triangle, dark, motion, seed=5)]
    (outline,) = see_sequence(PhotoList(photos)).outlines(2)
    assert len(outline.corners) == 3
    assert max(distances(outline, [motion(p) for p in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))])) < PIXEL


def test_an_outline_may_bend_inwards() -> None:
    folded = corner_folded()
    photos = [paint(new_paper(), Look()), paint(folded, Look(), seed=1)]
    (outline,) = see_sequence(PhotoList(photos)).outlines(2)
    points = np.array(outline.corners)
    x, y = points[:, 0], points[:, 1]
    hull = cv2.contourArea(cv2.convexHull(points.astype(np.float32)))
    assert abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2 < 0.99 * hull
    true = unary_union([Polygon(folded.polygon(f)).buffer(1e-6) for f in folded.order]).boundary
    found = LineString([*outline.corners, outline.corners[0]])
    places = [found.interpolate(at, normalized=True) for at in np.linspace(0, 1, 200)]
    assert float(np.median([true.distance(place) for place in places])) < 0.3 * PIXEL


def test_a_side_under_a_hand_is_not_seen() -> None:
    photo = paint(new_paper(), Look(), seed=2)
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE * 3 // 4 - 12, SIDE // 2), (205, 150, 115), 60)
    photos = [paint(new_paper(), Look()), paint(fold(new_paper(), (1, 3), 1), Look(), seed=1), photo]
    (outline,) = see_sequence(PhotoList(photos)).outlines(3)
    assert not all(outline.seen)
    assert outline.hidden == [side for side in range(len(outline.seen)) if not outline.seen[side]]
    assert max(distances(outline, [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)])) < 0.5 * PIXEL
