"""Photos become label images: colours found, hands left out, outlines right, light allowed for."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from blackboard import BAND, FLAT_TRIANGLE, SQUARE, TRIANGLE, Outline, board, covered
from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.geometry.isometry import IDENTITY, Isometry, turn
from folding_server.simulator import add_vertex, fold
from folding_server.simulator.paper import Paper, new_paper
from folding_server.vision.grid import Grid, grid_over
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, LabelImage, as_one_colour, is_paper
from folding_server.vision.seeing import SequenceObserver, see_sequence
from paper_drawings import label_image, label_polygons, shares
from papers import states
from paths import EXAMPLES
from photographed import SAILBOAT, vertex_pixels
from reference_data import REFERENCE
from vision_scenes import GRID, SIDE, Look, PhotoList, paint, read_rgb, share_right

PHOTOS = REFERENCE / "photos"
MASKS = json.loads((Path(__file__).parent / "data" / "blackboard_masks.json").read_text())["outlines"]


def triangle() -> Paper:
    """The sheet with its upper right half folded over."""
    return fold(new_paper(), (1, 3), 1)


def half_turned_back() -> Paper:
    """Front and back both show: a corner folded to the centre line."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.4), (2, 3), 0.7)
    return fold(paper, (5, 6), 1)


def two_photos(look: Look, **declared: str) -> PhotoList:
    return PhotoList([paint(new_paper(), look), paint(half_turned_back(), look, seed=1)], **declared)


@pytest.mark.slow
@pytest.mark.parametrize(
    "look",
    [
        Look(),
        Look(front=(30, 90, 160), back=(245, 245, 245), table=(150, 120, 90)),
        Look(front=(252, 252, 250), back=(240, 200, 60), table=(228, 230, 233), lamp=0.1),
        Look(front=(240, 190, 60), back=(60, 62, 66), table=(125, 130, 135)),
    ],
)
def test_undeclared_colours_are_found(look: Look) -> None:
    seen = see_sequence(two_photos(look)).frame(2, 90)
    assert seen.two_coloured
    assert share_right(seen.labels, label_image(half_turned_back(), seen.grid)) > 0.985


def test_declared_colours_may_be_far_off() -> None:
    observer = see_sequence(two_photos(Look(back=(150, 50, 60)), front_color="white", back_color="orange"))
    seen = observer.frame(2, 90)
    assert share_right(seen.labels, label_image(half_turned_back(), seen.grid)) > 0.985


def test_an_unknown_colour_name_is_refused() -> None:
    with pytest.raises(PhotoError, match="reddish-blue"):
        see_sequence(two_photos(Look(), front_color="white", back_color="reddish-blue"))


def test_sides_that_look_alike_give_one_class_of_paper() -> None:
    look = Look(back=(240, 235, 220))
    seen = see_sequence(two_photos(look, front_color="white", back_color="white")).frame(2, 90)
    assert not seen.two_coloured
    assert not (seen.labels == BACK).any()
    assert share_right(seen.labels, as_one_colour(label_image(half_turned_back(), seen.grid))) > 0.985


def test_hand_and_sleeve_are_unknown_and_the_paper_around_them_is_right() -> None:
    look = Look()
    photo = paint(triangle(), look)
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE // 2, SIDE // 2 + 30), (205, 150, 115), 40)
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE - 60, SIDE // 2 + 10), (40, 60, 130), 46)
    observer = see_sequence(PhotoList([paint(new_paper(), look), paint(triangle(), look, seed=2), photo]))
    seen = observer.frame(3, 90)
    place = seen.grid.to_pixel([[0.62, 0.4], [1.35, 0.48]]).round().astype(int)
    assert all(seen.labels[row, column] == UNKNOWN for column, row in place)
    truth = label_image(triangle(), seen.grid)
    assert share_right(seen.labels, truth) > 0.98
    assert (is_paper(truth) & (seen.labels == UNKNOWN)).sum() < 0.35 * is_paper(truth).sum()


def test_a_sleeve_of_the_papers_colour_is_no_paper() -> None:
    look = Look()
    photo = paint(triangle(), look)
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE // 2, SIDE // 2 + 30), (205, 150, 115), 40)
    cv2.line(photo, (SIDE, SIDE // 2), (SIDE - 60, SIDE // 2 + 10), look.back, 60)
    observer = see_sequence(PhotoList([paint(new_paper(), look), paint(triangle(), look, seed=2), photo]))
    seen = observer.frame(3, 90)
    column, row = seen.grid.to_pixel([1.42, 0.48]).round().astype(int)
    assert seen.labels[row, column] == UNKNOWN
    assert share_right(seen.labels, label_image(triangle(), seen.grid)) > 0.98


def test_what_the_photo_does_not_cover_is_unknown() -> None:
    seen = see_sequence(two_photos(Look())).frame(1, 64)
    assert seen.labels[0, 0] == UNKNOWN
    assert seen.confidence[0, 0] == 0
    assert seen.labels.shape == seen.rgb.shape[:2] == seen.edges.shape == (seen.grid.rows, seen.grid.cols)


def test_a_shadow_on_the_table_is_table() -> None:
    look = Look(table=(150, 150, 155))
    photo = paint(triangle(), look).astype(np.float32)
    shadow = np.ones((SIDE, SIDE), np.float32)
    cv2.rectangle(shadow, (230, 60), (330, 160), 0.6, cv2.FILLED)
    photo *= cv2.GaussianBlur(shadow, (0, 0), 8)[..., None]
    observer = see_sequence(
        PhotoList([paint(new_paper(), look), paint(triangle(), look), photo.astype(np.uint8)])
    )
    seen = observer.frame(3, 90)
    column, row = seen.grid.to_pixel([1.05, 0.9]).round().astype(int)
    assert seen.labels[row, column] == BACKGROUND
    assert share_right(seen.labels, label_image(triangle(), seen.grid)) > 0.985


def test_frames_are_the_same_each_time_and_remembered() -> None:
    photos = two_photos(Look())
    observer = see_sequence(photos)
    assert observer.frame(2, 64) is observer.frame(2, 64)
    assert np.array_equal(observer.frame(2, 64).labels, see_sequence(photos).frame(2, 64).labels)


def test_a_frame_that_does_not_exist_is_refused() -> None:
    with pytest.raises(PhotoError, match="99"):
        see_sequence(two_photos(Look())).frame(99)


def test_a_crease_shows_among_the_inner_lines() -> None:
    photo = paint(new_paper(), Look())
    photo[SIDE // 2, SIDE // 4 : 3 * SIDE // 4] -= 30
    seen = see_sequence(PhotoList([paint(new_paper(), Look()), photo])).frame(2, 90)
    on = seen.grid.to_pixel([[x, 0.5] for x in np.linspace(0.1, 0.9, 20)]).round().astype(int)
    off = seen.grid.to_pixel([[x, 0.3] for x in np.linspace(0.1, 0.9, 20)]).round().astype(int)
    assert np.median(seen.edges[on[:, 1], on[:, 0]]) > 3 * np.median(seen.edges[off[:, 1], off[:, 0]]) + 0.2


@pytest.mark.slow
@pytest.mark.parametrize(("name", "frames"), [("cat", (1, 3, 5, 9)), ("heart", (2, 7, 16))])
def test_photos_of_the_examples_are_labelled_right(name: str, frames: tuple[int, ...]) -> None:
    assert_labelled_right(EXAMPLES / name, frames)


@pytest.mark.slow
@pytest.mark.reference("photos/rendered")
@pytest.mark.parametrize(
    ("name", "frames"),
    [
        ("how_to_make_an_easy_origami_tulip_stem", (1, 3, 5, 6, 9)),
        ("very_easy_origami_sloth_instructions", (2, 5, 7, 16)),
    ],
)
def test_ray_traced_photos_are_labelled_right(name: str, frames: tuple[int, ...]) -> None:
    assert_labelled_right(PHOTOS / "rendered" / name, frames)


def assert_labelled_right(folder: Path, frames: tuple[int, ...]) -> None:
    observer = see_sequence(load_sequence(folder))
    truth = json.loads((folder / "truth.json").read_text())["frames"]
    for frame in frames:
        seen = observer.frame(frame, 160)
        assert share_right(seen.labels, drawn_truth(truth[frame - 1], observer, seen.grid)) > 0.97
        assert (seen.labels == UNKNOWN)[100:300, 100:300].mean() < 0.25


def drawn_truth(frame: dict[str, Any], observer: SequenceObserver, grid: Grid) -> LabelImage:
    pixels = vertex_pixels(frame)
    places = dict(
        zip(pixels, observer.pose.to_plane(np.array(list(pixels.values())) - 0.5).tolist(), strict=True)
    )
    polygons = [[tuple(places[str(v)]) for v in frame["faces"][str(f)]] for f in frame["order"]]
    return label_polygons(polygons, [bool(frame["orientations"][str(f)]) for f in frame["order"]], grid)


@pytest.mark.slow
@pytest.mark.parametrize(
    "outlines",
    [(SQUARE,), (TRIANGLE,), (FLAT_TRIANGLE,), BAND],
    ids=["square", "triangle", "flat triangle", "band"],
)
def test_paper_on_a_blackboard_matches_what_was_drawn(outlines: tuple[Outline, ...]) -> None:
    observer = see_sequence(PhotoList([board(SQUARE), board(*outlines, seed=1)]))
    seen = observer.frame(2, 160)
    drawn, _ = observer.pose.rectify(covered(*outlines), seen.grid)
    true, paper = drawn[..., 0] > 127, is_paper(seen.labels)
    assert (true & paper).sum() / (true | paper).sum() >= 0.97


@pytest.mark.slow
@pytest.mark.reference("photos/blackboard")
@pytest.mark.parametrize("name", sorted(MASKS))
def test_phone_photos_on_a_blackboard_match_outlines_drawn_by_eye(name: str) -> None:
    photos = PhotoList([read_rgb(PHOTOS / "blackboard" / n) for n in ("IMG_6365.jpg", name)])
    observer = see_sequence(photos)
    seen = observer.frame(2, 160)
    fine = grid_over(160 * 4)
    outline = fine.to_pixel(observer.pose.to_plane(np.array(MASKS[name]) - 0.5))
    mask = np.zeros((fine.rows, fine.cols), np.uint8)
    cv2.fillPoly(mask, [np.rint(outline * 16).astype(np.int32)], 1, cv2.LINE_8, 4)
    true, paper = mask[2::4, 2::4] > 0, is_paper(seen.labels)
    assert (true & paper).sum() / (true | paper).sum() >= 0.97


@pytest.mark.slow
def test_a_sailboat_is_seen_in_two_colours_by_a_moving_camera() -> None:
    look = Look(front=(207, 200, 188), back=(47, 155, 193), table=(60, 60, 66), lamp=0.0)
    zooms = (1.0, 0.95, 1.05, 0.97)
    papers = states(SAILBOAT)
    taken = [zoomed(paint(paper, look, seed=k), zooms[k]) for k, paper in enumerate(papers)]
    assert_seen_by_a_moving_camera(see_sequence(PhotoList(taken, "#cfc8bc", "#2f9bc1")))


@pytest.mark.reference("photos/sailboat")
def test_a_sailboat_of_real_photos_is_seen_in_two_colours_by_a_moving_camera() -> None:
    assert_seen_by_a_moving_camera(see_sequence(load_sequence(PHOTOS / "sailboat")))


def zoomed(photo: RgbImage, zoom: float) -> RgbImage:
    """A photo as from another distance and a little beside."""
    away = (1 - zoom) * SIDE / 2
    motion = np.array([[zoom, 0, away + 12], [0, zoom, away - 9]])
    return cv2.warpAffine(photo, motion, photo.shape[1::-1], borderMode=cv2.BORDER_REFLECT)


def assert_seen_by_a_moving_camera(observer: SequenceObserver) -> None:
    assert observer.scales[0] < 1 < observer.scales[1]
    shares = []
    for frame in range(1, 5):
        seen = observer.frame(frame, 100)
        paper = is_paper(seen.labels).sum()
        shares.append((seen.labels == BACK).sum() / paper)
        assert paper > 3000
    assert shares[0] < 0.01
    assert shares[1] > 0.98
    assert 0.1 < shares[2] < 0.3
    assert 0.4 < shares[3] < 0.7


def test_a_sheet_that_drifts_under_a_standing_camera_keeps_its_scale() -> None:
    rng = np.random.default_rng(5)
    grain = rng.normal(0, 9, (SIDE // 2, SIDE // 2, 1)).repeat(2, axis=0).repeat(2, axis=1)
    photos = []
    for degrees in (0.0, 4.0, -3.0):
        photo = paint(new_paper(), Look(), turn(degrees, (0.5, 0.5))).astype(np.float32)
        table = photo.mean(axis=-1, keepdims=True) < 120
        photos.append(np.clip(photo + table * grain, 0, 255).astype(np.uint8))
    assert see_sequence(PhotoList(photos)).scales == (1.0, 1.0)
    assert FRONT in see_sequence(PhotoList(photos)).frame(2, 64).labels


def on_a_mat(paper: Paper, motion: Isometry, seed: int) -> RgbImage:
    """The paper on a dark mat with a few light lines, which run on below it."""
    look = Look(front=(190, 40, 40), back=(244, 244, 238), table=(60, 61, 64), lamp=0.0)
    lines = np.zeros((SIDE, SIDE), np.float32)
    for i in range(0, SIDE, SIDE // 6):
        cv2.line(lines, (0, i), (SIDE, i), 1.0, 3)
        cv2.line(lines, (i, 0), (i, SIDE), 1.0, 3)
    bare = cv2.GaussianBlur(np.asarray(shares(paper, GRID, motion)[0], np.float32) * lines, (0, 0), 0.7)
    return np.clip(paint(paper, look, motion, seed) + 45.0 * bare[..., None], 0, 255).astype(np.uint8)


@pytest.mark.parametrize("aside", [0.016, 0.024, -0.02])
def test_lines_of_a_mat_go_on_where_the_sheet_lay_first(aside: float) -> None:
    """A pale line beside the pale paper is no paper in shadow, though the first photo did not show it."""
    half = fold(add_vertex(add_vertex(new_paper(), (1, 4), 0.5), (2, 3), 0.5), (5, 6), -1)
    beside = Isometry(1, 0, 0, 1, 0.0, aside)
    photos = PhotoList([on_a_mat(new_paper(), IDENTITY, 0), on_a_mat(half, beside, 1)])
    seen = see_sequence(photos).frame(2, 160)
    assert share_right(seen.labels, label_image(half, seen.grid, beside)) > 0.99
