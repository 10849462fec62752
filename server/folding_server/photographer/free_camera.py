"""A camera that takes each photo from another place: nearer, aside, rolled, tilted, as people hold a phone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import atan2, cos, degrees, exp, hypot, log, radians, sin

from folding_server.photographer.levels import Level
from folding_server.photographer.pinhole_camera import Camera, looking_down
from folding_server.photographer.rng import stream

BACK_OFF = 0.95
"""By which part of the nearness, and of the shift, a camera is left that does not see all of the paper."""
MOST_STEPS = 60
"""Steps back after which even a camera at a tenth of the distance would see all of it."""


@dataclass(frozen=True)
class Standpoint:
    """Where a camera is: ``lean`` is its tilt (degrees) along the table's x and y, ``roll`` about its own axis in degrees,
    ``nearness`` how many times larger than usual the sheet is seen, ``aside`` the point of the table (sheet sides) in the
    picture's middle.
    """

    lean: tuple[float, float]
    roll: float
    nearness: float
    aside: tuple[float, float]

    def between(self, other: "Standpoint", share: float) -> "Standpoint":
        """A part of the way to another standpoint."""

        def mixed(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
            return first[0] + share * (second[0] - first[0]), first[1] + share * (second[1] - first[1])

        return Standpoint(
            mixed(self.lean, other.lean),
            self.roll + share * (other.roll - self.roll),
            exp(log(self.nearness) + share * (log(other.nearness) - log(self.nearness))),
            mixed(self.aside, other.aside),
        )

    def camera(self, size: tuple[int, int], focal: float, distance: float) -> Camera:
        """The camera for pictures of a ``size`` (width, height) with a ``focal`` length in pixels, usually at a ``distance``."""
        tilt, azimuth = hypot(*self.lean), degrees(atan2(self.lean[1], self.lean[0]))
        return looking_down(size, focal, distance / self.nearness, tilt, azimuth, self.roll, self.aside)


def standpoints(seed: int, level: Level, keyframes: int) -> list[Standpoint]:
    """A new standpoint for each keyframe, drawn from a level's ranges."""
    return [_drawn(seed, level, keyframe) for keyframe in range(keyframes)]


def _drawn(seed: int, level: Level, keyframe: int) -> Standpoint:
    assert level.zoom is not None, "only levels with a zoom have a camera for each photo"
    rng = stream(seed, "standpoint", keyframe)
    tilt, azimuth = rng.uniform(*level.tilt), radians(rng.uniform(-180, 180))
    nearness = exp(rng.uniform(log(level.zoom[0]), log(level.zoom[1])))
    x, y = rng.normal(0, level.aside, 2)
    lean = (float(tilt * cos(azimuth)), float(tilt * sin(azimuth)))
    return Standpoint(lean, float(rng.normal(0, level.roll)), nearness, (float(x), float(y)))


def seeing_all(
    wanted: Sequence[Standpoint], sees_all: Callable[[int, Standpoint], bool]
) -> tuple[Standpoint, ...]:
    """The standpoints, further back and less aside where ``sees_all`` (of the keyframe and its standpoint) says that the picture
    cuts the paper.
    """
    found = []
    for keyframe, standpoint in enumerate(wanted):
        here = standpoint
        for _ in range(MOST_STEPS):
            if sees_all(keyframe, here):
                break
            aside = here.aside[0] * BACK_OFF, here.aside[1] * BACK_OFF
            here = replace(here, nearness=here.nearness * BACK_OFF, aside=aside)
        found.append(here)
    return tuple(found)
