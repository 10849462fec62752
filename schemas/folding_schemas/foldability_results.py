"""Whether a crease pattern folds flat, as ``check_foldability`` answers."""

from typing import Literal

from folding_schemas.wire import Wire


class LocalViolation(Wire):
    """A vertex of the crease pattern at which a local flat-foldability condition fails."""

    vertex: int
    condition: Literal["Maekawa", "Kawasaki"]
    detail: str


class PatternFault(Wire):
    """A fault of a crease pattern: its kind, one sentence, and the places in the coordinates of the file or sheet."""

    kind: str
    detail: str
    vertices: list[int]
    places: list[list[float]]


class Foldability(Wire):
    """Answer of ``check_foldability``.

    ``states`` counts the layer orders found, up to a cap; ``capped`` says that there may be more. ``exact`` has all digits of the
    number where it is exact. ``notes`` say what was read otherwise than it stands, ``frame`` which frame of a file the answer is of.
    """

    foldable: bool
    reason: str
    violations: list[LocalViolation]
    states: int
    capped: bool
    exact: str = ""
    faults: list[PatternFault] = []
    notes: list[str] = []
    frame: int = 1
