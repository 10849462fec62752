"""Borders between classes, and where along its normal each of their points finds the same border in another picture."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask
from folding_server.vision.labels import BACK, BACKGROUND, LabelImage
from folding_server.vision.registration.scene import spread_over

_POINTS = 200
"""Points of a border that look for theirs."""
_BLUR = 1.2
"""Pixels of blur before a border is located."""


@dataclass(frozen=True)
class Border:
    """Points (n, 2) on a border in pixels (column, row), and the unit normals (n, 2) into what it bounds."""

    points: Floats
    normals: Floats


def class_maps(labels: LabelImage, known: Mask) -> Iterator[Image]:
    """Blurred maps of the paper and of its back; 0.5 is the border."""
    for mask in (labels != BACKGROUND, labels == BACK):
        yield cv2.GaussianBlur((mask & known).astype(np.float32), (0, 0), _BLUR)


def border_of(image: Image, known: Mask) -> Border:
    """Points spread over the border in a map, away from what is unknown."""
    inside = image >= 0.5
    rim = inside & (cv2.erode(inside.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
    rows, cols = spread_over(
        rim & (cv2.erode(known.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0), _POINTS
    )
    gx, gy = cv2.Sobel(image, cv2.CV_32F, 1, 0), cv2.Sobel(image, cv2.CV_32F, 0, 1)
    normals = np.stack([gx, gy], axis=-1)[rows, cols].astype(np.float64)
    lengths = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-6)
    return Border(np.stack([cols, rows], axis=1).astype(np.float64), normals / lengths)


def crossings(image: Image, border: Border, span: Floats) -> Floats:
    """Where along each normal a map rises through 0.5 nearest to the point, (n,) in pixels; nan if nowhere."""
    places = (border.points[:, None] + span[None, :, None] * border.normals[:, None]).astype(np.float32)
    if not len(places):
        return np.empty(0)
    values = cv2.remap(image, places[..., 0], places[..., 1], cv2.INTER_LINEAR).astype(np.float64)
    low, high = values[:, :-1], values[:, 1:]
    rises = (low < 0.5) & (high >= 0.5)
    exact = span[:-1] + (0.5 - low) / np.where(rises, high - low, 1.0)
    nearest = np.argmin(np.where(rises, np.abs(exact), np.inf), axis=1)
    found = np.take_along_axis(exact, nearest[:, None], axis=1)[:, 0]
    return np.where(rises.any(axis=1), found, np.nan)
