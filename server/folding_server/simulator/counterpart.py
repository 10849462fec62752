"""A program carried out on two papers at once: exactly, and a little off.

Where folds miss their landmarks, cuts make other vertices than in the exact program, so every action is
carried over by the places of its vertices on the sheet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import dist

import numpy as np
from folding_schemas.actions import Action, AddVertex, Fold, Unfold

from folding_server.errors import ActionRefused
from folding_server.geometry.graph import edge_of
from folding_server.geometry.line import Point, between
from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.apply import apply
from folding_server.simulator.fold import fold_line
from folding_server.simulator.paper import Paper

SAME_VERTEX = 0.06
"""Two vertices this near on the sheet may be the same, one folded exactly and one not."""
SAME_MODEL = 0.12
"""No vertex of the imprecise model lies further than this from where it lies in the exact one."""


class NoCounterpart(Exception):
    """An action, so much off, makes another model, or none."""


@dataclass
class Counterpart:
    """Two papers, one folded exactly and one imprecisely; ``twin`` maps the vertices of the first."""

    exact: Paper
    real: Paper
    twin: dict[int, int]

    @classmethod
    def of(cls, exact: Paper, real: Paper) -> "Counterpart":
        """Two papers whose vertices have the same names."""
        return cls(exact, real, {v: v for v in exact.vertices_coords})

    def copy(self) -> "Counterpart":
        """The same two papers, to try something with."""
        return replace(self, twin=dict(self.twin))

    def carry_out(self, action: Action, off: float) -> Action:
        """Do an action on both; returns the one that the imprecise paper got. ``off`` in sheet sides. Raises NoCounterpart."""
        done = self._carried_over(action, off)
        before = set(self.exact.vertices_coords), set(self.real.vertices_coords)
        try:
            self.exact, self.real = apply(self.exact, action), apply(self.real, done)
        except ActionRefused as refusal:
            raise NoCounterpart from refusal
        for v in sorted(set(self.exact.vertices_coords) - before[0]):
            self.twin[v] = _nearest(
                self.real, self.exact.vertices_coords[v], set(self.real.vertices_coords) - before[1]
            )
        return done

    def _carried_over(self, action: Action, off: float) -> Action:
        if not isinstance(action, AddVertex | Fold | Unfold) or action.edge is None:
            return action
        if any(v not in self.twin for v in action.edge):
            raise NoCounterpart
        u, v = (self.twin[w] for w in action.edge)
        if isinstance(action, Fold):
            return action.model_copy(update={"edge": (u, v), "direction": self._direction(action, (u, v))})
        if isinstance(action, Unfold):
            return action.model_copy(update={"edge": (u, v)})
        place = between(self.real.vertices_coords[u], self.real.vertices_coords[v], action.position)
        edge = _edge_at(self.real, (u, v), place)
        p, q = self.real.vertices_coords[edge[0]], self.real.vertices_coords[edge[1]]
        length = dist(p, q)
        position = (dist(p, place) + off) / length
        least = min(0.5, 0.01 / length)
        position = round(float(np.clip(position, least, 1 - least)), 6)
        return action.model_copy(update={"edge": edge, "position": position})

    def _direction(self, action: Fold, edge: tuple[int, int]) -> int:
        """The direction that moves the same side, also where a line that should be vertical leans."""
        wanted = fold_line(self.exact, action.edge, action.direction)
        found = fold_line(self.real, edge, 1)
        return 1 if wanted.nx * found.nx + wanted.ny * found.ny > 0 else -1

    def same_model(self) -> bool:
        """Whether every vertex still lies about where it does in the exact model."""
        exact, real = self.exact.folded_vertices_coords, self.real.folded_vertices_coords
        return all(dist(exact[v], real[w]) <= SAME_MODEL for v, w in self.twin.items())


def _edge_at(paper: Paper, edge: tuple[int, int], place: Point) -> tuple[int, int]:
    """The edge itself, or where cuts have divided it the part that holds a place. Raises NoCounterpart."""
    if edge_of(*edge) in paper.edge_faces:
        return edge
    u, v = (paper.vertices_coords[w] for w in edge)
    along = (v[0] - u[0], v[1] - u[1])
    parts = [
        e if (q[0] - p[0]) * along[0] + (q[1] - p[1]) * along[1] > 0 else (e[1], e[0])
        for e in paper.edge_faces
        for p, q in [(paper.vertices_coords[e[0]], paper.vertices_coords[e[1]])]
        if all(dist(u, w) + dist(w, v) < dist(u, v) + TOLERANCE for w in (p, q))
        and dist(p, place) + dist(place, q) < dist(p, q) + TOLERANCE
    ]
    if not parts:
        raise NoCounterpart
    return min(parts)


def _nearest(paper: Paper, place: tuple[float, float], fresh: set[int]) -> int:
    """The vertex nearest to a place on the sheet, a fresh one if any is near. Raises NoCounterpart."""
    for candidates in (fresh, set(paper.vertices_coords)):
        near = _distances(paper.vertices_coords, place, candidates)
        if near and min(near)[0] <= SAME_VERTEX:
            return min(near)[1]
    raise NoCounterpart


def _distances(
    places: Mapping[int, tuple[float, float]], place: tuple[float, float], candidates: set[int]
) -> list[tuple[float, int]]:
    return [(dist(places[v], place), v) for v in candidates]
