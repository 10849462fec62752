"""Colours as light: sRGB to linear and back, perceived difference, and the papers and tables of scenes."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from folding_server.arrays import Float32s
from folding_server.frames.color_names import color_rgb


@dataclass(frozen=True)
class Stock:
    """A kind of folding paper, named by the colours of its two sides (#rrggbb)."""

    front: str
    back: str


STOCKS = (
    Stock("#f4f2ec", "#b8342f"),
    Stock("#f6f5f1", "#2f6fb4"),
    Stock("#f3f1e8", "#2f8a55"),
    Stock("#f5f3ee", "#7c4a9e"),
    Stock("#f2efe6", "#d9679b"),
    Stock("#f5f4ef", "#e0842a"),
    Stock("#f4f3ee", "#3a3f47"),
    Stock("#f1d24a", "#f4f2ec"),
    Stock("#c23b34", "#f5f3ed"),
    Stock("#3d86c6", "#f3f2ed"),
    Stock("#d8b98a", "#7a3f25"),
    Stock("#f0d35a", "#8a5a2c"),
    Stock("#e58fae", "#7fbf6a"),
    Stock("#f2c14e", "#2b6c9f"),
    Stock("#9fcbe6", "#2a4b8d"),
    Stock("#efe3c2", "#4b8b4a"),
)
"""Papers from the shelf: most are white on the front and dyed on the back, some are dyed on both sides."""

PLAIN_TABLES = (
    "#2e3134",
    "#54585c",
    "#7d8286",
    "#3b4a45",
    "#5a4636",
    "#8a8f78",
    "#27364a",
    "#a9b3ba",
    "#6d5f72",
    "#1f2022",
)
PALE_TABLES = ("#d9d8d4", "#e6e3dc", "#cfd4d6", "#c9beb0", "#b9bfc4")


def floats(values: object) -> Float32s:
    """Any array as 32-bit floats."""
    return np.asarray(values, np.float32)


def to_linear(encoded: NDArray[np.generic] | tuple[int, int, int]) -> Float32s:
    """Linear light 0 to 1 of sRGB values 0 to 255, any shape."""
    value = np.asarray(encoded, np.float32) / np.float32(255)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


def to_srgb(light: Float32s) -> Float32s:
    """Linear light 0 to 1 as sRGB values 0 to 255 (not rounded), any shape; light beyond 1 clips."""
    value = np.clip(light, 0, 1)
    high = 1.055 * np.power(value, np.float32(1 / 2.4)) - 0.055
    return floats(np.where(value <= 0.0031308, 12.92 * value, high) * np.float32(255))


def linear_color(color: str) -> Float32s:
    """A colour by name or #rrggbb as three linear values. PhotoError for a colour that is not known."""
    return to_linear(color_rgb(color))


def color_difference(first: str, second: str) -> float:
    """Perceived difference of two colours: distance in CIE L*a*b* (1976), 0 to about 250."""
    pair = np.asarray([[color_rgb(first), color_rgb(second)]], np.float32) / np.float32(255)
    lab = cv2.cvtColor(pair, cv2.COLOR_RGB2LAB)[0]
    return float(np.linalg.norm(lab[0] - lab[1]))


def as_hex(rgb: NDArray[np.generic]) -> str:
    """Three sRGB values 0 to 255 as #rrggbb."""
    return "#" + bytes(int(v) for v in np.clip(np.rint(rgb), 0, 255)).hex()


def near_color(rng: np.random.Generator, color: str, spread: float) -> str:
    """A colour a little off, by a normal deviation of ``spread`` sRGB steps per channel."""
    return as_hex(np.asarray(color_rgb(color)) + rng.normal(0, spread, 3))
