"""What keeps a crease pattern from folding flat, with its places in the file."""

from dataclasses import dataclass
from typing import Literal

FaultKind = Literal[
    "Maekawa",
    "Kawasaki",
    "Big-little-big",
    "Single-vertex folding",
    "loose end",
    "no face",
    "one face",
    "crossing",
    "not joined",
    "not closed",
    "layers",
]
"""The condition that fails at a vertex, or what is wrong with creases and faces."""

PLACE_DECIMALS = 8
"""Digits after the point that words give at most; sheets are about 1 or 400 wide."""
FilePlace = tuple[float, ...]
"""Coordinates as the file gives them: (x, y), or (x, y, z) where it has three."""


@dataclass(frozen=True)
class Fault:
    """One fault: what kind, one sentence with its places, the vertices (as the pattern calls them) and the places.

    ``lines`` are pairs of places: the creases at fault, or the outline of a face at fault, side by side.
    """

    kind: FaultKind
    detail: str
    vertices: tuple[int, ...] = ()
    places: tuple[FilePlace, ...] = ()
    lines: tuple[tuple[FilePlace, FilePlace], ...] = ()


def said(place: FilePlace) -> str:
    """A place in words: ``(x, y)``, to six digits, what rounding leaves of zero as zero."""
    return f"({', '.join(f'{round(c, PLACE_DECIMALS) + 0.0:.6g}' for c in place)})"
