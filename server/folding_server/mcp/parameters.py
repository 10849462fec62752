"""The arguments that tools share, with what is allowed in words.

Each description is a noun phrase: hosts show it to their model, and a refusal says "must be" before it.
"""

from typing import Annotated

from folding_schemas.actions import Direction, FlipAxis
from pydantic import BeforeValidator, Field


def _whole(value: object) -> object:
    """A whole number that came as text or with a decimal point as an int; anything else as it is."""
    if isinstance(value, str) and value.strip().lstrip("+-").isdecimal():
        return int(value)
    return int(value) if isinstance(value, float) and value.is_integer() else value


RunId = Annotated[
    str | None,
    Field(
        description="the id of a run, as open_run answered it; left out, the run opened last in this process"
    ),
]
VertexIds = Annotated[tuple[int, int], Field(description="two vertex ids, [u, v]")]
Crease = Annotated[
    tuple[int, int] | None,
    Field(description="two vertex ids on the crease, [u, v]; left out, the newest fold still folded"),
]
Fraction = Annotated[
    float,
    Field(ge=0, le=1, description="a fraction of the way from u to v, between 0 and 1"),
]
Side = Annotated[
    Direction,
    BeforeValidator(_whole),
    Field(description="1 (the side above the line moves; right of an upright one) or -1 (the other side)"),
]
Degrees = Annotated[
    float,
    Field(allow_inf_nan=False, description="a number of degrees, positive clockwise"),
]
Axis = Annotated[FlipAxis, Field(description="one of x, y, y=x and y=-x")]
Frame = Annotated[int, Field(ge=1, description="a keyframe's number, from 1")]
LaterFrame = Annotated[int, Field(ge=2, description="the later keyframe's number, from 2")]
