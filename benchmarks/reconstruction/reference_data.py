"""Where the reference data lies: published programs, results and photos that are not part of this repository."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""The checkout."""
VARIABLE = "FOLDING_REFERENCE_DATA"
"""The environment variable that names the folder."""
REFERENCE = Path(os.environ.get(VARIABLE) or ROOT.parent / "shared")
"""The folder, whether it is there or not: the one that the variable names, or else ``shared`` beside the checkout."""
FIGURES = ROOT / "tests" / "data" / "programs"
"""The programs that the paper prints, which are part of this repository."""
