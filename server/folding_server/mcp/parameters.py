"""The arguments that tools share, with what is allowed in words.

Each description is a noun phrase: hosts show it to their model, and a refusal says "must be" before it. Numbers and
lists that come as text are read.
"""

import json
from typing import Annotated

from folding_schemas.actions import Direction, FlipAxis
from folding_schemas.results import Images
from pydantic import BeforeValidator, Field, WithJsonSchema


def _whole(value: object) -> object:
    """A whole number that came as text or with a decimal point as an int; anything else as it is."""
    if isinstance(value, str) and value.strip().lstrip("+-").isdecimal():
        return int(value)
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _listed(value: object) -> object:
    """Whole numbers that came as text, such as "[1, 3]" or "1, 3", as a list; anything else as it is."""
    if not isinstance(value, str):
        return value
    parts = value.strip().removeprefix("[").removesuffix("]").replace(",", " ").split()
    return parts if parts and all(part.isdecimal() for part in parts) else value


def _texts(value: object) -> object:
    """Texts that came as one text, such as a path or '["a.jpg", "b.jpg"]', as a list; anything else as it is."""
    if not isinstance(value, str):
        return value
    try:
        read = json.loads(value)
    except ValueError:
        return [value]
    return read if isinstance(read, list) else [value]


def _program_text(value: object) -> object:
    """A program that came as an object, as text: what it must be is checked where programs are read."""
    return value if value is None or isinstance(value, str) else json.dumps(value)


MOST_DEGREES = 360
"""One full turn either way: more means nothing else, and very large angles have no meaning in floating point."""

_PAIR = WithJsonSchema({"type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 2})
_SIDE = WithJsonSchema({"type": "integer", "minimum": -1, "maximum": 1})
READ_WHOLE = BeforeValidator(_whole)
"""Reads a whole number; stands after the bounds, which pydantic otherwise leaves out of the schema."""
_Whole = Annotated[int, READ_WHOLE]
READ_PROGRAM = BeforeValidator(_program_text)
"""Takes a program as an object or as text."""

RunId = Annotated[str | None, Field(description="a run's id; left out, the last opened")]
VertexIds = Annotated[
    tuple[_Whole, _Whole],
    BeforeValidator(_listed),
    _PAIR,
    Field(description="two vertex ids, [u, v]"),
]
Crease = Annotated[
    tuple[_Whole, _Whole] | None,
    BeforeValidator(_listed),
    _PAIR,
    Field(description="two vertex ids on the crease, [u, v]; left out, the newest fold still folded"),
]
Fraction = Annotated[
    float,
    Field(ge=0, le=1, description="a fraction of the way from u to v, between 0 and 1"),
]
Side = Annotated[
    Direction,
    READ_WHOLE,
    _SIDE,
    Field(
        description="1 (the side above the line moves; right of an upright one) or -1 (the other side); never 0"
    ),
]
Degrees = Annotated[
    float,
    Field(
        ge=-MOST_DEGREES,
        le=MOST_DEGREES,
        allow_inf_nan=False,
        description="a number of degrees from -360 to 360, positive clockwise",
    ),
]
Axis = Annotated[FlipAxis, Field(description="one of x, y, y=x and y=-x")]
FilePaths = Annotated[
    tuple[str, ...],
    BeforeValidator(_texts),
    WithJsonSchema({"type": "array", "items": {"type": "string"}}),
    Field(
        description="the path of a film, of a folder of photos in the order of their names, or of each photo in order"
    ),
]
ImageNumbers = Annotated[
    tuple[_Whole, ...] | None,
    BeforeValidator(_listed),
    WithJsonSchema({"type": "array", "items": {"type": "integer"}}),
    Field(
        description="increasing numbers of the images that are keyframes, as the contact sheet has them; left out, they are proposed"
    ),
]
Frame = Annotated[int, Field(ge=1, description="a keyframe's number, from 1"), READ_WHOLE]
LaterFrame = Annotated[int, Field(ge=2, description="the later keyframe's number, from 2"), READ_WHOLE]
StateOfAttempt = Annotated[
    int | None,
    Field(ge=1, description="a state of the attempt, from 1; left out, its last"),
    READ_WHOLE,
]
ImageSize = Annotated[Images, Field(description="none, small (half as wide) or full; left out, full")]
