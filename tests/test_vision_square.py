"""The flat square of the first photo is found below the pixel; anything else is refused in words."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from blackboard import BAND, BIRD, FLAT_TRIANGLE, TRIANGLE, Outline, board
from folding_server.errors import PhotoError
from folding_server.geometry.isometry import turn
from folding_server.simulator import flip, fold
from folding_server.simulator.paper import new_paper
from folding_server.vision.pose import pose_of
from folding_server.vision.square import find_square, squareness
from paths import EXAMPLES
from photographed import vertex_pixels
from reference import reference_files
from reference_data import REFERENCE
from vision_scenes import GRID, SIDE, Look, paint, read_rgb

PHOTOS = REFERENCE / "photos"
CORNERS = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]


@pytest.mark.parametrize("degrees", [0.0, 10.0, -30.0, 44.0])
def test_corners_are_found_below_the_pixel_and_numbered_with_the_least_turn(degrees: float) -> None:
    motion = turn(degrees, (0.5, 0.5))
    photo = paint(new_paper(), Look(), motion)
    pose = pose_of(find_square(photo, "Frame 1"))
    true = GRID.to_pixel([motion(c) for c in CORNERS])
    assert np.abs(np.array(pose.corners) - true).max() < 0.5


SEQUENCES = [
    *(pytest.param(EXAMPLES / name, id=name) for name in ("cat", "cup", "heart")),
    *reference_files("photos/rendered", "*"),
]


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_corners_of_photos_are_right_to_two_thirds_of_a_pixel(sequence: Path) -> None:
    frame = json.loads((sequence / "truth.json").read_text())["frames"][0]
    pose = pose_of(find_square(read_rgb(sequence / frame["image"]), "Frame 1"))
    true = np.array([vertex_pixels(frame)[str(v)] for v in (1, 2, 3, 4)]) - 0.5
    assert np.linalg.norm(np.array(pose.corners) - true, axis=1).max() < 0.7


def test_the_sheet_plane_and_the_photo_map_there_and_back() -> None:
    pose = pose_of(np.array([[30.0, 20.0], [190.0, 30.0], [200.0, 180.0], [25.0, 170.0]]))
    points = np.array([[0.0, 1.0], [0.3, 0.4], [1.2, -0.1]])
    assert np.allclose(pose.to_plane(pose.to_photo(points)), points)
    assert np.allclose(pose.to_photo([[0.0, 1.0]]), [[30.0, 20.0]], atol=1e-4)


def test_perspective_views_of_a_square_are_square_and_rectangles_are_not() -> None:
    assert squareness(np.array([[100, 100], [300, 100], [300, 300], [100, 300]], float), (400, 400)) < 1e-6
    assert squareness(np.array([[120, 120], [280, 120], [310, 300], [90, 300]], float), (400, 400)) < 0.1
    assert squareness(np.array([[50, 150], [350, 150], [350, 250], [50, 250]], float), (400, 400)) > 0.5


@pytest.mark.parametrize(
    ("outlines", "said"),
    [
        ((), "nothing stands out"),
        ((TRIANGLE,), "triangle"),
        ((FLAT_TRIANGLE,), "triangle"),
        (BAND, "corners"),
        (BIRD, "corners"),
    ],
    ids=["empty board", "triangle", "flat triangle", "band", "bird"],
)
def test_something_else_on_a_blackboard_is_refused_with_what_was_seen(
    outlines: tuple[Outline, ...], said: str
) -> None:
    with pytest.raises(PhotoError, match=said):
        find_square(board(*outlines), "Frame 1")


def test_a_disc_on_a_blackboard_is_refused_as_round() -> None:
    with pytest.raises(PhotoError, match="round"):
        find_square(board(round_sheet=115), "Frame 1")


@pytest.mark.reference("photos/blackboard")
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("Blank.jpg", "nothing stands out"),
        ("Circle.jpg", "round"),
        ("Correct1.jpg", "triangle"),
        ("Correct4.jpg", "triangle"),
        ("IMG_6368.jpg", "corners"),
        ("IMG_6374.jpg", "corners"),
    ],
)
def test_photos_of_something_else_are_refused_with_what_was_seen(name: str, said: str) -> None:
    with pytest.raises(PhotoError, match=said):
        find_square(read_rgb(PHOTOS / "blackboard" / name), "Frame 1")


def test_a_folded_sheet_is_no_start() -> None:
    folded = fold(new_paper(), (1, 3), 1)
    with pytest.raises(PhotoError, match="triangle"):
        find_square(paint(folded, Look()), "Frame 1")


def test_a_sheet_partly_out_of_the_picture_is_refused() -> None:
    photo = paint(new_paper(), Look())
    with pytest.raises(PhotoError, match="beyond the edge"):
        find_square(np.ascontiguousarray(photo[:, : SIDE // 2 + 30]), "Frame 1")


def test_a_rectangle_is_refused() -> None:
    photo = paint(new_paper((1.0, 0.6)), Look())
    with pytest.raises(PhotoError, match="no square"):
        find_square(photo, "Frame 1")


def test_a_hand_on_the_sheet_is_refused() -> None:
    photo = paint(new_paper(), Look())
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE // 2 + 20, SIDE // 2), (215, 165, 130), 50)
    with pytest.raises(PhotoError, match="hand"):
        find_square(photo, "Frame 1")


def test_a_mat_under_the_sheet_is_not_taken_for_it() -> None:
    photo = paint(new_paper(), Look(lamp=0.0))
    mat = np.full_like(photo, (150, 140, 90))
    y, x = np.abs(np.mgrid[-1 : 1 : SIDE * 1j, -1 : 1 : SIDE * 1j])
    framed = np.where(((x < 0.9) & (y < 0.65) & (np.maximum(x, y) > 0.51))[..., None], mat, photo)
    corners = find_square(framed, "Frame 1")
    assert abs(float(np.ptp(corners[:, 0])) - SIDE / 2) < 6


def test_the_back_up_start_is_found_like_any_other() -> None:
    turned = flip(new_paper(), "x")
    assert find_square(paint(turned, Look()), "Frame 1").shape == (4, 2)


def test_a_white_sheet_on_a_white_table_is_found_by_its_shadow() -> None:
    look = Look(front=(244, 242, 236), table=(236, 234, 229), lamp=0.1)
    shade = np.zeros((SIDE, SIDE), np.float32)
    shade[SIDE // 4 + 1 : 3 * SIDE // 4 + 1, SIDE // 4 + 1 : 3 * SIDE // 4 + 1] = 1
    shade[SIDE // 4 : 3 * SIDE // 4, SIDE // 4 : 3 * SIDE // 4] = 0
    rim = np.zeros((SIDE, SIDE), np.float32)
    cv2.rectangle(rim, (SIDE // 4, SIDE // 4), (3 * SIDE // 4 - 1, 3 * SIDE // 4 - 1), 1, 1)
    dark = cv2.GaussianBlur(np.maximum(shade, 0.35 * rim), (0, 0), 0.8)[..., None]
    photo = np.clip(paint(new_paper(), look) * (1 - 0.3 * dark), 0, 255).astype(np.uint8)
    corners = find_square(photo, "Frame 1")
    true = (np.array([[1, 1], [3, 1], [3, 3], [1, 3]]) * SIDE / 4) - 0.5
    assert max(np.linalg.norm(corners - corner, axis=1).min() for corner in true) < 3


def test_a_sheet_that_nothing_shows_is_refused_with_what_to_do() -> None:
    look = Look(front=(240, 240, 238), table=(240, 240, 238))
    with pytest.raises(PhotoError, match="lay the sheet on one of another colour"):
        find_square(paint(new_paper(), look), "Frame 1")
