"""What the breadth-first search tries from a state: turns, flips, unfolds, and folds through two points."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from itertools import combinations
from typing import get_args

from folding_schemas.actions import FlipAxis, VertexPair
from folding_schemas.state import FoldedState

from folding_client.messages import JsonObject, ToolResult
from folding_client.search.frame_search import Calls

LineEnd = int | VertexPair
"""A vertex by its id, or the middle of an edge by the edge's vertices."""
_TURNS = (45, 90, 135, 180, 225, 270, 315)
"""Degrees: a sheet turned by less than an eighth is told by no baseline."""
_ROUNDED = 5
"""Decimals to which the positions of two states are compared, in sheet units."""


@dataclass(frozen=True)
class SearchMove:
    """A tool with its arguments; a fold has the two points of its line besides."""

    tool: str
    arguments: JsonObject = field(default_factory=dict)
    ends: tuple[LineEnd, ...] = ()


def moves_from(state: FoldedState) -> Iterator[SearchMove]:
    """The moves from a state, simplest first: motions, unfolds, then folds through vertices and middles of edges, those
    through fewer middles first. Many of them the server refuses.
    """
    yield from (SearchMove("flip", {"axis": axis}) for axis in get_args(FlipAxis))
    yield from (SearchMove("rotate", {"angle": angle}) for angle in _TURNS)
    folded = [(one, other) for one, other, kind in state.edges if kind in "MV"]
    yield from (SearchMove("unfold", {"edge": list(edge)}) for edge in folded)
    vertices: list[LineEnd] = sorted(map(int, state.vertices))
    middles: list[LineEnd] = [(one, other) for one, other, kind in state.edges if kind != "F"]
    pairs = list(combinations([*vertices, *middles], 2))
    pairs.sort(key=lambda pair: sum(isinstance(end, tuple) for end in pair))
    for pair in pairs:
        yield from (SearchMove("fold", {"direction": direction}, pair) for direction in (1, -1))


@dataclass(frozen=True)
class Carried:
    """How a move went: the actions that were carried out for it, and the answer to the last of them."""

    actions: int
    answer: ToolResult


def carried_out(move: SearchMove) -> Generator[Calls, list[ToolResult], Carried]:
    """Carry a move out, after the vertices that its line needs."""
    ids: list[object] = []
    added = 0
    for end in move.ends:
        if isinstance(end, int):
            ids.append(end)
            continue
        (answer,) = yield [("add_vertex", {"edge": list(end), "position": 0.5})]
        if answer.is_error:
            return Carried(added, answer)
        added += 1
        ids.append((answer.data or {})["new_vertices"][0])
    (answer,) = yield [(move.tool, move.arguments | ({"edge": ids} if ids else {}))]
    return Carried(added + (not answer.is_error), answer)


def look_of(state: FoldedState) -> frozenset[object]:
    """What two states have in common that look the same from above and below, whatever their vertices are called."""
    at = {
        name: tuple(round(value, _ROUNDED) + 0.0 for value in place) for name, place in state.vertices.items()
    }
    return frozenset(
        (
            depth,
            state.faces_orientations[str(face)],
            frozenset(at[str(vertex)] for vertex in state.faces[str(face)]),
        )
        for depth, layer in enumerate(state.layers)
        for plane in layer
        for face in plane
    )
