"""Patterns whose flat-foldability and number of layer orders are known, many of them checked by Flat-Folder."""

import json

import pytest
from folding_server.interchange.fold_reading import read_crease_pattern
from folding_server.simulator.foldability import CreasePattern, check_pattern
from paths import SHARED

FOLDER = SHARED / "flatfold"
ROWS = [json.loads(line) for line in (FOLDER / "golden.jsonl").read_text().splitlines()]
KNOWN = [row for row in ROWS if row["valid"] is not None]
DISPLACED = [row for row in ROWS if row["class"] == "tolerance"]


def pattern(name: str) -> CreasePattern:
    return read_crease_pattern((FOLDER / "patterns" / f"{name}.fold").read_text())


@pytest.mark.parametrize("row", KNOWN, ids=lambda row: row["name"])
def test_a_known_pattern_has_its_verdict_and_number_of_orders(row):
    report = check_pattern(pattern(row["name"]))
    assert (report.foldable, report.states, report.capped) == (row["valid"], row["states"], False)


@pytest.mark.parametrize("row", [row for row in KNOWN if row["valid"]], ids=lambda row: row["name"])
def test_faces_found_from_the_edges_do_as_well(row):
    given = pattern(row["name"])
    report = check_pattern(CreasePattern(given.vertices_coords, given.edges_vertices, given.edges_assignment))
    assert (report.foldable, report.states) == (True, row["states"])


@pytest.mark.parametrize("row", DISPLACED, ids=lambda row: row["name"])
def test_a_displaced_vertex_is_forgiven_as_far_as_the_faces_still_close_up(row):
    report = check_pattern(pattern(row["name"]))
    assert report.foldable == (row["isometry_error"] < 1e-3)
    if row["flat_folder"]["verdict"] == "ok" and report.foldable:
        assert report.states == int(row["flat_folder"]["states"])


@pytest.mark.parametrize("name", [row["name"] for row in ROWS if row["class"] == "kawasaki-move"])
def test_a_moved_vertex_is_named_for_kawasaki(name):
    report = check_pattern(pattern(name))
    assert {found.condition for found in report.violations} == {"Kawasaki"}
    assert f"vertex {report.violations[0].vertex}" in report.reason


@pytest.mark.parametrize("name", [row["name"] for row in ROWS if row["class"] == "maekawa-flip"])
def test_a_flipped_letter_is_named_for_maekawa(name):
    assert "Maekawa" in {found.condition for found in check_pattern(pattern(name)).violations}
