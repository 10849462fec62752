"""Finding the small motion of the sheet in the table plane that makes a stack agree best with a photo."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import cos, exp, radians, sin

import numpy as np

from folding_server.arrays import Image
from folding_server.geometry.line import Point
from folding_server.geometry.similarity import Similarity
from folding_server.vision.labels import LabelImage
from folding_server.vision.registration.scene import FaceStack, Scene, soft

Vector = tuple[float, ...]


@dataclass(frozen=True)
class Aligned:
    """A motion of the sheet in the table plane and the agreement it gives, 0 to 1."""

    motion: Similarity
    agreement: float


@dataclass(frozen=True)
class Freedom:
    """How far a search may go at first: ``shift`` in sheet units, ``turn`` in degrees, ``scale`` as a logarithm.

    Each of ``halvings`` rounds halves the steps.
    """

    shift: float = 0.02
    turn: float = 2.0
    scale: float = 0.0
    halvings: int = 3


SCALES = (0.8, 1.25)
"""How much smaller or larger than in frame 1 the sheet may look: a hand-held camera moves a little."""


def nudged(motion: Similarity, pivot: Point, nudge: Vector) -> Similarity:
    """A motion followed by a shift (dx, dy), a clockwise turn in degrees and a scaling (log) about a moved pivot.

    The scale of the whole stays within SCALES, however large the nudge.
    """
    dx, dy, degrees, log_scale = nudge
    x, y = motion(pivot)
    now = motion.scale
    s = min(max(now * exp(log_scale), SCALES[0]), SCALES[1]) / now
    c, n = s * cos(radians(degrees)), s * sin(radians(degrees))
    return Similarity(c, n, -n, c, x + dx - c * x - n * y, y + dy + n * x - c * y).after(motion)


def climb(
    value: Callable[[Vector], float], start: Vector, steps: Sequence[float], halvings: int
) -> tuple[Vector, float]:
    """The best vector a pattern search finds: try each coordinate both ways, then on along the way it went.

    The steps are halved when nothing helps, and the whole is done once more from half of the first steps on, since a
    label image gives many small false summits. A step of 0 keeps its coordinate. Deterministic.
    """
    value = cache(value)
    here, best = start, value(start)
    for first in (1.0, 0.5):
        size = first
        before = best
        for _ in range(halvings + 1):
            here, best = _climbed(value, here, best, [size * step for step in steps])
            size /= 2
        if first == 1.0 and best == before:
            break
    return here, best


def _climbed(
    value: Callable[[Vector], float], here: Vector, best: float, steps: Sequence[float]
) -> tuple[Vector, float]:
    """The summit reached with steps of one size."""
    for _ in range(8):
        base, before = here, best
        for i, step in enumerate(steps):
            for tried in (_moved(here, i, step), _moved(here, i, -step)) if step else ():
                got = value(tried)
                if got > best:
                    here, best = tried, got
                    break
        if best == before:
            break
        onwards = tuple(2 * h - b for h, b in zip(here, base, strict=True))
        got = value(onwards)
        if got > best:
            here, best = onwards, got
    return here, best


def _moved(vector: Vector, i: int, step: float) -> Vector:
    return (*vector[:i], vector[i] + step, *vector[i + 1 :])


def descend(
    drawn: Callable[[Vector], LabelImage], scene: Scene, start: Vector, steps: Sequence[float], blur: float
) -> Vector:
    """The vector near ``start`` whose drawing differs least from the photo, both blurred, by damped least squares.

    Coupled coordinates (a crease and the drift of the sheet) are moved together, which a coordinate search cannot do.
    ``steps`` are the differences used for the slope, about a pixel's worth each; 0 keeps a coordinate. ``blur`` is in
    pixels. Levenberg-Marquardt; deterministic.
    """
    free = [i for i, step in enumerate(steps) if step]
    target, weight = scene.soft(blur), scene.weight
    here = start
    residual = (soft(drawn(here), blur) - target) * weight
    cost, damping = float(np.vdot(residual, residual)), 0.01
    slopes = np.empty((len(free), residual.size), np.float32)
    for _ in range(6):
        for row, i in zip(slopes, free, strict=True):
            row[:] = _slope(drawn, here, i, steps[i], blur, weight)
        gradient, normal = slopes @ residual.ravel(), slopes @ slopes.T
        improved = False
        for _ in range(3):
            change = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-6), gradient)
            tried = list(here)
            for i, amount in zip(free, np.clip(change, -6, 6), strict=True):
                tried[i] = here[i] + float(amount) * steps[i]
            new = (soft(drawn(tuple(tried)), blur) - target) * weight
            got = float(np.vdot(new, new))
            if got < cost:
                improved = cost - got > 1e-3 * cost
                here, residual, cost, damping = tuple(tried), new, got, damping / 4
                break
            damping *= 8
        if not improved:
            break
    return here


def _slope(
    drawn: Callable[[Vector], LabelImage], here: Vector, i: int, step: float, blur: float, weight: Image
) -> Image:
    """Half the change of the blurred drawing from one step below to one step above a coordinate, flattened."""
    up, down = soft(drawn(_moved(here, i, step)), blur), soft(drawn(_moved(here, i, -step)), blur)
    up -= down
    up *= 0.5 * weight
    return up.ravel()


def align(stack: FaceStack, scene: Scene, start: Similarity, freedom: Freedom) -> Aligned:
    """The motion near ``start`` under which a stack explains the scene best."""
    pivot = stack.center

    def drawn(nudge: Vector) -> LabelImage:
        return scene.draw(stack, nudged(start, pivot, nudge))

    def value(nudge: Vector) -> float:
        return scene.agreement_of(drawn(nudge))

    steps = (freedom.shift, freedom.shift, freedom.turn, freedom.scale)
    nudge, best = climb(value, (0.0, 0.0, 0.0, 0.0), steps, freedom.halvings - 1)
    nudge, best = polished(drawn, value, scene, nudge, best, _pixel_steps(scene, freedom.scale > 0))
    return Aligned(nudged(start, pivot, nudge), best)


def polished(
    drawn: Callable[[Vector], LabelImage],
    value: Callable[[Vector], float],
    scene: Scene,
    start: Vector,
    best: float,
    steps: Sequence[float],
) -> tuple[Vector, float]:
    """``start`` after two descents, coarser and finer, if its ``value`` is then no less than ``best``."""
    here = start
    for blur in (2.5, 1.0):
        tried = descend(drawn, scene, here, steps, blur)
        got = value(tried)
        if got >= best:
            here, best = tried, got
    return here, best


def _pixel_steps(scene: Scene, scale: bool) -> Vector:
    """Changes of (dx, dy, degrees, log scale) that move the paper's rim by about a pixel."""
    pixel = 1.0 / scene.grid.pixels_per_unit
    return (pixel, pixel, 100 * pixel, 2 * pixel if scale else 0.0)
