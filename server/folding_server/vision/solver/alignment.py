"""Finding the small motion of the sheet in the table plane that makes a stack agree best with a photo."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, exp, radians, sin

from folding_server.simulator.plane_geometry import Isometry, Point
from folding_server.vision.solver.scene import Scene, Stack

Vector = tuple[float, ...]


@dataclass(frozen=True)
class Aligned:
    """A motion (a similarity as six numbers) and the agreement it gives, 0 to 1."""

    motion: Isometry
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


def nudged(motion: Isometry, pivot: Point, nudge: Vector) -> Isometry:
    """A motion followed by a shift (dx, dy), a clockwise turn in degrees and a scaling (log) about a moved pivot."""
    dx, dy, degrees, log_scale = nudge
    x, y = motion(pivot)
    s = exp(log_scale)
    c, n = s * cos(radians(degrees)), s * sin(radians(degrees))
    return Isometry(c, n, -n, c, x + dx - c * x - n * y, y + dy + n * x - c * y).after(motion)


def climb(
    value: Callable[[Vector], float], start: Vector, steps: Sequence[float], halvings: int
) -> tuple[Vector, float]:
    """The best vector a pattern search finds: try each coordinate both ways, then on along the way it went.

    The steps are halved when nothing helps, and the whole is done once more from half of the first steps on, since a
    label image gives many small false summits. A step of 0 keeps its coordinate. Deterministic.
    """
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


def align(stack: Stack, scene: Scene, start: Isometry, freedom: Freedom) -> Aligned:
    """The motion near ``start`` under which a stack explains the scene best."""
    pivot = stack.center

    def value(nudge: Vector) -> float:
        return scene.agreement(stack, nudged(start, pivot, nudge))

    steps = (freedom.shift, freedom.shift, freedom.turn, freedom.scale)
    nudge, best = climb(value, (0.0, 0.0, 0.0, 0.0), steps, freedom.halvings)
    return Aligned(nudged(start, pivot, nudge), best)
