"""Tells hands from paper and table in still pictures, by what the pictures without hands have shown."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from folding_server.arrays import Float32s, Indices, Mask
from folding_server.frames.image_differences import (
    SmallImage,
    border_ring,
    changed_pixels,
    nudged_back,
    reaching,
    solid_area,
    usual,
)
from folding_server.frames.stillness import StillSpans

TOUCHED_PART = 0.007
"""The part of the border that looks strange where a hand comes in; a lamp or a nudge changes less."""
LEAST_FREE = 0.3
SHADOW_PART = 0.07
"""How far a hand's shadow reaches, as a part of the picture's shorter side."""
JOINED_PART = 0.08
"""A difference joined to a hand is the paper's if it is at least this part of the whole; else a bit of the hand."""
_SAMPLES = 120
_TABLE_SAMPLES = 24
_BIN = 20
_BINS = 256 // _BIN + 1
_LEAST_SHARE = 0.01
_REPAINTED = 24.0
"""How much a pixel must change, of 255, to be plainly of something else; shadows of hands are fainter."""


@dataclass(frozen=True)
class HandlessScene:
    """What a folding video shows without hands: the table as it mostly looks, and the colours of the paper.

    `table` is RGB of shape (height, width, 3). `paper` is True for each coarse colour of the paper, shape
    (bins, bins, bins). `free` tells which still spans have no hand, or says so of all of them where hands hardly
    ever leave and cannot be told from the rest.
    """

    table: SmallImage = field(repr=False, compare=False)
    paper: Mask = field(repr=False, compare=False)
    free: tuple[bool, ...]

    def changed(self, before: SmallImage, after: SmallImage, least: float, *, free: bool) -> bool:
        """Whether the paper differs in a region of `least` pixels; `free`: no hand is in either picture.

        With hands, only what is plainly table or paper in both pictures counts, clear of the hands' shadows.
        What a small motion of all that is seen explains is no change: a camera or a sheet that was nudged.
        """
        differs = self._differs_bare if free else self._differs_beside_hands
        if not differs(before, after, least):
            return False
        back = nudged_back(before, after, None if free else self._shown(before, after))
        return back is None or differs(before, back, least)

    def _differs_bare(self, before: SmallImage, after: SmallImage, least: float) -> bool:
        return solid_area(changed_pixels(before, after), least) > 0

    def _differs_beside_hands(self, before: SmallImage, after: SmallImage, least: float) -> bool:
        """Whether something differs clear of what comes in over the border, or much of what is joined to it."""
        ring = border_ring(after.shape)
        hand = reaching(changed_pixels(before, after), ring)
        plainly = changed_pixels(before, after, _REPAINTED) & self._shown(before, after)
        joined = solid_area(plainly & hand, least, ring)
        return joined > JOINED_PART * hand.sum() or solid_area(plainly & ~hand, least, ring) > 0

    def covered(self, picture: SmallImage) -> float:
        """The part of a picture that is neither table nor of a colour of the paper."""
        return 1 - float(self._plain(picture).mean())

    def _shown(self, before: SmallImage, after: SmallImage) -> Mask:
        """Where both pictures show table or paper, away from hands and their shadows.

        A hand is what is neither table nor paper in a difference that reaches the border.
        """
        plain = self._plain(before) & self._plain(after)
        strange = ~plain & reaching(changed_pixels(before, after), border_ring(after.shape))
        shown: Mask = plain & ~_around(strange)
        return shown

    def _plain(self, picture: SmallImage) -> Mask:
        """Where the picture shows the table or a colour of the paper."""
        plain: Mask = ~changed_pixels(self.table, picture, _REPAINTED) | self.paper[_coarse(picture)]
        return plain


def _around(strange: Mask) -> Mask:
    """The convex hulls of what is strange, and the shadows beside them: a hand is seen in parts where some of
    its shades are those of the paper or the table.
    """
    side = 2 * round(SHADOW_PART * min(strange.shape)) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    solid = cv2.morphologyEx(strange.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    joined = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, disc)
    outlines, _ = cv2.findContours(joined, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    for outline in outlines:
        cv2.fillConvexPoly(joined, cv2.convexHull(outline), 1)
    near: Mask = cv2.dilate(joined, disc) > 0
    return near


def handless_scene(watched: StillSpans) -> HandlessScene:
    """What the table, the paper and the border look like in a video with at least one still span."""
    pictures = np.array([still.picture for still in watched.stills])
    free = _hands_free(watched)
    bare = pictures[np.flatnonzero(free)]
    shape = pictures.shape[1:]
    table = usual(bare[:: -(-len(bare) // _TABLE_SAMPLES)].reshape(-1, shape[0] * shape[1], 3)).reshape(shape)
    return HandlessScene(table, _paper_colors(bare, table), tuple(free))


def _hands_free(watched: StillSpans) -> list[bool]:
    """For each still span, whether the border of its picture looks as it mostly does.

    True of all spans if that can be said of less than LEAST_FREE of the still time.
    """
    ring = border_ring(watched.stills[0].picture.shape)
    step = -(-len(watched.border) // _SAMPLES)
    bare = usual(watched.border[::step])[None]
    parts = [float(changed_pixels(bare, still.picture[ring][None]).mean()) for still in watched.stills]
    free = [part < TOUCHED_PART for part in parts]
    still = sum(still.seconds for still in watched.stills)
    seen = sum(still.seconds for still, bare in zip(watched.stills, free, strict=True) if bare)
    return free if seen >= LEAST_FREE * still else [True] * len(free)


def _paper_colors(pictures: Float32s, table: SmallImage) -> Mask:
    """The coarse colours, and their neighbours, of what is not table in `pictures` without hands."""
    counts = np.zeros((_BINS, _BINS, _BINS))
    for picture in pictures:
        other = changed_pixels(table, picture)
        np.add.at(counts, tuple(bins[other] for bins in _coarse(picture)), 1)
    common = counts > _LEAST_SHARE * max(1.0, counts.sum())
    wide = np.zeros(common.shape, np.bool_)
    for red, green, blue in np.argwhere(common):
        wide[max(0, red - 1) : red + 2, max(0, green - 1) : green + 2, max(0, blue - 1) : blue + 2] = True
    return wide


def _coarse(picture: SmallImage) -> tuple[Indices, Indices, Indices]:
    """Each pixel's bin of red, green and blue."""
    bins = np.clip(picture // _BIN, 0, _BINS - 1).astype(np.intp)
    return bins[..., 0], bins[..., 1], bins[..., 2]
