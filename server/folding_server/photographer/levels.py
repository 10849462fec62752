"""What makes the levels of difficulty: the ranges from which a scene is drawn."""

from collections.abc import Mapping
from dataclasses import dataclass

from folding_server.errors import PhotoError

Range = tuple[float, float]


@dataclass(frozen=True)
class Level:
    """Ranges and amounts of one level.

    ``tilt`` degrees from straight down; ``turn`` degrees and ``shift`` sheet sides are normal deviations of
    the sheet's drift from frame to frame; ``unsteady`` the same for the camera's tilt in degrees;
    ``contrast`` the least perceived difference between the paper and the table; ``lamp`` how much brightness
    falls off across the picture; ``blur`` in pixels; ``noise`` in sRGB steps; ``quality`` of the JPEG;
    ``sway`` how much the light changes between frames; ``crooked`` and ``sloppy`` how far the sheet is from
    square and the folds are off, as parts of the sheet's side.

    With a ``zoom`` each photo has a camera of its own: so many times nearer than usual, its tilt drawn anew, rolled by ``roll``
    degrees and looking ``aside`` of the paper by so many sheet sides (normal deviations). ``curl`` is by how many degrees the
    flap that was folded last stands up; ``precreases`` and ``objects`` are the most creases of earlier folds and the most things on
    the table.
    """

    tilt: Range
    turn: float
    shift: float
    unsteady: float
    contrast: float
    tables: tuple[str, ...]
    pale_tables: bool
    patterns: bool
    lamp: Range
    warmth: float
    vignette: Range
    blur: Range
    noise: Range
    quality: int
    sway: float
    hands: float
    crooked: float
    sloppy: float
    zoom: Range | None = None
    roll: float = 0.0
    aside: float = 0.0
    curl: Range = (0.0, 0.0)
    precreases: int = 0
    objects: int = 0


LEVELS: Mapping[int, Level] = {
    1: Level(
        tilt=(0.0, 4.0),
        turn=0.8,
        shift=0.006,
        unsteady=0.0,
        contrast=34.0,
        tables=("plain",),
        pale_tables=False,
        patterns=False,
        lamp=(0.05, 0.15),
        warmth=0.01,
        vignette=(0.02, 0.08),
        blur=(0.4, 0.6),
        noise=(0.8, 1.4),
        quality=87,
        sway=0.0,
        hands=0.0,
        crooked=0.0,
        sloppy=0.0,
    ),
    2: Level(
        tilt=(4.0, 15.0),
        turn=2.5,
        shift=0.02,
        unsteady=0.1,
        contrast=20.0,
        tables=("plain",),
        pale_tables=True,
        patterns=True,
        lamp=(0.2, 0.45),
        warmth=0.05,
        vignette=(0.05, 0.2),
        blur=(0.6, 1.1),
        noise=(2.0, 3.5),
        quality=70,
        sway=0.0,
        hands=0.0,
        crooked=0.0,
        sloppy=0.0,
    ),
    3: Level(
        tilt=(4.0, 15.0),
        turn=2.5,
        shift=0.02,
        unsteady=0.15,
        contrast=20.0,
        tables=("wood", "mat", "cloth"),
        pale_tables=True,
        patterns=True,
        lamp=(0.15, 0.45),
        warmth=0.06,
        vignette=(0.05, 0.25),
        blur=(0.6, 1.1),
        noise=(1.5, 3.5),
        quality=75,
        sway=0.08,
        hands=0.45,
        crooked=0.01,
        sloppy=0.01,
    ),
    4: Level(
        tilt=(0.0, 25.0),
        turn=2.5,
        shift=0.02,
        unsteady=0.0,
        contrast=20.0,
        tables=("plain", "wood", "mat", "cloth"),
        pale_tables=True,
        patterns=True,
        lamp=(0.15, 0.45),
        warmth=0.06,
        vignette=(0.05, 0.25),
        blur=(0.6, 1.1),
        noise=(1.5, 3.5),
        quality=75,
        sway=0.08,
        hands=0.0,
        crooked=0.01,
        sloppy=0.01,
        zoom=(0.7, 1.6),
        roll=15.0,
        aside=0.1,
        curl=(1.0, 5.0),
        precreases=3,
        objects=3,
    ),
}


def level_named(number: int) -> Level:
    """The level with this number. PhotoError for any other than 1 to 4."""
    if number not in LEVELS:
        raise PhotoError(
            f"There is no level {number}; choose 1 (plain), 2 (uneven), "
            "3 (hands and textured tables) or 4 (a camera for each photo)."
        )
    return LEVELS[number]
