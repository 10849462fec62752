"""The files of ``data/results``: what a second folder comes to, and what a person can reckon."""

import json
from math import sqrt

import pytest
import shapely
from known_results import FROZEN, final_state, folded_plainly
from papers import OWN_RESULTS
from paths import DATA
from shapely.affinity import translate

WITHIN = 1e-5
"""Of the sheet's side: the programs give fractions with six decimals."""


def outline(name: str) -> shapely.Geometry:
    """What a frozen result covers, from its file alone."""
    final = json.loads((DATA / "results" / f"{name}.json").read_text())["final"]
    lies = {tuple(vertex["sheet"]): vertex["folded"] for vertex in final["vertices"]}
    faces = shapely.get_parts(
        shapely.polygonize([shapely.LineString(edge["sheet"]) for edge in final["edges"]])
    )
    assert shapely.area(faces).sum() == pytest.approx(1.0)
    folded = [shapely.Polygon([lies[corner] for corner in face.exterior.coords]) for face in faces]
    assert shapely.area(folded) == pytest.approx(shapely.area(faces), abs=WITHIN)
    return shapely.union_all(folded, grid_size=1e-7)


def test_there_is_a_file_for_each_frozen_program():
    assert {path.stem for path in OWN_RESULTS} == set(FROZEN)


@pytest.mark.parametrize("name", FROZEN)
def test_a_frozen_state_is_what_the_plain_folder_finds(name):
    recorded = json.loads((DATA / "results" / f"{name}.json").read_text())
    assert final_state(folded_plainly(recorded["actions"])) == recorded["final"]


def test_the_cup_is_the_trapezoid_that_the_roots_of_two_give():
    """Its base is 3 sqrt(2) - 4, its rim 2 - sqrt(2), its height sqrt(2) - 1; all eight faces lie on one another."""
    found = outline("cup")
    base, rim, height = 3 * sqrt(2) - 4, 2 - sqrt(2), sqrt(2) - 1
    expected = shapely.Polygon([(-base / 2, 0), (base / 2, 0), (rim / 2, height), (-rim / 2, height)])
    left, bottom, right, _ = found.bounds
    assert found.symmetric_difference(translate(expected, (left + right) / 2, bottom)).area < WITHIN
    assert found.area == pytest.approx(3 - 2 * sqrt(2), abs=WITHIN)
    final = json.loads((DATA / "results" / "cup.json").read_text())["final"]
    assert len(final["over"]) == 8 * 7 / 2


def test_the_house_has_a_right_angled_roof_over_the_middle():
    """Walls folded in by 0.24 on each side leave 0.76 between 0.12 and 0.88; the roof's sides run at 45 degrees."""
    roof = [(0.12, 0.62), (0.5, 1.0), (0.88, 0.62)]
    expected = shapely.Polygon([(0.12, 0.18), *roof, (0.88, 0.18)])
    assert outline("house").symmetric_difference(expected).area < WITHIN


def test_the_fan_is_a_rectangle_half_as_wide_as_the_sheet():
    left, bottom, right, top = outline("fan").bounds
    assert (right - left, top - bottom) == pytest.approx((0.75, 0.5), abs=WITHIN)
    assert outline("fan").area == pytest.approx(0.75 * 0.5, abs=WITHIN)


@pytest.mark.parametrize("name", ["heart", "samurai_hat", "shirt"])
def test_what_is_folded_on_both_sides_alike_is_symmetric(name):
    found = outline(name)
    mirrored = shapely.transform(found, lambda points: points * (-1, 1) + (1, 0))
    assert found.symmetric_difference(mirrored).area < WITHIN * found.length


def test_the_swan_s_neck_keeps_the_angle_of_the_kite_folded_twice():
    """Two kite folds leave a quarter of 45 degrees at the tip, on each side of the diagonal."""
    final = json.loads((DATA / "results" / "swan.json").read_text())["final"]
    assert len(final["front_up"]) == 12
    assert outline("swan").area < 0.25 / 2
