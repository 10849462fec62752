"""Photos as label images of the table plane, in sheet units: the one entrance to perception."""

from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import cv2
import numpy as np

from folding_server.arrays import Image, Mask, RgbImage
from folding_server.vision.appearance import ColourModels
from folding_server.vision.camera import scales_of
from folding_server.vision.grid import FIELD_OF_VIEW, Grid, Reach, grid_over
from folding_server.vision.inner_lines import CURLED_RIM, RIM, inner_lines, strongest_near
from folding_server.vision.labels import UNKNOWN, LabelImage, is_paper
from folding_server.vision.learning import learn
from folding_server.vision.outline import Outline, find_outlines
from folding_server.vision.photos import Film, Photos
from folding_server.vision.pose import Pose, pose_of
from folding_server.vision.pose_estimation.picture_view import PictureView, picture_views
from folding_server.vision.resampling import resampled
from folding_server.vision.segmentation import Segmented, segment, smoothed_lab
from folding_server.vision.sheet_lines import SHEET_GRID, SheetLines, sheet_lines
from folding_server.vision.square import look_for_square
from folding_server.vision.table_memory import TableMemory, remember

Key = TypeVar("Key")
Value = TypeVar("Value")

FINEST_CLASSES = 160.0
"""Pixels per unit at which photos are segmented, at most."""
FINEST_LINES = 256.0
"""Pixels per unit at which creases and layer edges are looked for, at most."""
COARSEST = 64.0
"""Pixels per sheet unit at which photos are looked at, at least."""
SHARP = 1.8
"""A photo so many times finer than it is segmented shows its borders sharply there."""
USUAL_BETWEEN = 5
"""Images in between that are looked at unless more are asked for."""
FRAMES_KEPT = 64
"""Frames kept in memory."""
OTHERS_KEPT = 12
"""Cameras kept in memory beside the first photo's."""
NEW_CAMERA = (0.96, 1.04)
"""Scales at which the paper may be seen under a camera that was fitted to it: its outline tells the scale to a few hundredths."""


@dataclass(frozen=True)
class Observation:
    """One photo, seen straight from above.

    ``labels``      (rows, cols) uint8, see :mod:`folding_server.vision.labels`
    ``rgb``         (rows, cols, 3) uint8, the rectified photo
    ``confidence``  (rows, cols) float32, 0 to 1, how clear the class is: 0 where it is unknown
    ``edges``       (rows, cols) float32, 0 to 1, strength of lines within the paper (creases, layer edges)
    ``two_coloured`` False if the sides look alike: then all paper is FRONT, and so predictions are compared
    ``scales``      least and greatest scale, relative to frame 1, at which the paper may be seen
    ``outside``     (rows, cols), True beyond the edges of the photo; None if all is within
    ``sheet_lines`` lines that the sheet showed before it was folded; None for the first photo itself
    ``shaded``      how far from the borders of a class shading follows them, in sheet units: lines there are none of layers
    """

    frame: int
    labels: LabelImage
    rgb: RgbImage
    confidence: Image
    edges: Image
    grid: Grid
    two_coloured: bool
    scales: tuple[float, float]
    outside: Mask | None = None
    sheet_lines: SheetLines | None = None
    shaded: float = RIM

    @property
    def cut(self) -> float:
        """Along how much of its outline, in sheet units, the paper reaches to the edge of the photo."""
        if self.outside is None:
            return 0.0
        beyond = cv2.dilate(self.outside.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        rim = is_paper(self.labels) & beyond
        return float(
            np.count_nonzero(cv2.dilate(rim.astype(np.uint8), np.ones((3, 3), np.uint8)) & self.outside)
        ) / (self.grid.pixels_per_unit)

    @property
    def paper_confidence(self) -> float:
        """The mean confidence of all pixels that show paper, 0 to 1; 0 if none does."""
        paper = is_paper(self.labels)
        return float(self.confidence[paper].mean()) if paper.any() else 0.0


@dataclass(frozen=True)
class _Working:
    """A photo at the resolution at which it is segmented."""

    rgb: RgbImage
    shares: Image
    unknown: Mask
    clearness: Image
    same_table: bool
    edges: Image
    outside: Mask


@dataclass(frozen=True)
class SequenceObserver:
    """A sequence's pose and palette; segments photos when they are asked for, and remembers them.

    ``remarks`` are sentences about what else in the first photo might be the sheet; ``picture`` is the one photo that is looked
    at, where it was segmented before its camera was known, and ``first`` then the observer under the first photo's camera.
    """

    photos: Photos
    pose: Pose
    palette: ColourModels
    scales: tuple[float, float]
    memory: TableMemory | None = field(default=None, repr=False, compare=False)
    reach: Reach = FIELD_OF_VIEW
    remarks: tuple[str, ...] = ()
    picture: PictureView | None = field(default=None, repr=False, compare=False)
    first: "SequenceObserver | None" = field(default=None, repr=False, compare=False)
    _seen: dict[tuple[int, float], Observation] = field(default_factory=dict, repr=False, compare=False)
    _between: dict[tuple[int, float, int], tuple[Observation, ...]] = field(
        default_factory=dict, repr=False, compare=False
    )
    _working: dict[int, _Working] = field(default_factory=dict, repr=False, compare=False)
    _others: dict[tuple[Pose, Reach, Grid], "SequenceObserver"] = field(
        default_factory=dict, repr=False, compare=False
    )
    _pictures: dict[int, tuple[PictureView, ...]] = field(default_factory=dict, repr=False, compare=False)
    _sheet_lines: list[SheetLines] = field(default_factory=list, repr=False, compare=False)
    notes: list[tuple[Any, ...]] = field(default_factory=list, repr=False, compare=False)
    """What the solver found out about these photos last."""
    begun: list[tuple[Any, ...]] = field(default_factory=list, repr=False, compare=False)
    """What it found out about them by the usual hypotheses alone."""
    refinements: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)
    """What it found out about the creases of programs by them."""

    @property
    def two_coloured(self) -> bool:
        """Whether front and back can be told apart."""
        return self.palette.back is not None

    def under(self, pose: Pose, picture: PictureView, reach: Reach = FIELD_OF_VIEW) -> "SequenceObserver":
        """One photo as a camera of its own shows it, within left, bottom, right and top of the plane; the last few are remembered."""
        key = (pose, reach, picture.scene.grid)
        if key not in self._others:
            _drop_oldest(self._others, OTHERS_KEPT)
            self._others[key] = SequenceObserver(
                self.photos, pose, self.palette, NEW_CAMERA, reach=reach, picture=picture, first=self
            )
        return self._others[key]

    def pictures(self, number: int) -> tuple[PictureView, ...]:
        """A photo in its own coordinates, whatever the camera, one view for each piece that may be the sheet."""
        if number not in self._pictures:
            _drop_oldest(self._pictures, FRAMES_KEPT)
            self._pictures[number] = picture_views(self.photos.photo(number), self.palette)
        return self._pictures[number]

    def frame(self, number: int, pixels_per_unit: float = 96.0) -> Observation:
        """A photo's labels on a grid over FIELD_OF_VIEW. PhotoError if there is no such photo."""
        key = (number, pixels_per_unit)
        if key not in self._seen:
            _drop_oldest(self._seen, 2 * FRAMES_KEPT)
            self._seen[key] = self._as_seen(
                number, self._look(number), grid_over(pixels_per_unit, self.reach)
            )
        return self._seen[key]

    def between(
        self, number: int, pixels_per_unit: float = 64.0, count: int = USUAL_BETWEEN
    ) -> tuple[Observation, ...]:
        """Up to ``count`` of the images between photos ``number`` - 1 and ``number``, in order, seen like photos.

        Hands are UNKNOWN in them; inner lines are not looked for. Empty for frame 1 and where the sequence has
        no images in between. Each has the ``frame`` of the photo it leads to. PhotoError if there is no such
        photo.
        """
        if not isinstance(self.photos, Film):
            return ()
        key = (number, pixels_per_unit, count)
        if key not in self._between:
            _drop_oldest(self._between, FRAMES_KEPT // 8)
            images = [self.photos.image(i) for i in self.photos.between(number, count)]
            grid = grid_over(pixels_per_unit, self.reach)
            self._between[key] = tuple(
                self._as_seen(number, self._segmented(image, lines=False), grid) for image in images
            )
        return self._between[key]

    @property
    def sheet_lines(self) -> SheetLines:
        """The lines that the flat sheet shows in the first photo."""
        if self.first is not None:
            return self.first.sheet_lines
        if not self._sheet_lines:
            flat = self.frame(1, SHEET_GRID.pixels_per_unit)
            self._sheet_lines.append(sheet_lines(flat.edges, flat.grid))
        return self._sheet_lines[0]

    def closely(self, number: int) -> Observation:
        """A photo as finely as it was taken, within FINEST_LINES; its classes are no finer than FINEST_CLASSES."""
        seen = self.frame(number, _finest_grid(self.pose, self.reach).pixels_per_unit)
        rgb, _ = self.pose.rectify(self.photos.photo(number), seen.grid)
        return replace(seen, rgb=rgb)

    def stands(self, number: int) -> bool:
        """Whether the table proves that the camera stands where it stood at the first photo; a plain one proves nothing."""
        return self._look(number).same_table

    def outlines(self, number: int) -> tuple[Outline, ...]:
        """The outlines of the paper in a photo, largest piece first. PhotoError if there is no such photo."""
        working = self._look(number)
        grid = _working_grid(self.pose, self.reach)
        return find_outlines(self.photos.photo(number), self.pose, working.shares, working.unknown, grid)

    def _look(self, number: int) -> _Working:
        if number not in self._working:
            _drop_oldest(self._working, FRAMES_KEPT)
            self._working[number] = self._segmented(self.photos.photo(number))
        return self._working[number]

    def _segmented(self, photo: RgbImage, *, lines: bool = True) -> _Working:
        grid = _working_grid(self.pose, self.reach)
        rgb, seen = self.pose.rectify(photo, grid)
        mixed = 1 if self.pose.pixels_per_unit > SHARP * grid.pixels_per_unit else 2
        if self.picture:
            found = self.picture.rectified(self.pose, grid)
        else:
            found = segment(rgb, seen, grid, self.palette, self.memory, mixed=mixed)
        finest = _finest_grid(self.pose, self.reach)
        edges = self._lines(photo, found) if lines else np.zeros((finest.rows, finest.cols), np.float32)
        return _Working(rgb, found.shares, found.unknown, found.clearness, found.same_table, edges, ~seen)

    def _lines(self, photo: RgbImage, found: Segmented) -> Image:
        """Inner lines, looked for as finely as the photo allows."""
        old, grid = _working_grid(self.pose, self.reach), _finest_grid(self.pose, self.reach)
        rgb, _ = self.pose.rectify(photo, grid)
        shares = resampled(found.shares, old, grid)
        unknown = resampled(found.unknown.astype(np.float32), old, grid) > 0.01
        return inner_lines(rgb, np.asarray(shares, np.float32), np.asarray(unknown), grid.pixels_per_unit)

    def _as_seen(self, number: int, working: _Working, grid: Grid) -> Observation:
        """The working pictures on the grid that was asked for."""
        old = _working_grid(self.pose, self.reach)
        shares = np.asarray(resampled(working.shares, old, grid), np.float32)
        unknown = resampled(working.unknown.astype(np.float32), old, grid) > 0.5
        order = np.sort(shares, axis=-1)
        labels = np.where(unknown, UNKNOWN, shares.argmax(axis=-1)).astype(np.uint8)
        clear = resampled(working.clearness, old, grid)
        confidence = np.where(unknown, 0.0, clear * (order[..., -1] - order[..., -2])).astype(np.float32)
        rgb = np.asarray(resampled(working.rgb, old, grid), np.uint8)
        edges = strongest_near(working.edges, _finest_grid(self.pose, self.reach), grid)
        outside = np.asarray(resampled(working.outside.astype(np.float32), old, grid) > 0.5)
        return Observation(
            number,
            labels,
            rgb,
            confidence,
            edges,
            grid,
            self.two_coloured,
            self.scales,
            outside,
            self.sheet_lines if number > 1 else None,
            CURLED_RIM if self.picture else RIM,
        )


def see_sequence(photos: Photos) -> SequenceObserver:
    """Find the sheet in frame 1 and learn the colours. PhotoError if frame 1 shows no flat square."""
    found = look_for_square(photos.photo(1), f"Frame 1 of {photos.name}")
    pose = pose_of(found.corners)
    palette = learn(photos, pose)
    grid = _working_grid(pose)
    rgb, seen = pose.rectify(photos.photo(1), grid)
    memory = remember(smoothed_lab(rgb), seen, grid, palette.table)
    scales = scales_of(photos, pose, palette)
    return SequenceObserver(photos, pose, palette, scales, memory, remarks=found.remarks)


def _working_grid(pose: Pose, reach: Reach = FIELD_OF_VIEW) -> Grid:
    """The grid on which photos are segmented."""
    return grid_over(float(np.clip(round(pose.pixels_per_unit), COARSEST, FINEST_CLASSES)), reach)


def _finest_grid(pose: Pose, reach: Reach) -> Grid:
    """The grid on which lines are looked for."""
    return grid_over(float(np.clip(round(pose.pixels_per_unit), COARSEST, FINEST_LINES)), reach)


def _drop_oldest(kept: dict[Key, Value], limit: int) -> None:
    while len(kept) >= limit:
        del kept[next(iter(kept))]
