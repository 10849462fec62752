"""Photos that tell little are told as such, with the number that says so; nothing is a match with them."""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from folding_server.arrays import Floats, RgbImage
from folding_server.errors import PhotoError
from folding_server.simulator import fold
from folding_server.simulator.paper import new_paper
from folding_server.vision.comparison import compare
from folding_server.vision.photo_doubts import PhotoDoubts, doubts_about, doubts_about_start, without_match
from folding_server.vision.seeing import see_sequence
from folding_server.vision.sharpness import PixelSide, edge_width
from folding_server.vision.square import look_for_square
from hosts import data_of, in_memory, text_of
from pictures import write_image, write_manifest
from PIL import Image, ImageDraw
from reference_data import REFERENCE
from vision_scenes import SIDE, Look, PhotoList, paint, read_rgb

LOOK = Look()
SHEET = SIDE / 2
"""Pixels of the painted sheet's side."""
CORNERS: Floats = SIDE * np.array([[1.0, 1], [3, 1], [3, 3], [1, 3], [1, 1]]) / 4 - 0.5
SIDES: list[PixelSide] = list(pairwise(CORNERS))


def blurred(photo: RgbImage, width: float) -> RgbImage:
    """The photo with edges so wide, in sheet sides: 2.5 deviations of a Gaussian."""
    return np.asarray(cv2.GaussianBlur(photo, (0, 0), width * SHEET / np.sqrt(2 * np.pi)), np.uint8)


def darkened(photo: RgbImage, part: float) -> RgbImage:
    """The photo with so much of its light."""
    return np.clip(photo * part, 0, 255).astype(np.uint8)


def far_away(side: int, size: tuple[int, int] = (2000, 1500)) -> RgbImage:
    """A sheet so many pixels wide on a table of a size (width, height)."""
    table = np.random.default_rng(1).normal(LOOK.table, 2.0, (size[1], size[0], 3))
    near = paint(new_paper(), Look(lamp=0.0))
    small = cv2.resize(near, (2 * side, 2 * side), interpolation=cv2.INTER_AREA)
    table[300 : 300 + 2 * side, 500 : 500 + 2 * side] = small
    return np.clip(table, 0, 255).astype(np.uint8)


def doubts(second: RgbImage) -> PhotoDoubts:
    """What is said about a photo of the diagonal fold."""
    observer = see_sequence(PhotoList([paint(new_paper(), LOOK), second]))
    return doubts_about(observer, 2, observer.outlines(2))


@pytest.fixture(scope="module")
def triangle() -> RgbImage:
    """A photo of the sheet folded along its diagonal."""
    return paint(fold(new_paper(), (1, 3), 1), LOOK, seed=1)


@pytest.mark.parametrize("width", [0.02, 0.04, 0.08])
def test_the_width_of_a_painted_edge_is_measured(width: float) -> None:
    rgb = blurred(paint(new_paper(), Look(lamp=0.0)), width)
    assert edge_width(rgb, SIDES, SHEET) == pytest.approx(width, rel=0.2)


def test_a_soft_shadow_beside_a_sharp_edge_is_no_blur() -> None:
    low, high = SIDE // 4, 3 * SIDE // 4
    shade = np.zeros((SIDE, SIDE))
    shade[low + 6 : high + 6, low + 6 : high + 6] = 0.5
    shade = cv2.GaussianBlur(shade, (0, 0), 5.0)
    shade[low:high, low:high] = 0
    lit = np.clip(paint(new_paper(), Look(lamp=0.0)) * (1 - shade[..., None]), 0, 255).astype(np.uint8)
    width = edge_width(lit, SIDES, SHEET)
    assert width is not None
    assert width < 0.02


def test_a_photo_that_is_moved_counts_as_wide_as_its_blurred_edges() -> None:
    moved = np.asarray(cv2.blur(paint(new_paper(), Look(lamp=0.0)), (13, 1)), np.uint8)
    width = edge_width(moved, SIDES, SHEET)
    assert width is not None
    assert width * SHEET == pytest.approx(13, rel=0.2)


def test_a_sharp_and_bright_photo_is_not_doubted(triangle: RgbImage) -> None:
    assert doubts(triangle) == PhotoDoubts()


def test_a_blurred_photo_is_doubted_with_the_width_of_its_edges(triangle: RgbImage) -> None:
    (said,) = doubts(blurred(triangle, 0.05)).spoils
    assert said.startswith("the photo of frame 2 is blurred: the paper's edges are 0.0")
    assert float(said.split("edges are ")[1].split()[0]) == pytest.approx(0.05, rel=0.25)
    assert said.endswith("hold the camera still and focus on the paper")


def test_a_dark_photo_is_doubted_with_its_brightness(triangle: RgbImage) -> None:
    (said,) = doubts(darkened(triangle, 0.15)).spoils
    level = float(np.quantile(darkened(triangle, 0.15).max(axis=2), 0.99))
    assert f"frame 2 is too dark: its brightest hundredth has {level:.0f} of 255, and 50 are needed" in said


def test_a_sheet_far_away_is_found_and_doubted_with_its_size() -> None:
    (said,) = doubts_about_start(PhotoList([far_away(139)])).spoils
    assert "the sheet is 139 pixels wide in a photo of 2,000: come closer" in said


def test_a_sheet_too_far_away_to_be_read_is_refused_with_its_size() -> None:
    with pytest.raises(PhotoError, match=r"the sheet is 3\d pixels wide in a photo of 1,000: come closer"):
        look_for_square(far_away(36, (1000, 750)), "Frame 1")


def test_nothing_is_a_match_with_a_photo_that_is_spoilt(triangle: RgbImage) -> None:
    observer = see_sequence(PhotoList([paint(new_paper(), LOOK), triangle]))
    match = compare(fold(new_paper(), (1, 3), 1), observer.frame(2))
    assert without_match(match, PhotoDoubts(remarks=("two squares",))).verdict == "MATCH"
    assert without_match(match, PhotoDoubts(spoils=("too dark",))).verdict == "MISMATCH"


def test_of_two_squares_the_larger_is_the_sheet_and_the_other_is_told() -> None:
    photo = paint(new_paper(), LOOK)
    photo[20:66, 20:66] = LOOK.front
    found = look_for_square(photo, "Frame 1")
    assert found.side == pytest.approx(SHEET, abs=2)
    assert found.others == (pytest.approx(46, abs=2),)
    (said,) = doubts_about_start(PhotoList([photo])).remarks
    assert "2 squares: the largest, 180 pixels wide, is taken" in said


def test_a_square_many_times_smaller_than_a_folded_sheet_is_not_taken_for_it(triangle: RgbImage) -> None:
    photo = triangle.copy()
    photo[300:330, 300:330] = LOOK.front
    with pytest.raises(PhotoError, match="a triangle, a sheet that is folded already"):
        look_for_square(cv2.resize(photo, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC), "Frame 1")


def test_a_sheet_cut_by_an_edge_is_refused_with_the_edge() -> None:
    photo = np.ascontiguousarray(paint(new_paper(), LOOK)[:, : SIDE // 2 + 30])
    with pytest.raises(PhotoError, match=r"beyond the edge of the picture \(right\): move the camera"):
        look_for_square(photo, "Frame 1")


def test_a_sheet_folded_in_half_is_no_start() -> None:
    photo = paint(new_paper((1.0, 0.5)), LOOK)
    with pytest.raises(
        PhotoError, match="as a sheet folded in half is: begin with a photo of the flat sheet"
    ):
        look_for_square(photo, "Frame 1")


def drawing(*, folded: bool) -> RgbImage:
    """A step of a diagram: the outline of a sheet with its diagonal, and an arrow."""
    page = Image.new("RGB", (600, 600), "white")
    pen = ImageDraw.Draw(page)
    corners = [(150, 150), (450, 150), (450, 450), (150, 450)]
    pen.polygon(corners[1:] if folded else corners, outline="black", width=3)
    pen.line([corners[1], corners[3]], fill="black", width=2)
    pen.arc((220, 220, 380, 380), 120, 300, fill="black", width=2)
    return np.asarray(page)


def test_a_drawing_is_told_from_a_photo() -> None:
    with pytest.raises(PhotoError, match="it looks like a drawing: 9.% of it is perfectly even"):
        look_for_square(drawing(folded=True), "Frame 1")
    said = doubts_about_start(PhotoList([drawing(folded=False)])).spoils
    assert any("looks like a drawing" in each for each in said)


@pytest.mark.anyio
async def test_answers_say_what_speaks_against_a_photo(tmp_path: Path, triangle: RgbImage) -> None:
    folder = write_manifest(tmp_path / "blurred", keyframes=[1, 2]).parent
    write_image(folder / "frames" / "000001.png", paint(new_paper(), LOOK))
    write_image(folder / "frames" / "000002.png", blurred(triangle, 0.05))
    async with in_memory(tmp_path / "data", folder) as host:
        await host.call("open_run", sequence="blurred")
        await host.call("save_checkpoint", frame=1)
        proposed = await host.call("propose_actions", frame=2)
        await host.call("fold", edge=[1, 3], direction=1)
        answer = await host.answer("compare_to_frame", frame=2, images="none")
    assert not proposed["confident"]
    assert any("is blurred" in each for each in proposed["warnings"])
    assert data_of(answer)["verdict"] == "MISMATCH"
    assert "Warning: the photo of frame 2 is blurred: the paper's edges are 0.0" in text_of(answer)


@pytest.mark.reference("cases/photos")
def test_a_small_square_beside_a_photographed_sheet_is_told_and_not_taken() -> None:
    photo = read_rgb(REFERENCE / "cases" / "photos" / "second_square" / "frames" / "000001.jpg")
    found = look_for_square(photo, "Frame 1")
    assert found.side > 600
    assert all(other < 200 for other in found.others)
