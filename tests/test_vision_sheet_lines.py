"""Lines that the flat sheet has before anything is folded: they are known in every photo after it."""

import cv2
import numpy as np
from folding_schemas.actions import AddVertex, Fold
from folding_server.geometry.isometry import IDENTITY, turn
from folding_server.simulator import Paper, apply, new_paper
from folding_server.vision.borders import visible_borders
from folding_server.vision.grid import grid_over
from folding_server.vision.sheet_lines import SheetLines, sheet_lines

GRID = grid_over(160.0, (-0.5, -0.5, 1.5, 1.5))


def crease_at(x: float) -> SheetLines:
    """A sheet that has an upright line at so many sheet units from its left."""
    edges = np.zeros((GRID.rows, GRID.cols), np.float32)
    (top, bottom) = np.rint(GRID.to_pixel([(x, 0.95), (x, 0.05)])).astype(int).tolist()
    cv2.line(edges, top, bottom, 1.0, 2)
    return sheet_lines(edges, GRID)


def book() -> Paper:
    """The right half folded over the left."""
    paper = apply(new_paper(), AddVertex(edge=(1, 2), position=0.5))
    paper = apply(paper, AddVertex(edge=(3, 4), position=0.5))
    return apply(paper, Fold(edge=(5, 6), direction=1))


def seen_at(lines: SheetLines, paper: Paper, points: list[tuple[float, float]]) -> list[bool]:
    shown = lines.shown(paper, visible_borders(paper, GRID, IDENTITY).topmost, GRID, IDENTITY)
    return [bool(GRID.under(np.array(point), shown)) for point in points]


def test_a_line_of_the_flat_sheet_is_known_where_it_was() -> None:
    assert seen_at(crease_at(0.3), new_paper(), [(0.3, 0.5), (0.7, 0.5)]) == [True, False]


def test_a_line_moves_with_the_layer_that_shows_it() -> None:
    folded = book()
    left = max(x for x, _ in folded.folded_vertices_coords.values()) < 0.75
    moved, stays = (0.8, 0.2) if left else (0.2, 0.8)
    there = [(stays, 0.5)]
    assert seen_at(crease_at(moved), folded, there) == [True]
    assert seen_at(crease_at(stays), folded, there) == [False]


def test_a_line_is_known_wherever_the_sheet_lies() -> None:
    paper, turned = new_paper(), turn(90.0, (0.5, 0.5))
    shown = crease_at(0.3).shown(paper, visible_borders(paper, GRID, turned).topmost, GRID, turned)
    across = [bool(GRID.under(np.array(p), shown)) for p in [(0.5, 0.7), (0.5, 0.3)]]
    assert sorted(across) == [False, True]


def test_a_sheet_full_of_lines_is_patterned_and_nothing_is_known_of_creases() -> None:
    edges = np.zeros((GRID.rows, GRID.cols), np.float32)
    edges[::8] = 1.0
    assert not sheet_lines(edges, GRID).near.any()
