"""Planes: which faces lie flat together, and which faces overlap (paper, "Origami State")."""

from collections.abc import Mapping

from folding_server.geometry.convex import bounding_box, boxes_meet, overlap
from folding_server.geometry.graph import components
from folding_server.simulator.paper import Paper


def planes(paper: Paper) -> list[list[int]]:
    """Maximal sets of faces joined by flat edges, each sorted, in the order of their lowest face id."""
    flat = (
        beside
        for beside in paper.edge_faces.values()
        if len(beside) == 2 and paper.back_up(beside[0]) == paper.back_up(beside[1])
    )
    return components(paper.faces, flat)


def plane_index(groups: list[list[int]]) -> Mapping[int, int]:
    """Face -> index of its plane."""
    return {face: i for i, group in enumerate(groups) for face in group}


def overlapping_pairs(paper: Paper) -> list[tuple[int, int]]:
    """All pairs (lower face, upper face) that overlap by more than the tolerance, in stack order."""
    outlines = {face: paper.polygon(face) for face in paper.order}
    boxes = {face: bounding_box(outline) for face, outline in outlines.items()}
    return [
        (lower, upper)
        for i, lower in enumerate(paper.order)
        for upper in paper.order[i + 1 :]
        if boxes_meet(boxes[lower], boxes[upper]) and overlap(outlines[lower], outlines[upper])
    ]
