"""Colours: linear light, and the Lab space in which classes are told apart."""

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Floats, Image, Mask, RgbImage

Colour = Floats


def to_lab(rgb: RgbImage) -> Image:
    """CIE Lab, L 0 to 100, of an sRGB picture."""
    return np.asarray(cv2.cvtColor(rgb.astype(np.float32) / 255.0, cv2.COLOR_RGB2LAB), np.float32)


def linear_from_table(rgb: npt.NDArray[np.generic]) -> Image:
    """Linear light, 0 to 1, of sRGB values 0 to 255 of any shape."""
    table = np.linspace(0, 1, 1024)
    curve = np.where(table <= 0.04045, table / 12.92, ((table + 0.055) / 1.055) ** 2.4).astype(np.float32)
    places = np.clip(np.asarray(rgb, np.float32) * (1023 / 255.0) + 0.5, 0, 1023).astype(np.int32)
    return np.asarray(curve[places], np.float32)


def linear_to_lab(linear: npt.NDArray[np.floating]) -> Image:
    """Lab of linear light (..., 3), same shape."""
    c = np.clip(linear, 0.0, 1.0)
    coded = np.where(c <= 0.0031308, c * 12.92, 1.055 * c ** (1 / 2.4) - 0.055).astype(np.float32)
    return np.asarray(cv2.cvtColor(coded.reshape(-1, 1, 3), cv2.COLOR_RGB2LAB), np.float32).reshape(
        coded.shape
    )


def lab_to_rgb(lab: npt.NDArray[np.floating]) -> Image:
    """sRGB, 0 to 255 with fractions, of Lab colours (rows, cols, 3)."""
    coded = cv2.cvtColor(np.asarray(lab, np.float32), cv2.COLOR_LAB2RGB)
    return np.asarray(np.clip(coded, 0, 1) * 255.0, np.float32)


def lab_to_linear(lab: npt.NDArray[np.floating]) -> Image:
    """Linear light 0 to 1 of Lab colours (rows, cols, 3)."""
    return linear_from_table(lab_to_rgb(lab))


def lab_of_linear(linear: Colour) -> Colour:
    """Lab of one linear colour, (3,) to (3,)."""
    return np.asarray(linear_to_lab(linear), np.float64)


def lab_of(colour: tuple[int, int, int]) -> Colour:
    """Lab of one sRGB colour."""
    return np.asarray(to_lab(np.array([[colour]], np.uint8))[0, 0], np.float64)


def cluster(colours: Image, count: int) -> tuple[npt.NDArray[np.int32], Image]:
    """K-means of (N, 3) colours, the same each time: which cluster each belongs to, (N,), and the centres."""
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 0.3)
    sample = np.ascontiguousarray(colours, np.float32)
    start = np.zeros((len(sample), 1), np.int32)
    cv2.setRNGSeed(1)
    _, numbers, centres = cv2.kmeans(sample, count, start, criteria, 2, cv2.KMEANS_PP_CENTERS)
    return np.asarray(numbers, np.int32).ravel(), np.asarray(centres, np.float32)


def skin(rgb: RgbImage) -> Mask:
    """Pixels whose chroma human skin can have, light or dark, under indoor or day light."""
    ycc = cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb)
    luma, cr, cb = ycc[..., 0], ycc[..., 1], ycc[..., 2]
    highest, lowest = rgb.max(axis=-1).astype(np.int16), rgb.min(axis=-1).astype(np.int16)
    tinted = highest - lowest > 0.22 * highest
    return np.asarray((luma > 40) & (cr > 137) & (cr < 178) & (cb > 77) & (cb < 127) & tinted)
