"""What speaks against a photo, in sentences with the number that says so: too dark, too blurred, too small, drawn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.vision.comparison import Match
from folding_server.vision.drawings import even_share, is_drawing
from folding_server.vision.outline import Outline
from folding_server.vision.photos import Photos
from folding_server.vision.pose import Pose
from folding_server.vision.quads import LEAST_PICTURE_SHARE
from folding_server.vision.seeing import SequenceObserver
from folding_server.vision.sharpness import PixelSide, edge_width
from folding_server.vision.square import look_for_square
from folding_server.vision.square_refusals import too_small

BLURRED = 0.03
"""Width of the paper's edges, in sheet sides, from which a photo is blurred. Sharp photos, ray-traced and taken, have 0.003 to 0.014;
outlines of a match may be 0.02 apart (comparison.MATCHING_OUTLINE).
"""
BLURRED_PIXELS = 3.0
"""Pixels that an edge is wide at least in a photo that is blurred: a small one has none narrower than two."""
DARK = 50.0
"""Of 255, which the brightest hundredth of a photo must reach. Ray-traced photos and those of phones come to 130 and more."""
BRIGHTEST = 0.99
"""The quantile of the brightness of pixels that is looked at."""
SPARSE = 3
"""Of so many rows and columns one is looked at: the brightness of a photo needs no more."""
LEAST_SHEET_PIXELS = 64.0
"""Pixels of the sheet's side below which photos are looked at more finely than they were taken (seeing.COARSEST)."""


@dataclass(frozen=True)
class PhotoDoubts:
    """Sentences without a full stop: what ``spoils`` what is seen in a photo, and what is only to be known."""

    spoils: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def words(self) -> list[str]:
        """All sentences, the weightier ones first."""
        return [*self.spoils, *self.remarks]


def doubts_about(observer: SequenceObserver, frame: int, outlines: Sequence[Outline]) -> PhotoDoubts:
    """What speaks against a frame's photo, in which an observer sees paper of these ``outlines``.

    PhotoError if there is no such photo.
    """
    pose = observer.pose
    sides = [side for outline in outlines for side in _seen_sides(outline, pose)]
    spoils = _spoils(observer.photos.photo(frame), f"the photo of frame {frame}", sides, pose.pixels_per_unit)
    return PhotoDoubts(spoils, observer.remarks)


def doubts_about_start(photos: Photos) -> PhotoDoubts:
    """What speaks against the first photo of a sequence, also that it shows no flat sheet. PhotoError if it cannot be read."""
    rgb = photos.photo(1)
    try:
        found = look_for_square(rgb, "Frame 1")
    except PhotoError as refusal:
        return PhotoDoubts((str(refusal).removesuffix("."),))
    ends = [*found.corners, found.corners[0]]
    return PhotoDoubts(_spoils(rgb, "the photo of frame 1", list(pairwise(ends)), found.side), found.remarks)


def darkness(rgb: RgbImage, called: str) -> str | None:
    """That a photo is too dark, with the number; None if it is not."""
    level = float(np.quantile(rgb[::SPARSE, ::SPARSE].max(axis=2), BRIGHTEST))
    if level >= DARK:
        return None
    return (
        f"{called} is too dark: its brightest hundredth has {level:.0f} of 255, and {DARK:.0f} are needed; "
        "take it in more light"
    )


def without_match(match: Match, doubts: PhotoDoubts) -> Match:
    """A comparison that is no match where something spoils the photo."""
    spoilt = match.verdict == "MATCH" and doubts.spoils
    return replace(match, verdict="MISMATCH") if spoilt else match


def _spoils(rgb: RgbImage, called: str, sides: Sequence[PixelSide], unit: float) -> tuple[str, ...]:
    """What spoils a photo, of whose paper some sides are seen."""
    found = [darkness(rgb, called), _smallness(rgb, called, unit), _blur(rgb, called, sides, unit)]
    if found[0] is None and is_drawing(rgb):
        found.append(
            f"{called} looks like a drawing: {even_share(rgb):.0%} of it is perfectly even; photograph real paper"
        )
    return tuple(each for each in found if each is not None)


def _smallness(rgb: RgbImage, called: str, unit: float) -> str | None:
    share = unit**2 / (rgb.shape[0] * rgb.shape[1])
    small = unit < LEAST_SHEET_PIXELS or share < LEAST_PICTURE_SHARE
    return f"{called} is taken from too far away: {too_small(unit, rgb.shape)}" if small else None


def _blur(rgb: RgbImage, called: str, sides: Sequence[PixelSide], unit: float) -> str | None:
    width = edge_width(rgb, sides, unit)
    if width is None or width <= BLURRED or width * unit <= BLURRED_PIXELS:
        return None
    return (
        f"{called} is blurred: the paper's edges are {width:.3f} of the sheet wide, and {BLURRED:g} at most tells layers apart; "
        "hold the camera still and focus on the paper"
    )


def _seen_sides(outline: Outline, pose: Pose) -> list[PixelSide]:
    """The visible sides of an outline in pixels of the photo."""
    corners = pose.to_photo(outline.corners)
    ends = [*corners, corners[0]]
    return [side for side, seen in zip(pairwise(ends), outline.seen, strict=True) if seen]
