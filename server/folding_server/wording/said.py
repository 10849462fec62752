"""What is said of a move, free of any language: what is brought where, through how many layers, and which points are marked."""

from dataclasses import dataclass, field

from folding_schemas.actions import FlipAxis

PlaceKey = str
"""A named point such as ``corner.top``, or ``letter.A``."""
LineKey = str
"""A named line such as ``edge.top``, or ``edge:FROM:TO`` or ``crease:FROM:TO`` between two named points."""


@dataclass(frozen=True)
class OnLine:
    """A letter for the point a ``part`` of the way along a line, from its left end, of an upright line its lower end."""

    letter: str
    line: LineKey
    part: float
    upright: bool = False


@dataclass(frozen=True)
class InBox:
    """A letter for the point so many parts of the model's width from its left and of its height from its bottom."""

    letter: str
    across: float
    up: float


@dataclass(frozen=True)
class OnSheet:
    """A letter for a point of the unfolded sheet, in sides from its left and from its lower border: hidden points have no other name."""

    letter: str
    x: float
    y: float


MarkedPoint = OnLine | InBox | OnSheet


@dataclass(frozen=True)
class SaidFold:
    """A fold by an axiom: its ``places`` and ``lines`` in the order in which they are said.

    Which part moves is plain where something is brought somewhere; else ``flap`` is a place on it, or ``side`` the side of it.
    With ``repeat`` the same is done on the other side, left and right swapped. ``layers`` says how many are folded at once, of ``of`` that lie there.
    """

    axiom: int
    places: tuple[PlaceKey, ...] = ()
    lines: tuple[LineKey, ...] = ()
    flap: PlaceKey | None = None
    side: str | None = None
    layers: int = 1
    of: int = 1
    marks: tuple[MarkedPoint, ...] = ()
    behind: bool = False
    unfold: bool = False
    repeat: bool = False


@dataclass(frozen=True)
class SaidUnfold:
    """The newest fold opened, or that of the crease between two places."""

    places: tuple[PlaceKey, ...] = ()
    marks: tuple[MarkedPoint, ...] = ()


@dataclass(frozen=True)
class SaidTurnOver:
    """The whole model turned over about an axis."""

    axis: FlipAxis


@dataclass(frozen=True)
class SaidTurn:
    """The whole model turned in its plane by degrees, positive clockwise."""

    angle: float


@dataclass(frozen=True)
class SaidMarks:
    """Points marked and nothing folded."""

    marks: tuple[MarkedPoint, ...] = field(default_factory=tuple)


Said = SaidFold | SaidUnfold | SaidTurnOver | SaidTurn | SaidMarks
