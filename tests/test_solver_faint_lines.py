"""A line fainter than the noise of its pixels shows in the mean along it; noise and patterns make none."""

import cv2
import numpy as np
import pytest
from folding_server.arrays import Image, Mask
from folding_server.vision.solver.faint_lines import FEWEST_LINE_PIXELS, FaintLines, averages
from hypothesis import given
from hypothesis import strategies as st

SIZE = 160
ALL = np.ones((SIZE, SIZE), np.bool_)
seeds = st.integers(0, 2**16)
degrees = st.floats(0, 180)


def drawn(angle: float, pixels: float) -> Mask:
    """A line of so many pixels, give or take one, through the middle of a picture, at an angle in degrees."""
    way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    step = pixels / 2 * way / np.abs(way).max()
    ends = [np.rint(SIZE / 2 + sign * step).astype(int).tolist() for sign in (-1, 1)]
    picture = np.zeros((SIZE, SIZE), np.uint8)
    return np.asarray(cv2.line(picture, ends[0], ends[1], 1) > 0)


def noise(seed: int) -> Image:
    """A picture of noise, of deviation 1."""
    return np.random.default_rng(seed).normal(0, 1, (SIZE, SIZE)).astype(np.float32)


@given(seeds, degrees)
def test_a_line_as_faint_as_the_noise_shows_as_a_whole(seed: int, angle: float) -> None:
    line = drawn(angle, 90)
    shown = FaintLines(noise(seed), noise(seed + 1) - 1.5 * line, ALL).shown(line)
    assert shown[line].min() == shown[line].max() > 0.5
    assert not shown[~line].any()


@pytest.mark.slow
@given(st.lists(seeds, min_size=20, max_size=20, unique=True), degrees)
def test_where_there_is_no_line_hardly_any_shows(several: list[int], angle: float) -> None:
    line = drawn(angle, 90)
    sure = [FaintLines(noise(s), noise(s + 1), ALL).shown(line)[line].mean() for s in several]
    assert np.mean(sure) < 0.25


@pytest.mark.parametrize(
    ("seed", "angle"), [(4452, 139.0), (64992, 52.17140696688673), (47954, 47.30862671494691)]
)
def test_a_line_is_not_compared_with_itself_moved_along(seed: int, angle: float) -> None:
    line = drawn(angle, 90 * np.abs([np.cos(np.radians(angle)), np.sin(np.radians(angle))]).max())
    shown = FaintLines(noise(seed), noise(seed + 1) - 1.5 * line, ALL).shown(line)
    assert shown[line].min() > 0.5


@given(degrees)
def test_a_line_has_as_many_pixels_at_every_angle(angle: float) -> None:
    assert abs(int(drawn(angle, 90).sum()) - 90) <= 1


@given(seeds)
def test_a_picture_of_stripes_that_moved_shows_no_line(seed: int) -> None:
    stripes = 10 * ((np.arange(SIZE) // 4) % 2).astype(np.float32)
    old, new = (np.tile(np.roll(stripes, by), (SIZE, 1)) + noise(seed + by) for by in (0, 2))
    line = drawn(90, 90)
    assert not FaintLines(old, new, ALL).shown(line).any()


@given(seeds)
def test_a_line_of_a_few_pixels_says_nothing(seed: int) -> None:
    line = drawn(0, FEWEST_LINE_PIXELS - 3)
    assert not FaintLines(noise(seed), noise(seed + 1) - 20 * line, ALL).shown(line).any()


@given(seeds)
def test_what_cannot_be_compared_says_nothing(seed: int) -> None:
    line = drawn(30, 90)
    nowhere = np.zeros_like(ALL)
    assert not FaintLines(noise(seed), noise(seed + 1) - 20 * line, nowhere).shown(line).any()


def test_the_average_along_a_line_keeps_a_picture_of_one_light() -> None:
    light = np.full((SIZE, SIZE), 7, np.float32)
    for kernel in averages():
        assert np.allclose(cv2.filter2D(light, -1, kernel), 7, atol=1e-4)
        assert kernel.sum() == pytest.approx(1)
