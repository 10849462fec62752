"""The folded state S = (V, F, E, O, L) as models and hosts see it (paper, section "Origami State Representation")."""

from typing import Literal

from folding_schemas.wire import Wire

EdgeKind = Literal["B", "F", "M", "V"]


class FoldedState(Wire):
    """A flat-folded sheet: positions in sheet units (x right, y up), ids as strings.

    ``faces_orientations`` is 0 where the front of the sheet is up and 1 where the back is.
    ``layers`` goes from bottom to top: layer, then its planes, then the faces of a plane.
    """

    vertices: dict[str, tuple[float, float]]
    faces: dict[str, list[int]]
    faces_orientations: dict[str, Literal[0, 1]]
    edges: list[tuple[int, int, EdgeKind]]
    layers: list[list[list[int]]]
