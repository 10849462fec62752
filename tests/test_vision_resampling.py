"""Pictures carried from one grid to another stay where they are on the table."""

import numpy as np
import pytest
from folding_server.arrays import Floats
from folding_server.vision.grid import Grid, grid_over
from folding_server.vision.resampling import resampled
from hypothesis import given
from hypothesis import strategies as st

scales = st.floats(min_value=60.0, max_value=256.0)


def places(grid: Grid) -> Floats:
    """The plane coordinates of every pixel's centre, (rows, cols, 2)."""
    rows, cols = np.mgrid[: grid.rows, : grid.cols]
    return grid.to_plane(np.stack([cols, rows], axis=-1))


@pytest.mark.slow
@given(scales, scales)
def test_no_pixel_moves_whatever_the_sizes_round_to(first: float, second: float) -> None:
    old, new = grid_over(first), grid_over(second)
    carried = resampled(places(old).astype(np.float32), old, new)
    inner = (slice(4, -4), slice(4, -4))
    assert np.abs(carried[inner] - places(new)[inner]).max() < 0.02 / min(first, second)


def test_a_coarse_pixel_is_the_mean_of_what_it_covers() -> None:
    old, new = grid_over(160), grid_over(40)
    speckled = np.random.default_rng(0).normal(100, 20, (old.rows, old.cols)).astype(np.float32)
    blocks = speckled.reshape(new.rows, 4, new.cols, 4).mean(axis=(1, 3))
    assert np.abs(resampled(speckled, old, new) - blocks).max() < 0.01
