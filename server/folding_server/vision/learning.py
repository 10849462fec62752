"""How table, front and back look in one sequence: frame 1 tells two of them, later frames the back."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.arrays import Bools, Float32s, Floats, Image, Mask
from folding_server.frames.color_names import color_rgb
from folding_server.vision.appearance import ColourModels, Look, coordinates
from folding_server.vision.colours import (
    Colour,
    cluster,
    lab_of,
    lab_of_linear,
    lab_to_linear,
    linear_from_table,
    skin,
    to_lab,
)
from folding_server.vision.grid import Grid, grid_over
from folding_server.vision.photos import Photos
from folding_server.vision.pose import Pose
from folding_server.vision.segmentation import class_costs
from folding_server.vision.surfaces import Surface, fit_surface

LEARNING_RESOLUTION = 48.0
"""Pixels per unit at which the photos are looked through for the back's colour."""
MOST_PHOTOS = 24
"""Photos from which colours are learnt, spread over the sequence."""
SAME_COLOUR = 7.0
"""Distance in Lab below which two sides look alike."""
NEW_COLOUR = 10.0
"""Cost, in nats, above which a pixel is a colour not yet known."""
CLUSTERS = 4
"""Colours that are told apart among what is not yet known."""
FEWEST_COLOUR_PIXELS = 30
"""Pixels that a colour must have to count."""
GOOD_DEAL = 0.02
"""Area, in sheet units squared, that a colour must cover in a photo to be more than an accident."""
OFTEN = 0.4
"""Share of the photos in which a darker shade must cover a good deal to be paper and no shadow."""


@dataclass(frozen=True)
class Marks:
    """What is known of unexplained pixels beside their colour, each (N,)."""

    skin: Bools
    entering: Bools
    shaded: Bools
    frame: npt.NDArray[np.int64]

    def only(self, chosen: Bools) -> "Marks":
        """The marks of some of the pixels."""
        return Marks(self.skin[chosen], self.entering[chosen], self.shaded[chosen], self.frame[chosen])


@dataclass(frozen=True)
class NewColour:
    """One colour that appears in later photos: its mean and spread in Lab, and its share of all new pixels.

    ``skin``, ``entering`` and ``shaded`` say how much of it is like skin, reaches in, or is a darker
    shade of table or front; ``lasting`` is the share of the later photos in which there is a good deal of it.
    """

    mean: Colour
    covariance: Floats
    weight: float
    skin: float
    entering: float
    shaded: float
    lasting: float


def learn(photos: Photos, pose: Pose) -> ColourModels:
    """The palette of a sequence whose flat square was found in frame 1."""
    grid = grid_over(LEARNING_RESOLUTION)
    first = _first_palette(photos, pose, grid)
    back = _find_back(photos, pose, grid, first)
    return ColourModels(first.table, first.front, back)


def _first_palette(photos: Photos, pose: Pose, grid: Grid) -> ColourModels:
    """Table and front from frame 1, where the sheet is the unit square."""
    rgb, seen = pose.rectify(photos.photo(1), grid)
    lab = to_lab(rgb)
    x, y = np.meshgrid(*coordinates(grid))
    far = np.maximum(np.abs(x), np.abs(y)) * 1.3
    inside, outside = (far < 0.46) & seen, (far > 0.55) & seen
    return ColourModels(_table_look(x, y, lab, outside), _sheet_look(x, y, lab, inside), None)


def _table_look(x: Floats, y: Floats, lab: Image, own: Mask) -> Look:
    """A smooth surface for the table."""
    return Look((fit_surface(x[own], y[own], lab[own].astype(np.float64), 2),))


def _sheet_look(x: Floats, y: Floats, lab: Image, own: Mask) -> Look:
    """A sloping surface for a plain sheet; one more for each further colour of a patterned one."""
    main = fit_surface(x[own], y[own], lab[own].astype(np.float64), 1)
    surfaces = [main]
    rest = own & (Look((main,)).cost(lab, _grid_of(lab)) > NEW_COLOUR)
    if rest.sum() > 0.04 * own.sum():
        surfaces.append(fit_surface(x[rest], y[rest], lab[rest].astype(np.float64), 0))
    return Look(tuple(surfaces))


def _grid_of(lab: Image) -> Grid:
    grid = grid_over(LEARNING_RESOLUTION)
    assert lab.shape[:2] == (grid.rows, grid.cols)
    return grid


def _find_back(photos: Photos, pose: Pose, grid: Grid, first: ColourModels) -> Look | None:
    """The colour of the back: the one new colour in the later photos that behaves like paper."""
    hint = _hinted_back(photos, first)
    groups = list(_groups(photos, pose, grid, first))
    front = first.front.surfaces[0].at(np.zeros(()), np.zeros(())).astype(np.float64)
    ranked = sorted(((_likelihood(group, hint), i) for i, group in enumerate(groups)), reverse=True)
    if ranked and ranked[0][0] > 0.002:
        group = groups[ranked[0][1]]
        if np.linalg.norm(group.mean - front) > SAME_COLOUR:
            return _plain(group.mean, group.covariance)
    if hint is not None and np.linalg.norm(hint - front) > 2 * SAME_COLOUR:
        return _plain(hint, np.diag([60.0, 40.0, 40.0]))
    return None


def _plain(mean: Colour, covariance: Floats) -> Look:
    everywhere = (-1.0, -1.0, 1.0, 1.0)
    return Look((Surface(0, mean.reshape(1, 3), covariance, everywhere),))


def _hinted_back(photos: Photos, first: ColourModels) -> Colour | None:
    """The declared back in the light of frame 1, told by how the declared front looks there."""
    if photos.back_color is None:
        return None
    back = color_rgb(photos.back_color)
    if photos.front_color is None:
        return lab_of(back)
    front = color_rgb(photos.front_color)
    seen = _linear_of(first.front.surfaces[0].at(np.zeros(()), np.zeros(())).astype(np.float64))
    declared = linear_from_table(np.array(front)).astype(np.float64)
    gain = np.clip((seen + 0.02) / (declared + 0.02), 0.4, 1.8)
    if lab_distance(front, back) < SAME_COLOUR:
        return None
    return lab_of_linear(linear_from_table(np.array(back)).astype(np.float64) * gain)


def lab_distance(first: tuple[int, int, int], second: tuple[int, int, int]) -> float:
    """Distance in Lab of two sRGB colours."""
    return float(np.linalg.norm(lab_of(first) - lab_of(second)))


def _linear_of(lab: Colour) -> Colour:
    return np.asarray(lab_to_linear(lab.reshape(1, 1, 3))[0, 0], np.float64)


def _groups(photos: Photos, pose: Pose, grid: Grid, first: ColourModels) -> Iterator[NewColour]:
    """Clusters of the colours that table and front do not explain."""
    frames = _sampled_frames(photos.frame_count)
    parts = [_new_pixels(photos, frame, pose, grid, first) for frame in frames]
    pixels = np.concatenate([part[0] for part in parts]) if parts else np.zeros((0, 3), np.float32)
    if len(pixels) < FEWEST_COLOUR_PIXELS:
        return
    marks = Marks(
        *(np.concatenate([getattr(part[1], name) for part in parts]) for name in Marks.__annotations__)
    )
    numbers, _ = cluster(pixels, CLUSTERS)
    for k in range(CLUSTERS):
        own = numbers == k
        if own.sum() >= FEWEST_COLOUR_PIXELS:
            yield _group(pixels[own].astype(np.float64), marks.only(own), float(own.mean()), len(frames))


def _group(colours: Floats, marks: Marks, share: float, frames: int) -> NewColour:
    mean = np.median(colours, axis=0)
    near = colours[np.linalg.norm(colours - mean, axis=1) < 18]
    covariance = np.cov(near.T) if len(near) > 10 else np.diag([30.0, 15.0, 15.0])
    per_frame = np.bincount(marks.frame)
    lasting = float((per_frame > GOOD_DEAL * LEARNING_RESOLUTION**2).sum()) / frames
    of_skin, entering, shaded = (float(m.mean()) for m in (marks.skin, marks.entering, marks.shaded))
    return NewColour(mean, covariance, share, of_skin, entering, shaded, lasting)


def _sampled_frames(count: int) -> list[int]:
    """Frames after the first, evenly spaced if there are many."""
    later = np.arange(2, count + 1)
    return [int(frame) for frame in later[:: max(1, -(-len(later) // MOST_PHOTOS))]]


def _new_pixels(
    photos: Photos, frame: int, pose: Pose, grid: Grid, first: ColourModels
) -> tuple[Float32s, Marks]:
    """Lab (N, 3) of the pixels that neither table nor front in plain light explains, and their marks."""
    rgb, seen = pose.rectify(photos.photo(frame), grid)
    lab = to_lab(rgb)
    lit = np.minimum.reduce([look.cost(lab, grid, shadows=False) for look in first.looks])
    new = cv2.erode((seen & (lit > NEW_COLOUR)).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    edge = cv2.dilate((~seen).astype(np.uint8), np.ones((5, 5), np.uint8))
    edge[[0, 1, -1, -2]], edge[:, [0, 1, -1, -2]] = 1, 1
    _, numbered = cv2.connectedComponents(new.astype(np.uint8))
    entering = np.isin(numbered, np.unique(numbered[(edge > 0) & new]))
    shaded = class_costs(lab, grid, first).min(axis=-1) <= NEW_COLOUR
    count = int(new.sum())
    return lab[new], Marks(skin(rgb)[new], entering[new], shaded[new], np.full(count, frame))


def _likelihood(group: NewColour, hint: Colour | None) -> float:
    """How much a colour behaves like the back of the sheet, 0 to 1.

    A darker shade of what is known is a shadow unless it lasts; hands are skin and reach in from outside.
    """
    paper = group.weight * (1 - group.shaded * (1 - group.lasting if group.lasting > OFTEN else 1.0))
    if hint is None:
        return paper * (1 - 0.8 * group.skin) * (1 - 0.9 * group.entering)
    away = float(np.linalg.norm((group.mean - hint) * (0.6, 1.0, 1.0)))
    return paper * (1 - 0.5 * group.entering) * float(np.exp(-((away / 25.0) ** 2)))
