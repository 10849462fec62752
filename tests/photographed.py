"""A folder of sequences with a sailboat of ours, photographed once for all tests of a process."""

import shutil
import tempfile
from collections.abc import Mapping
from functools import cache
from math import sqrt
from pathlib import Path
from typing import Any

from folding_schemas.actions import AddVertex, Fold, Program
from folding_server.photographer import photograph
from lasting import LASTING

SAILBOAT = Program(
    name="sailboat",
    front_color="#cfc8bc",
    back_color="#2f9bc1",
    steps=(
        (Fold(edge=(2, 4), direction=1),),
        (AddVertex(edge=(4, 1), position=2 - sqrt(2)), Fold(edge=(2, 5), direction=-1)),
        (
            AddVertex(edge=(2, 3), position=0.78),
            AddVertex(edge=(4, 2), position=0.22),
            Fold(edge=(6, 7), direction=-1),
        ),
    ),
)
"""A diagonal fold, the upper layer's edge folded to the diagonal, and the hull folded up."""
SEED, LEVEL, SIZE = 20, 2, (600, 600)
"""Of the photographer: seen askew, drifting, on a table with a pattern."""


@cache
def photos() -> Path:
    """The folder, to be served as it is."""
    folder = Path(tempfile.mkdtemp(prefix="folding-photos-"))
    LASTING.callback(shutil.rmtree, folder, ignore_errors=True)
    photograph(SAILBOAT, folder / SAILBOAT.name, SEED, LEVEL, SIZE)
    return folder


def vertex_pixels(frame: Mapping[str, Any]) -> dict[str, list[float]]:
    """Where each vertex lies in a picture, as the ``truth.json`` of a painted or a ray-traced sequence tells it."""
    pixels: dict[str, list[float]] = frame.get("vertex_pixels") or frame["camera"]["vertex_pixels"]
    return pixels
