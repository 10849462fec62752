"""How each action moves the paper: a part that turns about a line in space, a whole that turns in its plane."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from folding_schemas.actions import Action, Program, Rotate

from folding_server.geometry.isometry import Isometry, mirror_line, turn
from folding_server.geometry.line import Line, Point
from folding_server.photographer.framing import pivot_after
from folding_server.simulator import Paper, apply, new_paper
from folding_server.simulator.motions import moved
from folding_server.simulator.state_diff import moved_faces, origins

FLAT = 180.0
"""Degrees by which a part turns about its line until it lies flat again."""


@dataclass(frozen=True)
class Swing:
    """A fold, an unfold or a flip: faces that turn by 180 degrees about a line, out of the plane.

    ``paper`` is the paper afterwards, with its new creases; ``starts`` has the isometries that its moving faces
    had before. The normal of ``line`` points to the moving side; the part goes ``over`` the rest or under it.
    """

    action: Action
    before: Paper
    paper: Paper
    starts: Mapping[int, Isometry]
    line: Line
    over: bool

    @property
    def degrees(self) -> float:
        """By how much it turns in all."""
        return FLAT

    @property
    def whole(self) -> bool:
        """Whether nothing stays on the table."""
        return len(self.starts) == len(self.paper.faces)

    @property
    def reach(self) -> float:
        """How far from its line the moving part reaches, in sheet sides."""
        places = [
            m(self.paper.vertices_coords[v]) for f, m in self.starts.items() for v in self.paper.faces[f]
        ]
        return max(self.line.distance(place) for place in places)


@dataclass(frozen=True)
class Slide:
    """A turn of the whole ``paper`` on the table by ``degrees``, clockwise; 0 where nothing moves."""

    action: Action | None
    before: Paper
    degrees: float

    def motion(self, degrees: float) -> Isometry:
        """What a part of the turn does to folded places."""
        points = self.before.folded_vertices_coords.values()
        center = sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)
        return turn(degrees, center)

    def turned(self, degrees: float) -> Paper:
        """The paper on its way."""
        return moved(self.before, self.motion(degrees))


Movement = Swing | Slide


def movements(program: Program) -> list[tuple[Movement, ...]]:
    """The movements of each step in turn, at least one each; places are relative to the sheet's middle spot."""
    paper, spot = new_paper(program.sheet), (0.5, 0.5)
    found: list[tuple[Movement, ...]] = []
    for step in program.steps:
        done: list[Movement] = []
        for action in step:
            after, next_spot = apply(paper, action), pivot_after(spot, action)
            if action.action != "add_vertex":
                done.append(_movement(action, _about(paper, spot), _about(after, next_spot)))
            paper, spot = after, next_spot
        found.append(tuple(done) or (Slide(None, _about(paper, spot), 0.0),))
    return found


def _about(paper: Paper, spot: Point) -> Paper:
    """The paper with a spot as the origin of its folded places."""
    return moved(paper, Isometry(1, 0, 0, 1, -spot[0], -spot[1]))


def _movement(action: Action, before: Paper, after: Paper) -> Movement:
    return (
        Slide(action, before, action.angle) if isinstance(action, Rotate) else swing_of(action, before, after)
    )


def swing_of(action: Action, before: Paper, after: Paper) -> Swing:
    """How the part that lies elsewhere after a fold, an unfold or a flip got there. ``action`` names it."""
    origin = origins(before, after)
    faces = moved_faces(before, after)
    starts = {f: before.isometries[origin[f]] for f in faces}
    reflection = after.isometries[faces[0]].after(starts[faces[0]].inverse())
    line = _towards(
        mirror_line(reflection), [starts[f](after.vertices_coords[v]) for f in faces for v in after.faces[f]]
    )
    return Swing(action, before, after, starts, line, after.order[-1] in starts)


def _towards(line: Line, points: Sequence[Point]) -> Line:
    """The line with its normal to the side on which most of the points lie."""
    if sum(line.distance(p) for p in points) >= 0:
        return line
    return line.opposite()
