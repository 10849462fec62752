"""The five folding primitives and the programs made of them (paper, section "Folding Action Space")."""

from typing import Annotated, Literal

from pydantic import Field

from folding_schemas.wire import Wire

VertexPair = Annotated[
    tuple[int, int],
    Field(description="Two vertex ids, [u, v]."),
]
FlipAxis = Literal["x", "y", "y=x", "y=-x"]
Direction = Literal[1, -1]


class AddVertex(Wire):
    """Subdivide an existing edge at a fraction of the way from its first vertex."""

    action: Literal["add_vertex"] = "add_vertex"
    edge: VertexPair
    position: float


class Fold(Wire):
    """Fold along the line through two vertices; +1 moves the upper (or right) side, -1 the other."""

    action: Literal["fold"] = "fold"
    edge: VertexPair
    direction: Direction


class Unfold(Wire):
    """Undo the fold that made a crease; without an edge, the newest fold that is still folded."""

    action: Literal["unfold"] = "unfold"
    edge: VertexPair | None = None


class Rotate(Wire):
    """Turn the whole model in the plane by degrees, positive clockwise."""

    action: Literal["rotate"] = "rotate"
    angle: float


class Flip(Wire):
    """Turn the whole model over about an axis."""

    action: Literal["flip"] = "flip"
    axis: FlipAxis


Action = Annotated[AddVertex | Fold | Unfold | Rotate | Flip, Field(discriminator="action")]
Actions = tuple[Action, ...]
"""Actions in the order in which they are done."""


def action_text(action: Action) -> str:
    """An action as one writes a call of it, such as ``fold([1, 3], 1)``."""
    values = action.model_dump(mode="json", exclude={"action"}, exclude_none=True).values()
    return f"{action.action}({', '.join(map(str, values))})"


class Program(Wire):
    """An executable folding program: step k leads from keyframe k to keyframe k + 1.

    ``sheet`` is the width and height of the unfolded sheet; the square's side is the unit of length.
    """

    name: str = "untitled"
    front_color: str | None = None
    back_color: str | None = None
    sheet: tuple[float, float] = (1.0, 1.0)
    steps: tuple[Actions, ...] = ()
    comment: str | None = None
