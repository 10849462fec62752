"""Builders of images and sequence folders for the tests about frames."""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Rgb = NDArray[np.uint8]


def quadrants(width: int = 96, height: int = 64) -> Rgb:
    """An image whose quarters are red, green (top), blue, yellow (bottom): every turn of it is told apart."""
    image = np.zeros((height, width, 3), np.uint8)
    image[: height // 2, : width // 2] = (220, 30, 30)
    image[: height // 2, width // 2 :] = (30, 200, 30)
    image[height // 2 :, : width // 2] = (30, 30, 220)
    image[height // 2 :, width // 2 :] = (220, 220, 30)
    return image


def noise(width: int, height: int, seed: int = 0) -> Rgb:
    """An image that no encoder can make small."""
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)


def write_image(path: Path, image: Rgb | None = None, **options: object) -> Path:
    """Write `image` (quadrants by default) in the format of the suffix."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(quadrants() if image is None else image).save(path, **options)  # type: ignore[arg-type]
    return path


def write_manifest(folder: Path, content: object = None, **keys: object) -> Path:
    """Write `keyframes.json`: `content` as it is, or the given keys."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "keyframes.json"
    path.write_text(json.dumps(keys if content is None else content))
    return path


def write_sequence_folder(
    folder: Path, keyframes: list[int], others: tuple[int, ...] = (), **keys: object
) -> Path:
    """A whole sequence: each image is a grey of its index, 96 by 64."""
    write_manifest(folder, **{"name": folder.name, "frames": "frames", "keyframes": keyframes, **keys})
    for index in [*keyframes, *others]:
        image = np.full((64, 96, 3), index % 256, np.uint8)
        write_image(folder / "frames" / f"{index:06d}.png", image)
    return folder
