"""Diagrams as pictures: colours, lines, scale, labels, strips."""

import io
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from folding_server.diagram import Colors, Panel, draw_panels_svg, draw_program_strip, draw_svg, rasterise
from folding_server.diagram.label_placement import place_labels
from folding_server.diagram.palette import contrast, diagram_colors, hex_color
from folding_server.diagram.view import VIEW_MARGIN, steady_view
from folding_server.diagram.visibility import visible_faces
from folding_server.errors import ProgramError
from folding_server.simulator import add_vertex, fold, new_paper, rotate, unfold
from papers import CAT, FIGURES, RABBIT, figure, states
from PIL import Image


def pixels(svg: str) -> np.ndarray:
    """The rendered picture."""
    return np.asarray(Image.open(io.BytesIO(rasterise(svg))).convert("RGB"))


def strokes(svg: str, name: str) -> str:
    """The path data of all elements of a class."""
    return "".join(e.get("d", "") for e in ET.fromstring(svg).iter() if e.get("class") == name)


def test_the_picture_has_the_asked_size_and_the_colours_of_the_sides() -> None:
    paper = fold(new_paper(), (4, 2), 1)
    image = pixels(draw_svg(paper, Colors("#112299", "#ffee00"), size=300))
    assert image.shape == (300, 300, 3)
    view = steady_view([paper], 300)
    x, y = view.pixel((0.66, 0.33))
    assert tuple(image[int(y), int(x)]) == (0xFF, 0xEE, 0x00)
    assert tuple(image[2, 2]) == tuple(bytes.fromhex(diagram_colors(Colors("#112299", "#ffee00")).table[1:]))


def test_marks_are_dashed_and_folds_are_solid() -> None:
    folded = fold(new_paper(), (4, 2), 1)
    assert not strokes(draw_svg(folded), "mark")
    opened = draw_svg(unfold(folded))
    assert strokes(opened, "mark").count("M") == 1
    assert strokes(opened, "line").count("M") == 4
    assert "stroke-dasharray" in opened


def test_a_mark_along_a_solid_line_is_not_drawn() -> None:
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.5), (3, 2), 0.5)
    paper = unfold(fold(paper, (5, 6), 1))
    assert strokes(draw_svg(paper), "mark").count("M") == 1
    paper = add_vertex(add_vertex(paper, (5, 1), 0.5), (6, 2), 0.5)
    flap_down_to_the_mark = fold(paper, (7, 8), 1)
    assert not strokes(draw_svg(flap_down_to_the_mark), "mark")


def test_flaps_that_meet_hide_what_lies_under_their_edges() -> None:
    """From behind, the rabbit's face shows a crease mark down the middle and no fold of the layers below."""
    rabbit = draw_svg(states(figure(RABBIT))[-1])
    assert strokes(rabbit, "mark").count("M") == 1
    assert "M384.00 152.83L384.00 384.00" not in strokes(rabbit, "line")


def test_one_sheet_unit_is_the_same_number_of_pixels_in_every_state() -> None:
    for path in FIGURES:
        scales = {steady_view([paper], 768).pixels_per_unit for paper in states(figure(path))}
        assert max(scales) - min(scales) < 1e-9


def test_every_state_lies_between_the_margins() -> None:
    for path in FIGURES:
        for paper in states(figure(path)):
            view = steady_view([paper], 768)
            corners = [
                value for point in paper.folded_vertices_coords.values() for value in view.pixel(point)
            ]
            assert min(corners) >= 768 * VIEW_MARGIN - 1e-6
            assert max(corners) <= 768 * (1 - VIEW_MARGIN) + 1e-6


def test_what_does_not_move_stays_in_place() -> None:
    before = rotate(new_paper(), 45)
    after = fold(before, (4, 2), 1)
    assert steady_view([before], 768).pixel(before.folded_vertices_coords[4]) == pytest.approx(
        steady_view([after], 768).pixel(after.folded_vertices_coords[4])
    )


def test_a_wide_sheet_fits_too() -> None:
    paper = rotate(new_paper((2.35, 1.0)), 30)
    view = steady_view([paper], 400)
    assert all(
        0 < value < 400 for point in paper.folded_vertices_coords.values() for value in view.pixel(point)
    )


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_labels_name_every_vertex_once_and_never_overlap(path: Path) -> None:
    for paper in states(figure(path)):
        view = steady_view([paper], 768)
        placed = place_labels(paper, visible_faces(paper), [], view)
        assert sorted(v for label in placed for v in label.ids) == sorted(paper.vertices_coords)
        for i, label in enumerate(placed):
            left, top, right, bottom = label.box
            assert 0 <= left < right <= 768
            assert 0 <= top < bottom <= 768
            for other in placed[:i]:
                a, b, c, d = other.box
                assert left >= c or a >= right or top >= d or b >= bottom


def test_coincident_vertices_share_a_label_and_covered_ones_are_grey() -> None:
    cat = states(figure(CAT))[-1]
    placed = place_labels(cat, visible_faces(cat), [], steady_view([cat], 768))
    assert [label.ids for label in placed if not label.visible] == [(1, 3)]
    assert (12, 14) in [label.ids for label in placed]
    texts = [e.text for e in ET.fromstring(draw_svg(cat, labels=True)).iter() if e.tag.endswith("text")]
    assert set(texts) == {",".join(map(str, label.ids)) for label in placed}


def test_a_strip_shows_every_state_with_its_actions() -> None:
    program = figure(CAT)
    svg = draw_program_strip(program, columns=5)
    texts = [e.text for e in ET.fromstring(svg).iter() if e.tag.endswith("text")]
    assert "rotate 45°" in texts
    assert "fold 10-11, + side" in texts
    assert len(ET.fromstring(svg).findall("{http://www.w3.org/2000/svg}g")) == len(program.steps) + 1
    assert rasterise(svg).startswith(b"\x89PNG")


def test_captions_are_escaped() -> None:
    svg = draw_panels_svg([Panel(new_paper(), ("<b> & c",))])
    assert "<b> & c" in [e.text for e in ET.fromstring(svg).iter()]


@pytest.mark.parametrize("color", ["blurple", "#12", "", "rgb(", "url(x)"])
def test_an_unknown_colour_is_named_in_one_sentence(color: str) -> None:
    with pytest.raises(ProgramError, match="is not a colour") as refused:
        draw_svg(new_paper(), Colors(front=color))
    assert repr(color) in str(refused.value)


@pytest.mark.parametrize(
    "color", ["white", "black", "red", "light blue", "#000000", "#777777", "navy", "DarkGreen"]
)
def test_ink_can_be_read_on_either_side(color: str) -> None:
    inks = diagram_colors(Colors(color, color))
    assert contrast(inks.front_ink, inks.front) >= 3
    assert hex_color(color) == inks.front
