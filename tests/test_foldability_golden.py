"""Patterns of the reference data, whose flat-foldability and number of layer orders Flat-Folder has checked."""

from typing import Any

import pytest
from folding_server.interchange.fold_reading import read_crease_pattern
from folding_server.simulator.foldability import CreasePattern, check_pattern
from reference import golden_file, golden_rows


def pattern(row: dict[str, Any]) -> CreasePattern:
    return read_crease_pattern(golden_file(row).read_text())


@pytest.mark.parametrize("row", golden_rows(lambda row: row["valid"] is not None))
def test_a_known_pattern_has_its_verdict_and_number_of_orders(row):
    report = check_pattern(pattern(row))
    assert (report.foldable, report.states, report.capped) == (row["valid"], row["states"], False)


@pytest.mark.parametrize("row", golden_rows(lambda row: row["valid"]))
def test_faces_found_from_the_edges_do_as_well(row):
    given = pattern(row)
    report = check_pattern(CreasePattern(given.vertices_coords, given.edges_vertices, given.edges_assignment))
    assert (report.foldable, report.states) == (True, row["states"])


@pytest.mark.parametrize("row", golden_rows(lambda row: row["class"] == "tolerance"))
def test_a_displaced_vertex_is_forgiven_as_far_as_the_faces_still_close_up(row):
    report = check_pattern(pattern(row))
    assert report.foldable == (row["isometry_error"] < 1e-3)
    if row["flat_folder"]["verdict"] == "ok" and report.foldable:
        assert report.states == int(row["flat_folder"]["states"])


@pytest.mark.parametrize("row", golden_rows(lambda row: row["class"] == "kawasaki-move"))
def test_a_moved_vertex_is_named_for_kawasaki(row):
    report = check_pattern(pattern(row))
    assert {found.condition for found in report.violations} == {"Kawasaki"}
    assert f"vertex {report.violations[0].vertex}" in report.reason


@pytest.mark.parametrize("row", golden_rows(lambda row: row["class"] == "maekawa-flip"))
def test_a_flipped_letter_is_named_for_maekawa(row):
    assert "Maekawa" in {found.condition for found in check_pattern(pattern(row)).violations}
