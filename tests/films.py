"""A short film in memory: a hand folds the right part of the sheet over the left."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import cv2
import numpy as np
from folding_server.arrays import RgbImage
from folding_server.simulator import add_vertex, fold
from folding_server.simulator.paper import Paper, new_paper
from folding_server.vision.motion import ObservedMovement, movement
from folding_server.vision.seeing import SequenceObserver, see_sequence
from vision_scenes import GRID, SIDE, Look, PhotoList, paint

LOOK = Look()


@dataclass(frozen=True)
class Filmed(PhotoList):
    """Photos in memory with images before the last one."""

    images: Sequence[RgbImage] = field(default=(), repr=False)

    def between(self, frame: int, count: int | None) -> list[int]:
        """The indices of the images before the last photo."""
        return list(range(len(self.images)))[:count] if frame == self.frame_count else []

    def image(self, index: int) -> RgbImage:
        """One of them."""
        return self.images[index]


def halves() -> Paper:
    """A sheet marked at 0.6 of its width, above and below."""
    return add_vertex(add_vertex(new_paper(), (1, 2), 0.6), (3, 4), 0.4)


def lifted(reach: float, seed: int, light: float = 1.0) -> RgbImage:
    """The right part on its way over the line x = 0.6: its far edge seems to lie at ``reach``; a hand holds it."""
    photo = paint(new_paper(), LOOK, seed=seed).astype(np.float32)
    table = paint(_next_to_nothing(), LOOK, seed=seed + 50)
    left, right = (round(float(x)) for x in GRID.to_pixel([[0.6, 0.5], [1.0, 0.5]])[:, 0])
    top, bottom = SIDE // 4, 3 * SIDE // 4
    photo[top:bottom, left:right] = table[top:bottom, left:right]
    edge = round(float(GRID.to_pixel([[reach, 0.5]])[0, 0]))
    low, high = sorted((left, edge))
    photo[top:bottom, low:high] = LOOK.front if edge > left else LOOK.back
    tip = (edge, SIDE // 2)
    cv2.line(photo, (SIDE, SIDE // 2 + 20), tip, (205, 150, 115), 30)
    return np.clip(photo * light, 0, 255).astype(np.uint8)


def _next_to_nothing() -> Paper:
    """A sheet so small that the photo shows the bare table where the flap was."""
    return new_paper((0.01, 0.01))


def film() -> Filmed:
    """Two photos, the right part folded over at 0.6 in between, and four images of that."""
    folded = fold(halves(), (5, 6), 1)
    steps = [(0.9, 1.0), (0.75, 0.97), (0.5, 1.03), (0.35, 0.98)]
    images = [lifted(reach, i, light) for i, (reach, light) in enumerate(steps)]
    return Filmed([paint(new_paper(), LOOK), paint(folded, LOOK, seed=9)], images=images)


@cache
def eyes_on_film() -> SequenceObserver:
    """The film as it is seen. Tests of one process share it: what it remembers of images is never changed."""
    return see_sequence(film())


@cache
def film_movement() -> ObservedMovement:
    """What moves between the film's two photos."""
    found = movement(eyes_on_film(), 2)
    assert found is not None
    return found
