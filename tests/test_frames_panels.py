"""Panels: tiles side by side, in tables, as wrapping columns."""

import numpy as np
import pytest
from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.image_files import encode_for_model
from folding_server.frames.panels import ACCENT, TILE_GAP, Size, Tile, columns, side_by_side, table, wrapped
from numpy.typing import NDArray
from pictures import noise, quadrants


def plain(shade: int, width: int = 200, height: int = 150) -> RgbImage:
    """An olive of one shade: no part of a caption has its colour."""
    return np.full((height, width, 3), (shade, shade, 0), np.uint8)


def where(panel: RgbImage, shade: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the pixels of one shade."""
    red, green, blue = np.moveaxis(panel, 2, 0)
    rows, places = np.nonzero((red == shade) & (green == shade) & (blue == 0))
    return rows, places


def shades_in_order(panel: RgbImage, shades: list[int]) -> list[int]:
    """The given shades in the order in which a reader meets their middles, line by line."""
    middles = {}
    for shade in shades:
        rows, places = where(panel, shade)
        middles[shade] = (round(float(np.median(rows)) / 40), float(np.median(places)))
    return sorted(middles, key=lambda shade: middles[shade])


def test_images_stand_side_by_side_under_captions() -> None:
    panel = side_by_side([plain(50), plain(100), plain(150)], ["image 1", "image 2", "image 3"])
    assert panel.shape[1] <= 2000
    assert shades_in_order(panel, [50, 100, 150]) == [50, 100, 150]
    caption_bar = panel[TILE_GAP:20]
    assert (caption_bar < 128).any()
    assert not where(caption_bar, 50)[0].size


def test_images_of_other_shapes_keep_their_shape() -> None:
    panel = table([[Tile(plain(50, 100, 100)), Tile(plain(100, 100, 300)), Tile(plain(150, 100, 100))]])
    rows, places = where(panel, 100)
    assert np.ptp(rows) + 1 == pytest.approx(3 * (np.ptp(places) + 1), rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3, 8, 13, 21, 40])
def test_an_overview_wraps_and_stays_small_enough_to_send(count: int) -> None:
    photos = [noise(300, 240, seed) for seed in range(count)]
    diagrams = [quadrants(300, 300)] * count
    panel = columns(photos, diagrams, [f"frame {frame}" for frame in range(1, count + 1)])
    assert max(panel.shape[:2]) <= 2000
    picture = encode_for_model(panel, 2000)
    assert len(picture.data) < 800_000
    assert picture.width >= 1000 or count == 1


def test_an_overview_puts_each_diagram_under_its_photo() -> None:
    count = 12
    photos = [plain(10 + 4 * place) for place in range(count)]
    diagrams = [plain(130 + 4 * place) for place in range(count)]
    panel = columns(photos, diagrams, [str(place) for place in range(count)])
    for place in range(count):
        above = where(panel, 10 + 4 * place)
        below = where(panel, 130 + 4 * place)
        assert above[1].min() == below[1].min()
        assert above[0].max() < below[0].min()
        assert below[0].min() - above[0].max() < 3 * TILE_GAP


def test_tiles_wrap_in_reading_order() -> None:
    shades = list(range(20, 220, 20))
    assert shades_in_order(wrapped([Tile(plain(shade)) for shade in shades]), shades) == shades


def test_marked_tiles_are_framed() -> None:
    def red(panel: RgbImage) -> int:
        return int((panel == ACCENT).all(axis=2).sum())

    assert red(table([[Tile(plain(50), "frame 1", marked=True)]])) > 1000
    assert red(table([[Tile(plain(50), "frame 1")]])) == 0


def test_long_captions_are_cut_short_within_their_tile() -> None:
    panel = table([[Tile(plain(50), "word " * 100), Tile(plain(100))]], Size(600, 600))
    bar = panel[TILE_GAP : TILE_GAP + 16]
    right_half = bar[:, panel.shape[1] // 2 + TILE_GAP :]
    assert (bar < 128).any()
    assert (right_half == 255).all()


def test_more_tiles_than_fit_are_refused() -> None:
    with pytest.raises(PhotoError, match="do not fit one picture: ask for fewer"):
        wrapped([Tile(plain(50))] * 10_000)
    with pytest.raises(ValueError, match="at least one"):
        table([])
