"""What the page that shows a model is given: each state of a program, the sheet, the colours, the photos."""

from folding_schemas.state import FoldedState
from folding_schemas.wire import Wire


class ModelColors(Wire):
    """The sides of the sheet and an ink that shows on each, all ``#rrggbb``."""

    front: str
    back: str
    front_ink: str
    back_ink: str


class ModelStop(Wire):
    """The model after one action; the first stop is the flat sheet.

    ``step`` counts the program's steps from 1, 0 before the first; ``frame`` is the keyframe that the step leads to.
    ``crease`` is the pair of vertices the action was made through, None where it names none.
    """

    step: int
    frame: int
    text: str
    crease: tuple[int, int] | None
    moved_faces: list[int]
    state: FoldedState


class ModelView(Wire):
    """A model from its flat sheet to its last state.

    ``sheet_coords`` has the place of every vertex on the unfolded sheet, in sheet units as all positions here.
    ``window`` is (left, bottom, side) of a square around every state. ``photos`` are data URLs by keyframe, each
    filling that square. ``steps`` is how many steps the program has; ``left_out`` counts early stops that are not here,
    as they would make the answer too large.
    """

    title: str
    run_id: str | None
    steps: int
    sheet: tuple[float, float]
    colors: ModelColors
    window: tuple[float, float, float]
    sheet_coords: dict[str, tuple[float, float]]
    stops: list[ModelStop]
    photos: dict[int, str]
    left_out: int


class ModelShown(Wire):
    """Answer of ``show_model``: what the view shows, for hosts and models that do not see it.

    The view's own data, a ``ModelView``, travels beside it where no model reads it: in the answer's metadata.
    """

    run_id: str | None
    title: str
    stops: list[str]
    summary: str
