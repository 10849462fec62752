"""The lamp: how bright and warm the light is across the picture, and how it changes between frames."""

from dataclasses import dataclass
from math import cos, radians, sin

import cv2
import numpy as np

from folding_server.arrays import Float32s
from folding_server.photographer.color_spaces import floats
from folding_server.photographer.levels import Level
from folding_server.photographer.moments import Moment, frame_jitter
from folding_server.photographer.photo_scene import PhotoScene

EXPOSURE = 0.93
"""Linear light of a white surface in the middle of the picture."""


@dataclass(frozen=True)
class Lamp:
    """The lamp at one frame: ``azimuth`` on the table in degrees, ``gain`` of its strength, ``tint`` towards
    red.
    """

    azimuth: float
    gain: float
    tint: float


def frame_lamp(scene: PhotoScene, level: Level, seed: int, moment: Moment) -> Lamp:
    """The lamp at a moment: steady, but for the level's sway."""
    turn, gain, tint = frame_jitter(seed, "light", moment) * level.sway
    return Lamp(scene.lamp_azimuth + 180 * turn, float(np.clip(1 + gain, 0.75, 1.06)), tint)


def lamp_light(scene: PhotoScene, lamp: Lamp, size: tuple[int, int]) -> Float32s:
    """Light (height, width, 3) that falls on the table and reaches the sensor, lens fall-off included."""
    width, height = size
    angle = radians(lamp.azimuth)
    y, x = np.mgrid[0:33, 0:33].astype(np.float32) / np.float32(16) - 1
    aspect = np.array([width, height]) / max(size)
    towards = x * aspect[0] * cos(angle) - y * aspect[1] * sin(angle)
    fall = 1 + scene.lamp_fall * (0.75 * towards - 0.25 * (towards - 1) ** 2 / 2 + 0.125)
    lens = 1 - scene.vignette * ((x * aspect[0]) ** 2 + (y * aspect[1]) ** 2) / 2
    field = EXPOSURE * lamp.gain * np.clip(fall, 0.2, 1.25) * lens
    warmth = np.asarray(scene.warmth, np.float32) * np.array(
        [1 + lamp.tint / 3, 1, 1 - lamp.tint / 3], np.float32
    )
    smooth = cv2.resize(field.astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
    return floats(smooth[..., None] * warmth)
