"""What a diagram shows: exact visible regions and edges."""

import math
import random
from pathlib import Path

import pytest
import shapely
from folding_server.diagram.visibility import SLIVER, visible_faces, visible_spans
from folding_server.geometry.line import between
from folding_server.interchange.programs import load_published
from folding_server.simulator import Paper, add_vertex, fold, new_paper, unfold
from hypothesis import given, settings
from hypothesis import strategies as st
from papers import FIGURES, figure, random_paper, states
from paths import ROOT


def half_folded() -> Paper:
    """The square with its upper half folded down over the lower one."""
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.5), (3, 2), 0.5)
    return fold(paper, (5, 6), 1)


def test_a_flat_sheet_is_wholly_visible() -> None:
    paper = new_paper()
    (face,) = visible_faces(paper)
    assert face.whole
    assert not face.back_up
    assert face.area == pytest.approx(1.0)
    assert set(visible_spans(paper, [face])) == set(paper.edge_faces)


def test_a_covered_face_does_not_show() -> None:
    paper = half_folded()
    (face,) = visible_faces(paper)
    assert face.back_up
    assert face.area == pytest.approx(0.5)


def test_an_edge_under_another_layer_shows_only_where_it_comes_out() -> None:
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.75), (3, 2), 0.75)
    paper = fold(paper, (5, 6), 1)
    spans = visible_spans(paper, visible_faces(paper))
    assert spans[(4, 5)] == [pytest.approx((0.0, 2 / 3))]
    assert spans[(3, 4)] == [(0.0, 1.0)]


def test_a_crease_mark_between_two_visible_faces_is_one_stretch() -> None:
    paper = unfold(half_folded())
    spans = visible_spans(paper, visible_faces(paper))
    assert spans[(5, 6)] == [(0.0, 1.0)]


def test_layers_that_agree_but_for_the_tolerance_show_no_slivers() -> None:
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.5 + 2e-5), (3, 2), 0.5 + 2e-5)
    paper = fold(paper, (5, 6), 1)
    assert len(visible_faces(paper)) == 1


def test_no_hairline_stays_open_between_two_covering_faces() -> None:
    paper = states(figure(FIGURES[0]))[10]
    seen = visible_faces(paper)
    assert (5, 8) in visible_spans(paper, seen)
    (start, end), *more = visible_spans(paper, seen)[(5, 8)]
    assert not more
    assert abs(end - start) * 0.353553 == pytest.approx(0.250392 - 0.146447, abs=1e-3)


def test_a_narrow_face_that_nothing_covers_is_shown() -> None:
    paper = add_vertex(add_vertex(new_paper(), (4, 1), 0.9997), (3, 2), 0.9997)
    paper = unfold(fold(paper, (5, 6), 1))
    assert sum(face.area for face in visible_faces(paper)) == pytest.approx(1.0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_visible_regions_tile_the_silhouette(seed: int, folds: int) -> None:
    paper = random_paper(seed, folds)
    seen = visible_faces(paper)
    silhouette = shapely.union_all([shapely.Polygon(paper.polygon(face)) for face in paper.faces])
    outlines = sum(shapely.Polygon(paper.polygon(face)).length for face in paper.faces)
    assert math.isclose(sum(face.area for face in seen), silhouette.area, abs_tol=SLIVER * outlines)
    shapes = [shapely.MultiPolygon([(part[0], part[1:]) for part in face.parts]) for face in seen]
    # Without a grid, GEOS loses a whole face of some of these unions, of valid shapes all.
    together = shapely.union_all(shapes, grid_size=1e-9)
    assert sum(shape.area for shape in shapes) <= together.area + SLIVER * outlines


def solid_lines(paper: Paper) -> shapely.Geometry:
    """What is drawn solid: the visible stretches of boundary edges, of folds, and of creases beyond which nothing shows."""
    drawn, seen = [], visible_faces(paper)
    shown = {face.face for face in seen}
    for edge, spans in visible_spans(paper, seen).items():
        beside = paper.edge_faces[edge]
        if len({paper.isometries[face].mirrors for face in beside}) < len(beside) and shown.issuperset(
            beside
        ):
            continue
        for face in beside:
            ends = [paper.isometries[face](paper.vertices_coords[v]) for v in edge]
            drawn += [shapely.LineString([between(*ends, part) for part in span]) for span in spans]
    return shapely.union_all(drawn)


def undrawn_outline(paper: Paper) -> float:
    """How much of the outline of all faces together has no solid line, in sheet units; gaps shorter than a sliver cannot be seen."""
    faces = [shapely.Polygon(paper.polygon(face)).buffer(SLIVER) for face in paper.faces]
    outline = shapely.union_all(faces).buffer(-SLIVER).boundary
    gaps = shapely.get_parts(outline.difference(solid_lines(paper).buffer(4 * SLIVER)))
    return float(sum(gap.length for gap in gaps if gap.length > SLIVER))


@pytest.mark.parametrize(
    "program", sorted((ROOT / "examples" / "programs").glob("*.json")), ids=lambda p: p.stem
)
def test_the_outline_of_every_example_is_drawn(program: Path) -> None:
    for paper in states(load_published(program.read_text()).program):
        assert undrawn_outline(paper) == 0


def test_a_fold_that_a_vertex_above_meets_within_the_tolerance_is_drawn() -> None:
    """Two corners of a square are folded behind; the tip of what is folded up misses the folds by 5e-5."""
    heart = states(load_published((ROOT / "examples" / "programs" / "heart.json").read_text()).program)
    spans = visible_spans(heart[7], visible_faces(heart[7]))
    assert spans[(6, 8)] == [pytest.approx((0.0, 1.0), abs=1e-3)]
    assert spans[(7, 8)] == [pytest.approx((0.0, 1.0), abs=1e-3)]


def test_a_flat_crease_is_outline_where_only_a_sliver_lies_beyond_it() -> None:
    assert undrawn_outline(random_paper(19887, 4)) == 0


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_solid_lines_cover_the_outline(seed: int, folds: int) -> None:
    assert undrawn_outline(random_paper(seed, folds)) == 0


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(0, 10**6))
def test_the_face_shown_at_a_point_is_the_topmost_there(seed: int, folds: int, where: int) -> None:
    paper = random_paper(seed, folds)
    chance = random.Random(where)
    shapes = {face: shapely.Polygon(paper.polygon(face)) for face in paper.faces}
    seen = {
        f.face: shapely.MultiPolygon([(part[0], part[1:]) for part in f.parts]) for f in visible_faces(paper)
    }
    left, bottom, right, top = shapely.union_all(list(shapes.values())).bounds
    for _ in range(20):
        point = shapely.Point(chance.uniform(left, right), chance.uniform(bottom, top))
        if min(shape.boundary.distance(point) for shape in shapes.values()) < 2 * SLIVER:
            continue
        there = [face for face in paper.order if shapes[face].contains(point)]
        shown = [face for face, shape in seen.items() if shape.contains(point)]
        assert shown == there[-1:]
