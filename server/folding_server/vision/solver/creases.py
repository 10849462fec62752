"""Moving a crease: by its two ends, about a vertex, or parallel to itself."""

from dataclasses import dataclass
from math import dist

from folding_server.geometry.line import Line, Point, line_through
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.scene import FaceStack
from folding_server.vision.solver.movable_layers import MovableLayers, MovingSet

LEAST_HALF_LENGTH = 0.05
"""The ends by which a crease is moved are at least twice this far apart (sheet units)."""


@dataclass(frozen=True)
class Family:
    """A line, or the lines got by turning it about ``pinned``, or by shifting it."""

    line: Line
    pinned: Point | None = None
    shifts: bool = False

    @property
    def free(self) -> bool:
        """Whether there is more than one line."""
        return self.shifts or self.pinned is not None

    def member(self, amount: float, handles: tuple[Point, Point]) -> Line:
        """The line got by moving the crease, or its handle farther from the pin, by an amount (sheet units)."""
        line = self.line
        if self.shifts:
            return Line(line.nx, line.ny, line.offset + amount)
        if self.pinned is None or not amount:
            return line
        pin = self.pinned
        far = max(handles, key=lambda h: dist(h, pin))
        return oriented(line_through(pin, (far[0] + amount * line.nx, far[1] + amount * line.ny)), line)


def handles_of(layers: MovableLayers, moving: MovingSet) -> tuple[Point, Point]:
    """The ends of the crease that a fold makes in its moving faces."""
    line = moving.line
    along: list[float] = []
    for face in moving.faces:
        outline = layers.outlines[face]
        for p, q in zip(outline, outline[1:] + outline[:1], strict=True):
            a, b = line.distance(p), line.distance(q)
            if a * b <= 0 and a != b:
                t = a / (a - b)
                x, y = p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])
                along.append(line.ny * x - line.nx * y)
    low, high = (min(along), max(along)) if along else (-0.5, 0.5)
    if high - low < LEAST_HALF_LENGTH:
        low, high = low - LEAST_HALF_LENGTH, high + LEAST_HALF_LENGTH
    return _on(line, low), _on(line, high)


def midpoint(p: Point, q: Point) -> Point:
    """Half way between two points."""
    return (p[0] + q[0]) / 2, (p[1] + q[1]) / 2


def shifted(handles: tuple[Point, Point], line: Line, first: float, second: float) -> Line:
    """The line with its two handles moved along its normal by two amounts (sheet units)."""
    (ax, ay), (bx, by) = handles
    new = line_through(
        (ax + first * line.nx, ay + first * line.ny), (bx + second * line.nx, by + second * line.ny)
    )
    return oriented(new, line)


def oriented(line: Line, like: Line) -> Line:
    """A line with its normal on the side of another's."""
    if line.nx * like.nx + line.ny * like.ny > 0:
        return line
    return line.opposite()


def _on(line: Line, along: float) -> Point:
    """The point of a line at a coordinate along it."""
    return line.nx * line.offset + line.ny * along, line.ny * line.offset - line.nx * along


class MovingCrease:
    """A fold whose crease can be moved by its two ends, along its normal and by so many sheet units each."""

    def __init__(self, paper: Paper, moving: MovingSet) -> None:
        self._layers, self._moving = MovableLayers(paper), moving
        self._handles = handles_of(self._layers, moving)

    def moved(self, ends: tuple[float, float]) -> MovingSet:
        """What turns along the moved crease; as before if nothing can."""
        line = shifted(self._handles, self._moving.line, *ends)
        return self._layers.moving_from(line, self._moving.seed) or self._moving

    def folded(self, ends: tuple[float, float]) -> FaceStack:
        """What the stack looks like after that fold."""
        return self._layers.folded(self.moved(ends))
