"""Tells hands from paper and table in still pictures, by what the pictures without hands have shown."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from folding_server.frames.differences import Mask, Small, border_ring, difference, regions, usual
from folding_server.frames.stillness import Watched

TOUCHED_PART = 0.02
_SAMPLES = 120
_TABLE_SAMPLES = 24
_BIN = 20
_BINS = 256 // _BIN + 1
_LEAST_SHARE = 0.01
_REPAINTED = 24.0


@dataclass(frozen=True)
class Scene:
    """What a folding video shows without hands: the table as it mostly looks, and the colours of the paper.

    `table` is RGB of shape (height, width, 3). `paper` is True for each coarse colour of the paper, shape
    (bins, bins, bins), None where the hands never leave. `free` tells which still spans have no hand.
    """

    table: Small = field(repr=False, compare=False)
    paper: Mask | None = field(repr=False, compare=False)
    free: tuple[bool, ...]

    def changed(self, before: Small, after: Small, least: float, *, free: bool) -> bool:
        """Whether the paper differs in a region of `least` pixels; `free`: no hand is in either picture.

        With hands, only what is plainly table or paper in both pictures counts, and nothing at the border.
        """
        differs = difference(before, after)
        if free:
            return regions(differs, least) > 0
        if self.paper is not None:
            differs &= self._plain(before) & self._plain(after)
        return regions(differs, least, border_ring(after.shape)) > 0

    def _plain(self, picture: Small) -> Mask:
        """Where the picture shows the table or a colour of the paper."""
        plain: Mask = ~difference(self.table, picture, _REPAINTED)
        if self.paper is not None:
            plain |= self.paper[_coarse(picture)]
        return plain


def know_scene(watched: Watched) -> Scene:
    """What the table, the paper and the border look like in a video with at least one still span."""
    pictures = np.array([still.picture for still in watched.stills])
    free = _hands_free(watched)
    bare = pictures[np.flatnonzero(free)] if any(free) else pictures
    shape = pictures.shape[1:]
    table = usual(bare[:: -(-len(bare) // _TABLE_SAMPLES)].reshape(-1, shape[0] * shape[1], 3)).reshape(shape)
    return Scene(table, _paper_colors(bare, table) if any(free) else None, tuple(free))


def _hands_free(watched: Watched) -> list[bool]:
    """For each still span, whether the border of its picture looks as it mostly does."""
    ring = border_ring(watched.stills[0].picture.shape)
    step = -(-len(watched.border) // _SAMPLES)
    bare = usual(watched.border[::step])[None]
    parts = [float(difference(bare, still.picture[ring][None]).mean()) for still in watched.stills]
    return [part < TOUCHED_PART for part in parts]


def _paper_colors(pictures: NDArray[np.float32], table: Small) -> Mask:
    """The coarse colours, and their neighbours, of what is not table in `pictures` without hands."""
    counts = np.zeros((_BINS, _BINS, _BINS))
    for picture in pictures:
        other = difference(table, picture)
        np.add.at(counts, tuple(bins[other] for bins in _coarse(picture)), 1)
    common = counts > _LEAST_SHARE * max(1.0, counts.sum())
    wide = np.zeros(common.shape, np.bool_)
    for red, green, blue in np.argwhere(common):
        wide[max(0, red - 1) : red + 2, max(0, green - 1) : green + 2, max(0, blue - 1) : blue + 2] = True
    return wide


def _coarse(picture: Small) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Each pixel's bin of red, green and blue."""
    bins = np.clip(picture // _BIN, 0, _BINS - 1).astype(np.intp)
    return bins[..., 0], bins[..., 1], bins[..., 2]
