"""SVG to PNG, by resvg with fonts of our own: nothing of the system is needed and every machine draws the same."""

from functools import cache
from importlib.resources import files
from pathlib import Path

FONT_FAMILY = "DejaVu Sans"
"""The family of the packaged fonts, which ``svg.FONT`` names first."""
COVERED = "\u017f"
"""The packaged fonts have every letter up to this one, the last of Latin Extended-A (``fonts/README.md``)."""


def rasterise(svg: str, size: int | None = None) -> bytes:
    """The picture as PNG bytes, at its own size or scaled to ``size`` pixels wide.

    Letters that the packaged fonts lack, such as those of Chinese or Arabic, are taken from the system's fonts if it has them.
    """
    import resvg_py

    return resvg_py.svg_to_bytes(
        svg_string=svg,
        width=size,
        font_files=_fonts(),
        skip_system_fonts=max(svg) <= COVERED,  # reading a system's fonts may take longer than drawing
        sans_serif_family=FONT_FAMILY,
    )


@cache
def _fonts() -> list[str]:
    """The packaged font files."""
    folder = Path(str(files("folding_server.diagram") / "fonts"))
    return sorted(str(file) for file in folder.glob("*.ttf"))
