"""Moving the whole model: the actions ``rotate`` and ``flip``. The sheet's metric and the creases stay as they are."""

from dataclasses import replace
from math import isfinite

from folding_server.errors import ActionRefused
from folding_server.geometry.isometry import Isometry, turn
from folding_server.simulator.paper import Paper

FLIP_AXES = ("x", "y", "y=x", "y=-x")


def rotate(paper: Paper, angle: float) -> Paper:
    """Turn the model by degrees, positive clockwise, about the mean of its folded vertices.

    Raises ActionRefused unless the angle is a finite number.
    """
    if not isfinite(angle):
        raise ActionRefused(f"Angle {angle} is not a number of degrees; give a finite one such as 45 or -90.")
    points = paper.folded_vertices_coords.values()
    center = sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)
    return moved(paper, turn(angle, center))


def flip(paper: Paper, axis: str) -> Paper:
    """Turn the model over: ``x`` maps (x, y) to (w - x, y), ``y`` to (x, h - y), ``y=x`` to (y, x), ``y=-x`` to (-y, -x).

    w and h are the sheet's width and height. The stack reverses and every face shows its other side. Raises
    ActionRefused for another axis.
    """
    width, height = paper.sheet
    motions = {
        "x": Isometry(-1, 0, 0, 1, width, 0),
        "y": Isometry(1, 0, 0, -1, 0, height),
        "y=x": Isometry(0, 1, 1, 0, 0, 0),
        "y=-x": Isometry(0, -1, -1, 0, 0, 0),
    }
    if axis not in motions:
        raise ActionRefused(f"Axis {axis!r} is unknown; flip about one of {', '.join(FLIP_AXES)}.")
    return replace(moved(paper, motions[axis]), order=paper.order[::-1])


def moved(paper: Paper, motion: Isometry) -> Paper:
    """The whole model carried by one isometry of the plane, the stack as it is."""
    return replace(paper, isometries={f: motion.after(t) for f, t in paper.isometries.items()})
