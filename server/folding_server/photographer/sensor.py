"""Lens and sensor: blur, noise, sRGB, JPEG."""

import cv2
import numpy as np

from folding_server.arrays import ByteMask, Float32s, RgbImage
from folding_server.photographer.color_spaces import floats, to_srgb
from folding_server.photographer.photo_scene import PhotoScene
from folding_server.photographer.rng import stream


def expose(light: Float32s, scene: PhotoScene, seed: int, frame: int) -> RgbImage:
    """The picture (height, width, 3) uint8 RGB that a sensor takes of linear light 0 to 1."""
    rng = stream(seed, "sensor", frame)
    blurred = cv2.GaussianBlur(light, (0, 0), scene.blur)
    encoded = to_srgb(floats(blurred))
    grey = rng.standard_normal(encoded.shape[:2], np.float32)[..., None]
    tinted = cv2.GaussianBlur(rng.standard_normal(encoded.shape, np.float32), (0, 0), 0.7)
    noisy = encoded + np.float32(scene.noise) * (np.float32(0.8) * grey + np.float32(1.2) * tinted)
    pixels: RgbImage = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return pixels


def jpeg(picture: RgbImage, quality: int) -> bytes:
    """A JPEG file of an RGB picture."""
    _, data = cv2.imencode(
        ".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    return data.tobytes()


def png(mask: ByteMask) -> bytes:
    """A PNG file of a grey picture (height, width)."""
    _, data = cv2.imencode(".png", mask)
    return data.tobytes()
