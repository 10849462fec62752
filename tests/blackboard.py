"""White paper on a blackboard, drawn as a phone sees it: chalk dust, a shadow across the board, soft borders."""

from collections.abc import Sequence

import cv2
import numpy as np
from folding_server.arrays import RgbImage

WIDTH, HEIGHT = 480, 640
FINE = 4
"""Pixels are painted as the mean of so many squared."""
PAPER = (236, 232, 226)
GAMMA = 2.2
"""Light is mixed where it is light: a picture's values are its power of one over this, about."""
Outline = Sequence[tuple[float, float]]
"""Corners in pixels (x right, y down)."""

SQUARE: Outline = ((140, 160), (335, 205), (290, 400), (95, 355))
TRIANGLE: Outline = ((120, 420), (360, 150), (360, 425))
FLAT_TRIANGLE: Outline = ((90, 330), (215, 190), (395, 320))
BAND: tuple[Outline, ...] = (
    ((75, 430), (95, 370), (340, 200), (410, 212)),
    ((200, 320), (260, 400), (290, 398), (300, 240)),
)
BIRD: tuple[Outline, ...] = (
    ((240, 200), (262, 195), (265, 330), (225, 330)),
    ((120, 270), (180, 300), (230, 390), (190, 380)),
    ((250, 330), (390, 365), (330, 405), (225, 390)),
    ((270, 230), (285, 240), (270, 390), (225, 385)),
)


def board(*outlines: Outline, round_sheet: float = 0.0, seed: int = 0) -> RgbImage:
    """A photo of paper of these outlines, or of a disc of a radius in pixels."""
    random = np.random.default_rng(seed)
    cover = np.zeros((HEIGHT * FINE, WIDTH * FINE), np.uint8)
    for outline in outlines:
        cv2.fillPoly(cover, [np.rint(np.array(outline) * FINE).astype(np.int32)], 1)
    if round_sheet:
        cv2.circle(cover, (WIDTH // 2 * FINE, HEIGHT // 2 * FINE), round(round_sheet * FINE), 1, cv2.FILLED)
    share = cover.reshape(HEIGHT, FINE, WIDTH, FINE).mean(axis=(1, 3), dtype=np.float32)
    share = cv2.GaussianBlur(share, (0, 0), 0.8)[..., None]
    light = share * np.power(PAPER, GAMMA) + (1 - share) * _dusty(random) ** GAMMA
    picture = (light * _shadow_across()[..., None]) ** (1 / GAMMA)
    return np.clip(picture + random.normal(0, 1.5, picture.shape), 0, 255).astype(np.uint8)


def covered(*outlines: Outline) -> RgbImage:
    """A picture that is white where the paper lies and black elsewhere."""
    mask = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for outline in outlines:
        corners = (np.array(outline) - 0.5) * 16
        cv2.fillPoly(mask, [np.rint(corners).astype(np.int32)], (255, 255, 255), cv2.LINE_AA, 4)
    return mask


def _dusty(random: np.random.Generator) -> np.ndarray:
    """The board: dark, with dust in clouds and specks."""
    clouds = cv2.resize(random.normal(0, 3, (10, 8)).astype(np.float32), (WIDTH, HEIGHT))
    specks = (random.random((HEIGHT, WIDTH)) > 0.9995) * 25
    return (np.array((34, 33, 29)) + (clouds + specks)[..., None]).astype(np.float32)


def _shadow_across() -> np.ndarray:
    """How bright the picture is from top to bottom: a broad shadow falls over its lower half."""
    down = np.linspace(0, 1, HEIGHT, dtype=np.float32)[:, None]
    slant = down + 0.08 * np.linspace(0, 1, WIDTH, dtype=np.float32)[None]
    return 1 - 0.25 / (1 + np.exp(-(slant - 0.62) * 40))
