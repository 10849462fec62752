"""Synthetic folding videos whose keyframes are known: paper on a table, hands that come and go."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from folding_server.arrays import RgbImage
from numpy.typing import NDArray
from video_writing import Camera, encode

Shape = tuple[tuple[tuple[float, float], ...], tuple[int, int, int]]
"""A polygon in parts of the picture (x right, y down) and its colour."""
State = tuple[Shape, ...]

WHITE, BLUE, SKIN, SLEEVE = (238, 236, 230), (50, 90, 190), (205, 150, 120), (70, 80, 60)
SQUARE: State = ((((0.3, 0.2), (0.7, 0.2), (0.7, 0.8), (0.3, 0.8)), WHITE),)
TRIANGLE: State = ((((0.3, 0.2), (0.7, 0.8), (0.3, 0.8)), BLUE),)
KITE: State = (
    (((0.3, 0.2), (0.7, 0.8), (0.5, 0.86), (0.3, 0.8)), BLUE),
    (((0.3, 0.5), (0.45, 0.8), (0.3, 0.8)), WHITE),
)
HOUSE: State = ((((0.3, 0.5), (0.5, 0.3), (0.7, 0.5), (0.7, 0.8), (0.3, 0.8)), BLUE),)
TAB: State = (*HOUSE, (((0.62, 0.72), (0.7, 0.72), (0.7, 0.8)), WHITE))


@dataclass(frozen=True)
class Rest:
    """The paper lies still with no hand near."""

    state: State
    seconds: float = 1.0


@dataclass(frozen=True)
class Hold:
    """The paper lies still under a resting hand."""

    state: State
    at: tuple[float, float] = (0.75, 0.7)
    seconds: float = 1.0


@dataclass(frozen=True)
class Work:
    """A hand comes in, changes the paper and goes out again."""

    before: State
    after: State
    seconds: float = 1.6


@dataclass(frozen=True)
class Sway:
    """A hand moves about over the paper all the time, and least in the middle of the shot."""

    state: State
    seconds: float = 2.0


Shot = Rest | Hold | Work | Sway


@dataclass(frozen=True)
class Clip:
    """A written video and, for each shot, the indices of its images."""

    path: Path
    shots: tuple[range, ...]


def write_clip(path: Path, shots: Sequence[Shot], camera: Camera = Camera(), seed: int = 0) -> Clip:
    """Film `shots` one after the other."""
    random = np.random.default_rng(seed)
    table = _table(camera, random)
    grains = random.normal(0, camera.grain, (7, camera.height, camera.width, 3)).astype(np.float32)
    ends = np.cumsum([shot.seconds for shot in shots])
    times = list(_times(camera, float(ends[-1])))
    places = np.searchsorted(ends, times, side="right")
    frames = (
        _frame(
            shots[place],
            1 - (ends[place] - time) / shots[place].seconds,
            time,
            table,
            camera,
            grains[number % 7],
        )
        for number, (place, time) in enumerate(zip(places, times, strict=True))
    )
    encode(path, frames, times, camera)
    bounds = [np.flatnonzero(places == number) for number in range(len(shots))]
    return Clip(path, tuple(range(int(at[0]), int(at[-1]) + 1) for at in bounds))


def _times(camera: Camera, end: float) -> Iterator[float]:
    time, count = 0.0, 0
    while time < end:
        yield time
        time += camera.steps[count % len(camera.steps)] / 1000 if camera.steps else 1 / camera.rate
        count += 1


def _table(camera: Camera, random: np.random.Generator) -> NDArray[np.float32]:
    """A grainy table lit from one side."""
    wood = cv2.resize(random.normal(0, 6, (12, 16)).astype(np.float32), (camera.width, camera.height))
    light = np.linspace(95, 135, camera.width, dtype=np.float32)[None, :]
    return np.repeat((wood + light)[..., None], 3, axis=2)


def _frame(
    shot: Shot,
    part: float,
    time: float,
    table: NDArray[np.float32],
    camera: Camera,
    grain: NDArray[np.float32],
) -> RgbImage:
    picture = table.copy()
    state, hand = _what(shot, part)
    for polygon, color in state:
        corners = np.array([(x * camera.width * 16, y * camera.height * 16) for x, y in polygon])
        cv2.fillPoly(picture, [np.rint(corners).astype(np.int32)], color, cv2.LINE_AA, 4)
    if hand is not None:
        _draw_hand(picture, hand)
    if time >= camera.nudged:
        motion = np.array([[1, 0.01, 3], [-0.01, 1, 4]], np.float32)
        picture = cv2.warpAffine(
            picture, motion, (camera.width, camera.height), borderMode=cv2.BORDER_REPLICATE
        )
    picture *= 1 + camera.flicker * np.sin(time * 17)
    picture += grain
    return np.rot90(np.clip(picture, 0, 255).astype(np.uint8), -camera.turned // 90)


def _what(shot: Shot, part: float) -> tuple[State, tuple[float, float] | None]:
    """The paper and the hand's place when `part` of the shot is over."""
    if isinstance(shot, Rest):
        return shot.state, None
    if isinstance(shot, Hold):
        return shot.state, shot.at
    if isinstance(shot, Sway):
        far = 0.25 * abs(2 * part - 1)
        return shot.state, (0.8 + far * np.sin(40 * part), 0.72 + (0.02 + far) * np.cos(40 * part))
    reach = min(1.0, 3 * min(part, 1 - part))
    sway = 0.06 * np.sin(20 * part)
    hand = (1.25 - 0.65 * reach, 0.75 - 0.2 * reach + sway)
    return (shot.before if part < 0.5 else shot.after), hand


def _draw_hand(picture: NDArray[np.float32], at: tuple[float, float]) -> None:
    """A palm with an arm that reaches over the right border, and the shadow beside it."""
    height, width = picture.shape[:2]
    palm = (int(at[0] * width), int(at[1] * height))
    wrist = (palm[0] + width // 8, palm[1] + height // 16)
    shade = np.zeros((height, width), np.float32)
    cv2.ellipse(shade, (palm[0] - 6, palm[1] + 8), (width // 11, height // 9), 20, 0, 360, 1.0, -1)
    picture *= 1 - 0.2 * cv2.GaussianBlur(shade, (0, 0), 3)[..., None]
    cv2.line(picture, palm, wrist, SKIN, height // 8, cv2.LINE_AA)
    cv2.line(picture, wrist, (width + width // 4, palm[1] + height // 4), SLEEVE, height // 6, cv2.LINE_AA)
    cv2.ellipse(picture, palm, (width // 11, height // 9), 20, 0, 360, SKIN, -1, cv2.LINE_AA)
