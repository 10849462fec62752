"""One photo at one resolution as the solver sees it, and how well a stack of faces explains it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np

from folding_server.arrays import Image, Indices, Mask
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.simulator.paper import Paper
from folding_server.vision.grid import Grid, Reach
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, LabelImage, as_one_colour, is_paper
from folding_server.vision.raster import draw_labels
from folding_server.vision.sheet_lines import SheetLines

SURROUNDINGS = 0.3
"""How far around the paper the table is looked at under a camera of its own, in sheet units: its colour is told there."""
WIDEST_STRIP = 0.03
"""A border laid a little beside explains no disagreement wider than this, in sheet units."""
_AROUND, _SMOOTH = 0.04, 0.7
"""How far around a place (sheet units) the light is taken to be the same, and how far pixels are smoothed."""


def spread_over(mask: Mask, most: int) -> tuple[Indices, Indices]:
    """The rows and columns of at most so many of a mask's pixels, evenly spread in reading order."""
    places = np.flatnonzero(mask)
    if len(places) > most:
        places = places[np.linspace(0, len(places) - 1, most).astype(int)]
    rows, cols = np.divmod(places, mask.shape[1])
    return rows, cols


def soft(labels: LabelImage, blur: float) -> Image:
    """A label image as two blurred maps, how much front and how much back there is near each pixel, (2, rows, cols)."""
    size = 2 * int(2 * blur + 0.5) + 1
    maps = np.empty((2, *labels.shape), np.float32)
    for plane, side in zip(maps, (FRONT, BACK), strict=True):
        cv2.GaussianBlur((labels == side).astype(np.float32), (size, size), blur, dst=plane)
    return maps


@dataclass(frozen=True)
class FaceStack:
    """Faces to paint, bottom to top: folded outlines in sheet units and whether each lies back up."""

    outlines: Sequence[Sequence[Point]]
    backs: Sequence[bool]

    @cached_property
    def bounds(self) -> Reach:
        """The bounding box: left, bottom, right, top."""
        points = np.array([p for outline in self.outlines for p in outline])
        (left, bottom), (right, top) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return left, bottom, right, top

    @cached_property
    def center(self) -> Point:
        """The middle of the bounding box."""
        left, bottom, right, top = self.bounds
        return (left + right) / 2, (bottom + top) / 2

    @property
    def surroundings(self) -> Reach:
        """The bounding box with SURROUNDINGS of table about it."""
        left, bottom, right, top = self.bounds
        return left - SURROUNDINGS, bottom - SURROUNDINGS, right + SURROUNDINGS, top + SURROUNDINGS


def face_stack(paper: Paper) -> FaceStack:
    """All faces of a paper as they lie."""
    return FaceStack([paper.polygon(f) for f in paper.order], [paper.back_up(f) for f in paper.order])


@dataclass(frozen=True)
class Scene:
    """A label image on a grid; ``two_coloured`` says whether it tells the front of the sheet from the back.

    ``edges`` is the strength of lines within the paper, (rows, cols) from 0 to 1, where that was worked out; ``sight``
    is the chance, 0 to 1, that the border of a layer shows as such a line. ``light`` is the lightness of the photo,
    (rows, cols) from 0 to 255, where it is to be compared with another's. ``sheet_lines`` and ``shaded`` are as in
    :class:`folding_server.vision.seeing.Observation`.
    """

    grid: Grid
    labels: LabelImage
    two_coloured: bool = True
    edges: Image | None = None
    sight: float = 1.0
    light: Image | None = None
    sheet_lines: SheetLines | None = None
    shaded: float = 0.0
    known: Mask = field(init=False)
    paper: Mask = field(init=False)
    _blurred: dict[float, Image] = field(init=False, default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "known", self.labels != UNKNOWN)
        object.__setattr__(self, "paper", is_paper(self.labels))

    def draw(self, stack: FaceStack, motion: Similarity) -> LabelImage:
        """What a stack would look like here, in the classes that the photo can tell apart."""
        drawn = draw_labels(stack.outlines, stack.backs, self.grid, motion)
        return drawn if self.two_coloured else as_one_colour(drawn)

    def agreement_of(self, drawn: LabelImage) -> float:
        """Share of the known pixels showing paper, in the photo or the drawing, whose class agrees; 0 to 1."""
        return max(0.0, 1.0 - int(np.count_nonzero(self._wrong(drawn))) / self._judged(drawn))

    def residual_of(self, drawn: LabelImage) -> float:
        """Share of the paper, 0 to 1, whose class disagrees over more than WIDEST_STRIP in every direction: no border laid a little beside
        explains that.
        """
        width = 2 * round(WIDEST_STRIP * self.grid.pixels_per_unit / 2) + 1
        patches = cv2.morphologyEx(
            self._wrong(drawn).astype(np.uint8), cv2.MORPH_OPEN, np.ones((width, width), np.uint8)
        )
        return int(np.count_nonzero(patches)) / self._judged(drawn)

    def _wrong(self, drawn: LabelImage) -> Mask:
        """The known pixels whose class disagrees."""
        return np.asarray((drawn != self.labels) & self.known)

    def _judged(self, drawn: LabelImage) -> int:
        """How many known pixels show paper, in the photo or the drawing; 1 if none do."""
        return max(int(np.count_nonzero((self.paper | (drawn != BACKGROUND)) & self.known)), 1)

    def agreement(self, stack: FaceStack, motion: Similarity) -> float:
        """How well a stack under a motion explains the photo, 0 to 1."""
        return self.agreement_of(self.draw(stack, motion))

    @cached_property
    def weight(self) -> Image:
        """1 where the photo is known, fading to 0 beside what is not, (rows, cols)."""
        faded = cv2.GaussianBlur(self.known.astype(np.float32), (9, 9), 2.0)
        return np.asarray(np.where(self.known, np.maximum(2 * faded - 1, 0), 0), np.float32)

    @cached_property
    def detail(self) -> Image | None:
        """The photo's lightness less that of the same side of the paper around it, (rows, cols); 0 outside."""
        if self.light is None:
            return None
        wide, detail = _AROUND * self.grid.pixels_per_unit, np.zeros_like(self.light)
        for side in (FRONT, BACK):
            there = (self.labels == side).astype(np.float32)
            around = cv2.GaussianBlur(self.light * there, (0, 0), wide) / np.maximum(
                cv2.GaussianBlur(there, (0, 0), wide), 1e-3
            )
            detail += (self.light - around) * there
        return np.asarray(cv2.GaussianBlur(detail, (0, 0), _SMOOTH), np.float32)

    def soft(self, blur: float) -> Image:
        """The photo's label image blurred, (2, rows, cols)."""
        if blur not in self._blurred:
            self._blurred[blur] = soft(self.labels, blur)
        return self._blurred[blur]

    @cached_property
    def center(self) -> Point:
        """The middle of the bounding box of the paper, in sheet units; the grid's middle if there is none."""
        rows, cols = np.nonzero(self.paper)
        if not len(rows):
            rows, cols = np.array([0, self.grid.rows - 1]), np.array([0, self.grid.cols - 1])
        corners = self.grid.to_plane(np.array([[cols.min(), rows.min()], [cols.max(), rows.max()]]))
        x, y = corners.mean(axis=0)
        return float(x), float(y)


@dataclass(frozen=True)
class Views:
    """A photo at two resolutions, and whether the camera may have come nearer or gone further since the last one.

    Even under a camera that stands still the sheet's size varies a little with its height over the table.
    ``expected`` is the agreement to hope for: what the state before reached on its own photo. ``closely`` looks at the
    photo before and at this one as finely as they were taken. ``own_camera`` says that the camera was told by this photo.
    """

    coarse: Scene
    fine: Scene
    handheld: bool = False
    expected: float = 1.0
    closely: Callable[[], tuple[Scene, Scene]] | None = None
    own_camera: bool = False
