"""The comparison with Flat-Folder: what was measured once is kept, and a run that did not end counts as its limit."""

import json
from pathlib import Path

import pytest
from crease_patterns import miura
from flat_folder import OUT_OF_TIME, SideBySide, kept_rows, ratio_of
from folding_server.interchange.fold_format import fold_text, pattern_document
from folding_server.simulator.foldability import CreasePattern

ENDED = {"states": "1", "refused": None, "cpu": 4.0}
STOPPED = {"states": None, "refused": OUT_OF_TIME, "cpu": 40.0}


@pytest.mark.parametrize(
    ("ours", "theirs", "ratio"),
    [
        (ENDED, ENDED, 1.0),
        (ENDED, STOPPED, 0.1),
        (STOPPED, ENDED, 10.0),
        (STOPPED, STOPPED, None),
        (ENDED, {"states": None, "refused": "I is not iterable", "cpu": 1.0}, None),
        (ENDED, {**ENDED, "states": "0"}, None),
    ],
    ids=["both ended", "theirs stopped", "ours stopped", "both stopped", "refused", "another verdict"],
)
def test_a_ratio_is_of_what_both_took_and_of_the_limit_where_one_was_stopped(ours, theirs, ratio):
    assert ratio_of(ours, theirs) == ratio


def test_a_pattern_in_the_file_of_results_is_not_given_to_flat_folder_again(tmp_path: Path) -> None:
    """There is no Flat-Folder in this clone, and its example is compared all the same."""
    clone, results = tmp_path / "clone", tmp_path / "results.jsonl"
    (clone / "examples").mkdir(parents=True)
    found = miura(20, 26)
    pattern = CreasePattern(
        found.vertices_coords, found.edges_vertices, found.edges_assignment, faces_vertices=found.cycles
    )
    (clone / "examples" / "miura.fold").write_text(fold_text(pattern_document(pattern)))
    before = {"pattern": "miura", "faces": 520, "ratio": 9.0, "ours": STOPPED, "flat_folder": ENDED}
    results.write_text(json.dumps(before) + "\n")
    assert list(SideBySide(clone, results=results).rows()) == [before]
    (after,) = SideBySide(clone, results=results, ours_again=True).rows()
    assert after["flat_folder"] == ENDED
    assert (after["ours"]["states"], after["ratio"] < 9.0) == ("1", True)
    assert kept_rows(results) == {"miura": after}
