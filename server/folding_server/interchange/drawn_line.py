"""A straight line as it is drawn on a sheet."""

from dataclasses import dataclass

from folding_server.geometry.line import Point
from folding_server.simulator.foldability import Assignment

COINCIDENT = 1e-5
"""Points nearer than this, in units of the drawing's longer side, are one: coordinates may be rounded to five digits."""


@dataclass(frozen=True)
class DrawnLine:
    """A straight line from one point to another, in any unit, with the assignment of the crease it stands for."""

    start: Point
    end: Point
    assignment: Assignment
