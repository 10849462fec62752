"""A folded state shows lines inside its silhouette where layers end and where creases lie."""

import numpy as np
import pytest
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import add_vertex, fold, new_paper, unfold
from folding_server.vision.borders import changes, visible_borders
from folding_server.vision.grid import grid_over

GRID = grid_over(96)
HALVES = add_vertex(add_vertex(new_paper(), (1, 2), 0.3), (3, 4), 0.7)
FOLDED = fold(HALVES, (5, 6), -1)


def columns(mask: np.ndarray) -> tuple[float, float]:
    """The least and greatest x, in sheet units, of a mask."""
    cols = np.nonzero(mask)[1]
    x = GRID.to_plane(np.stack([cols, np.zeros_like(cols)], axis=1))[:, 0]
    return float(x.min()), float(x.max())


def test_the_edge_of_a_flap_is_a_border_of_layers() -> None:
    borders = visible_borders(FOLDED, GRID, IDENTITY)
    low, high = columns(borders.layers)
    assert 0.58 < low <= high < 0.62
    assert borders.layers.sum() > 1.8 * GRID.pixels_per_unit
    assert not borders.creases.any()


def test_an_opened_fold_leaves_a_crease() -> None:
    borders = visible_borders(unfold(FOLDED), GRID, IDENTITY)
    low, high = columns(borders.creases)
    assert 0.28 < low <= high < 0.32
    assert not borders.layers.any()
    assert (borders.all == borders.creases).all()


def test_a_flat_sheet_shows_no_line() -> None:
    assert not visible_borders(new_paper(), GRID, IDENTITY).all.any()


def test_a_change_marks_both_pixels_and_ignores_the_table() -> None:
    values = np.array([[0, 1, 1, 2], [0, 1, 1, 2]], np.uint8)
    assert changes(values).tolist() == [[False, False, True, True]] * 2


def rows(mask: np.ndarray) -> tuple[float, float]:
    """The least and greatest y, in sheet units, of a mask."""
    found = np.nonzero(mask)[0]
    y = GRID.to_plane(np.stack([np.zeros_like(found), found], axis=1))[:, 1]
    return float(y.min()), float(y.max())


def test_a_crease_over_the_end_of_layers_below_shows_like_a_border() -> None:
    """A pleat whose end reaches beyond the fold below it, creased where it crosses that."""
    paper = new_paper()
    for edge, part in (
        ((4, 1), 0.2),
        ((3, 2), 0.2),
        ((5, 1), 0.25),
        ((6, 2), 0.25),
        ((5, 7), 0.5),
        ((6, 8), 0.5),
    ):
        paper = add_vertex(paper, edge, part)
    creased = unfold(fold(paper, (5, 6), -1))
    folded = fold(fold(creased, (7, 8), -1), (9, 10), 1)
    assert min(y for _, y in folded.folded_vertices_coords.values()) == pytest.approx(0.2)
    borders = visible_borders(folded, GRID, IDENTITY)
    low, high = rows(borders.layers)
    assert 0.38 < low < 0.41
    assert 0.49 < high < 0.52
    assert not borders.creases.any()
