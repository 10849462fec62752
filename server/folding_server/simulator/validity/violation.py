"""What a validator finds wrong with a folded sheet."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "record",
    "isometry",
    "area",
    "planar",
    "tiling",
    "agreement",
    "parity",
    "letter",
    "Maekawa",
    "Kawasaki",
    "taco-taco",
    "taco-tortilla",
    "tortilla-tortilla",
]
"""The condition that fails; the last three are crossings of layers."""


@dataclass(frozen=True)
class Violation:
    """One broken condition: which parts of the paper it concerns and one sentence about it."""

    kind: Kind
    detail: str
    faces: tuple[int, ...] = ()
    edges: tuple[tuple[int, int], ...] = ()
    vertices: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.kind}: {self.detail}"


def listed(values: Iterable[object]) -> str:
    """Values as a reader would write them: ``3, 5 and 8``."""
    words = [str(value) for value in values]
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))
