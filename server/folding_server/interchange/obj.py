"""The folded model as a Wavefront OBJ mesh, its layers lifted apart so that they can be told apart."""

from folding_server.geometry.convex import area
from folding_server.simulator import Paper
from folding_server.simulator.plane_layers import layers_of_planes

LAYER_DISTANCE = 0.01
"""Distance between layers in sheet units: ten times that of stiff paper, for a sheet of 15 cm."""


def obj_text(paper: Paper, thickness: float = LAYER_DISTANCE) -> str:
    """One group a face, corners counter-clockwise seen from the front; z grows from layer to layer.

    Faces share no vertices: neighbours across a fold lie in different layers. Texture coordinates are the places on the
    unfolded sheet, by which they can be joined again.
    """
    height = {
        f: i * thickness for i, layer in enumerate(layers_of_planes(paper)) for plane in layer for f in plane
    }
    lines = ["# flat-folded sheet, layers apart", "o folded_sheet"]
    count = 0
    for face in paper.order:
        outline = paper.polygon(face)
        lines.append(f"g face_{face}")
        lines += [f"v {x:.9g} {y:.9g} {height[face]:.9g}" for x, y in outline]
        lines += [f"vt {x:.9g} {y:.9g}" for x, y in paper.sheet_polygon(face)]
        corners = [f"{corner}/{corner}" for corner in range(count + 1, count + len(outline) + 1)]
        lines.append("f " + " ".join(corners if _front_is_left(paper, face) else reversed(corners)))
        count += len(outline)
    return "\n".join(lines) + "\n"


def _front_is_left(paper: Paper, face: int) -> bool:
    """Whether the cycle of a face runs counter-clockwise on the front of the sheet."""
    return area(paper.sheet_polygon(face)) > 0
