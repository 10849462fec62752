"""What one photo's light does to the colours learned from the others, and what a hand must not do to them."""

import numpy as np
from folding_server.arrays import Image
from folding_server.vision.adapting import adapt
from folding_server.vision.appearance import ColourModels, Look
from folding_server.vision.surfaces import Surface
from vision_scenes import GRID

TABLE, YELLOW, BROWN = (41.0, -11.0, 6.0), (78.0, -5.0, 56.0), (41.0, 13.5, 32.5)
LIGHT = (2.0, 0.0, -1.0)
"""What the light of the photo adds to every colour."""
HAND = (44.0, 14.0, 26.0)
"""A brown hand, nearly of the colour of the brown side."""
EVERYWHERE = (-1.0, -1.0, 1.0, 1.0)


def plain(*lab: float) -> Look:
    return Look((Surface(0, np.array([lab]), np.diag([4.0, 1.5, 3.0]), EVERYWHERE),))


def photographed(hand_columns: int) -> Image:
    """Brown paper on a table under the light of the photo, in Lab, and a hand so many pixels wide beside it."""
    colours = np.broadcast_to(np.float32(TABLE) + np.float32(LIGHT), (GRID.rows, GRID.cols, 3)).copy()
    colours[100:200, 60:160] = np.float32(BROWN) + np.float32(LIGHT)
    colours[100:200, 160 : 160 + hand_columns] = np.float32(HAND)
    return colours + np.random.default_rng(1).normal(0, 0.5, colours.shape).astype(np.float32)


def brown_seen(hand_columns: int) -> np.ndarray:
    """The brown side as a photo shows it, by that photo."""
    palette = ColourModels(plain(*TABLE), plain(*YELLOW), plain(*BROWN))
    everything = np.ones((GRID.rows, GRID.cols), bool)
    back = adapt(photographed(hand_columns), everything, GRID, palette).back
    assert back is not None
    return np.asarray(back.surfaces[0].coefficients[0])


def test_a_side_is_lit_as_the_table_is() -> None:
    assert np.abs(brown_seen(0) - np.add(BROWN, LIGHT)).max() < 0.5


def test_a_hand_larger_than_the_paper_does_not_pass_for_it_in_another_light() -> None:
    assert np.abs(brown_seen(150) - np.add(BROWN, LIGHT)).max() < 0.5
