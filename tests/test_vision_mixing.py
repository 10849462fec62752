"""Border pixels are split between two classes so that outlines lie where they are, shadows beside them or not."""

import cv2
import numpy as np
import pytest
from folding_server.photographer.color_spaces import to_srgb
from folding_server.vision.appearance import Look
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACKGROUND, FRONT
from folding_server.vision.mixing import class_lights, mixtures
from folding_server.vision.surfaces import Surface

SIDE, BORDER = 60, 30.3
"""Pixels of a square picture, and the column at which the paper on its left ends."""
GREY = Look((Surface(0, np.array([[50.0, 0, 0]]), np.eye(3), (-1, -1, 1, 1)),))


def paper_width(paper: float, table: float, shadow: float, blur: float = 0.5, mixed: int = 1) -> float:
    """How wide paper of that linear light seems (pixels), beside a table of another that it shades towards its border."""
    fine = (np.arange(SIDE * 20) + 0.5) / 20
    beside = table * (1 - shadow * np.exp((BORDER - fine) / 1.5))
    light = np.where(fine < BORDER, paper, beside).reshape(SIDE, 20).mean(axis=1).astype(np.float32)
    picture = cv2.GaussianBlur(np.tile(light[None, :, None], (SIDE, 1, 3)), (0, 0), blur)
    rgb = np.asarray(np.rint(to_srgb(picture)), np.uint8)
    labels = np.full((SIDE, SIDE), BACKGROUND, np.uint8)
    labels[:, : round(BORDER)] = FRONT
    known = np.zeros(labels.shape, bool)
    lights = class_lights(labels, known, rgb, (GREY, GREY), Grid(0, 1, SIDE, SIDE, SIDE), mixed)
    return float(mixtures(labels, known, rgb, lights)[..., FRONT].sum(axis=1).mean())


@pytest.mark.parametrize("shadow", [0.0, 0.2, 0.35])
@pytest.mark.parametrize(("paper", "table"), [(0.1, 0.45), (0.75, 0.1), (0.3, 0.8)])
def test_a_shadow_beside_the_paper_moves_no_outline(paper: float, table: float, shadow: float) -> None:
    assert abs(paper_width(paper, table, shadow) - BORDER) < 0.15


@pytest.mark.parametrize(("paper", "table"), [(0.1, 0.45), (0.75, 0.1), (0.35, 1.0)])
def test_a_soft_photo_shows_no_shadow_where_there_is_none(paper: float, table: float) -> None:
    assert abs(paper_width(paper, table, 0.0, blur=1.0, mixed=2) - BORDER) < 0.15
