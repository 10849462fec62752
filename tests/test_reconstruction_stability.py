"""What people do to photos without meaning anything by it leaves the reconstruction as it is."""

from functools import cache
from pathlib import Path

import pytest
from paths import EXAMPLES
from reconstructing import Reconstruction, reconstruct
from stability import CHANGES, NAMES, changed_sequence, compared


@cache
def usual(name: str) -> Reconstruction:
    """The reconstruction of an example's photos as they are."""
    return reconstruct(EXAMPLES / name, "solver")


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", NAMES)
def test_photos_saved_moved_scaled_or_lit_otherwise_give_the_same_program(
    name: str, change: str, tmp_path: Path
) -> None:
    made = reconstruct(changed_sequence(EXAMPLES / name, change, tmp_path / name), "solver")
    assert compared(name, usual(name), made) == {"same": True, "exact": True}
