"""Pictures without anything of the system: the packaged renderer and its fonts, beside cairo."""

import io
import os
from types import ModuleType

import numpy as np
import pytest
from folding_server.diagram import draw_program_strip, draw_svg, rasterise
from folding_server.diagram.svg import svg_document, svg_text
from papers import CAT, figure, states
from PIL import Image

CELL = 8
"""Pixels a side of the cells that are compared: what renderers do differently, within a pixel, hardly changes a cell's mean."""
SAME = 8
"""The most by which a cell's mean colour may differ, of 255, without letters."""
SAME_LETTERS = 30
"""As ``SAME``, with letters, which cairo moves to whole pixels; a missing label changes a cell by twice as much."""


@pytest.fixture(scope="module")
def cairo() -> ModuleType:
    """The other renderer, which needs the system's library cairo."""
    try:
        import cairosvg
    except OSError:
        assert not os.environ.get("CI"), "CI compares the renderers: scripts/setup test installs cairo"
        pytest.skip("the library cairo, which the pictures are compared with, is missing")
    return cairosvg


def cells(png: bytes) -> np.ndarray:
    """The mean colours of a picture's cells: (rows, columns, 3)."""
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    return np.asarray(picture.reduce(CELL)).astype(int)


def pictures() -> dict[str, tuple[str, int | None, int]]:
    """Pictures with all that ours are made of: SVG, width in pixels, what cells may differ by."""
    cat = states(figure(CAT))
    return {
        "paper": (draw_svg(cat[-1]), None, SAME),
        "scaled": (draw_svg(cat[-1]), 1000, SAME),
        "labels": (draw_svg(cat[-1], labels=True), None, SAME_LETTERS),
        "marks": (draw_svg(cat[3], labels=True, size=400), 600, SAME_LETTERS),
        "strip": (draw_program_strip(figure(CAT)), None, SAME_LETTERS),
    }


@pytest.mark.parametrize("kind", pictures())
def test_the_packaged_renderer_draws_what_cairo_draws(cairo: ModuleType, kind: str) -> None:
    svg, width, same = pictures()[kind]
    ours = cells(rasterise(svg, width))
    theirs = cells(cairo.svg2png(bytestring=svg.encode(), output_width=width))
    assert ours.shape == theirs.shape
    assert np.abs(ours - theirs).max() < same


def test_a_label_that_is_missing_would_be_seen() -> None:
    cat = states(figure(CAT))[-1]
    with_labels, without = (cells(rasterise(draw_svg(cat, labels=labels))) for labels in (True, False))
    assert np.abs(with_labels - without).max() > 2 * SAME_LETTERS


@pytest.mark.parametrize("text", ["12,14", "Fuchs und Käfer", "Журавль →"])
def test_letters_are_drawn_from_the_packaged_fonts_alone(text: str) -> None:
    """Every letter leaves ink of its own, unlike the boxes or gaps of a font that lacks it."""

    def ink(letters: str) -> np.ndarray:
        svg = svg_document(300, 40, "#ffffff", [svg_text(10, 28, letters, 20, "#000000")])
        return cells(rasterise(svg))

    pictures = {letter: ink(letter).tobytes() for letter in set(text) - {" "}}
    assert len(set(pictures.values())) == len(pictures)
    assert ink(" ").tobytes() not in pictures.values()
