"""``.cp`` files of ORIPA and Oriedita: what we write, that we read it back, and lines as people draw them."""

from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from folding_server.cli import main
from folding_server.errors import ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.crease_pattern import crease_pattern_of
from folding_server.interchange.fold_reading import fold_flat, read_crease_pattern
from folding_server.interchange.oripa import oripa_text, read_oripa
from folding_server.simulator.foldability import CreasePattern, check_pattern
from hypothesis import given, settings
from hypothesis import strategies as st
from known_patterns import KNOWN, Known
from papers import CAT, FIGURES, figure, random_paper, states
from reference import golden_file, golden_rows

SHEET = "1 -200 -200 200 -200\n1 200 -200 200 200\n1 200 200 -200 200\n1 -200 200 -200 -200\n"


def drawn(pattern: CreasePattern, scale: float = 1.0, middle: Point = (0.0, 0.0)) -> set[tuple[Any, str]]:
    """The creases of a pattern by the places of their ends, free of numbers."""

    def place(v: int) -> Point:
        x, y = pattern.vertices_coords[v]
        return round((x - middle[0]) * scale, 6) + 0.0, round((y - middle[1]) * scale, 6) + 0.0

    return {
        (frozenset((place(u), place(v))), assignment)
        for (u, v), assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
    }


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 5), st.sampled_from([(1.0, 1.0), (1.0, 1.414), (2.35, 1.0)]))
def test_what_is_written_is_read_back(seed: int, folds: int, sheet: tuple[float, float]) -> None:
    ours = crease_pattern_of(random_paper(seed, folds, sheet))
    again = read_oripa(oripa_text(ours))
    assert drawn(again) == drawn(ours, 400 / max(sheet), (sheet[0] / 2, sheet[1] / 2))


def test_y_runs_down_in_the_file_and_up_in_the_pattern() -> None:
    text = oripa_text(crease_pattern_of(states(figure(CAT))[0]))
    assert sorted(text.splitlines()) == sorted(
        [
            "1 -200.0 -200.0 200.0 -200.0",
            "1 200.0 -200.0 200.0 200.0",
            "1 200.0 200.0 -200.0 200.0",
            "1 -200.0 -200.0 -200.0 200.0",
        ]
    )
    pattern = read_oripa(SHEET + "3 -200 -100 200 -100\n")
    assert {y for (x, y), assignment in ends(pattern) if assignment == "V"} == {100.0}


def ends(pattern: CreasePattern) -> list[tuple[Point, str]]:
    return [
        (pattern.vertices_coords[v], assignment)
        for edge, assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
        for v in edge
    ]


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_a_model_can_be_folded_from_its_lines(path: Path) -> None:
    paper = states(figure(path))[-1]
    folded = fold_flat(read_oripa(oripa_text(crease_pattern_of(paper))))
    assert sorted(assignment for _, assignment in folded.edges()) == sorted(
        assignment for _, assignment in paper.edges()
    )
    assert folded.sheet == pytest.approx((1.0, 1.0))


@pytest.mark.parametrize("known", KNOWN, ids=lambda known: known.name)
def test_patterns_of_ours_have_the_same_verdict_as_lines(known: Known) -> None:
    report = check_pattern(read_oripa(oripa_text(known.pattern)))
    assert (report.foldable, report.states) == (known.orders > 0, known.orders)


@pytest.mark.parametrize("row", golden_rows(lambda row: row["valid"] is not None)[::4])
def test_known_patterns_have_the_same_verdict_as_lines(row: dict[str, Any]) -> None:
    given = read_crease_pattern(golden_file(row).read_text())
    report = check_pattern(read_oripa(oripa_text(given)))
    assert (report.foldable, report.states) == (row["valid"], row["states"])


def test_lines_are_cut_where_they_cross() -> None:
    pattern = read_oripa(SHEET + "2 -200 0 200 0\n3 0 -200 0 200\n")
    assert (len(pattern.vertices_coords), len(pattern.edges_vertices), len(pattern.cycles)) == (9, 12, 4)
    report = check_pattern(pattern)
    assert [found.condition for found in report.violations] == ["Maekawa"]
    assert pattern.vertices_coords[report.violations[0].vertex] == (0.0, 0.0)


@pytest.mark.parametrize("shy", [0.0, 1e-3, -1e-3])
def test_lines_that_almost_touch_touch(shy: float) -> None:
    pattern = read_oripa(SHEET + f"2 {-200 + shy} 0 {200 - shy} {shy}\n")
    assert check_pattern(pattern).states == 1


def test_a_line_is_one_however_often_it_is_drawn() -> None:
    twice = "2 -200 0 100 0\n2 -100 0 200 0\n4 -200 0 200 0\n2 200 0 -200 0\n1 -200 -200 0 -200\n"
    pattern = read_oripa(SHEET + twice)
    folded = [
        edge
        for edge, assignment in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True)
        if assignment == "M"
    ]
    assert len(folded) == 3
    assert "F" not in pattern.edges_assignment
    assert check_pattern(pattern).foldable


def test_a_mountain_on_a_valley_is_refused_and_where_is_said() -> None:
    with pytest.raises(ProgramError, match=r"mountain and a valley .* from \(-100, 50\) to \(100, 50\)"):
        read_oripa(SHEET + "2 -200 50 100 50\n3 -100 50 200 50\n")


def test_auxiliary_lines_are_marks_and_those_off_the_sheet_are_left_out() -> None:
    pattern = read_oripa(SHEET + "4 -200 50 200 50\n0 -200 60 200 60\n9 -300 -300 -250 300\n4 -400 0 400 0\n")
    assert pattern.edges_assignment.count("F") == 3
    assert max(abs(c) for vertex in pattern.vertices_coords for c in vertex) == 200.0
    assert check_pattern(pattern).states == 1


def test_a_crease_that_ends_inside_the_sheet_is_found() -> None:
    report = check_pattern(read_oripa(SHEET + "2 -200 0 0 0\n"))
    assert not report.foldable
    assert "does not lie between two faces" in report.reason


def test_blank_lines_and_tabs_do_no_harm() -> None:
    assert read_oripa("\n" + SHEET.replace(" ", "\t").replace("\n", "\r\n\r\n")) == read_oripa(SHEET)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "has no lines"),
        (SHEET + "2 0 0 1\n", "Line 5 of the .cp file reads '2 0 0 1'"),
        (SHEET + "M 0 0 1 1\n", "Line 5"),
        (SHEET + "2 0 0 1 nan\n", "Line 5"),
        (SHEET + "2 0 0 1 1e300\n", "Line 5"),
        (SHEET + "2 0 0 1 1 1\n", "Line 5"),
        ('{"vertices_coords": []}', "Line 1"),
    ],
)
def test_a_line_that_cannot_be_read_is_named(text: str, reason: str) -> None:
    with pytest.raises(ProgramError) as refused:
        read_oripa(text)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_commands_read_and_write_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines, bad = tmp_path / "cat.cp", tmp_path / "bad.CP"
    assert exit_code("simulate", str(CAT), "--cp", str(lines)) == 0
    assert read_oripa(lines.read_text(encoding="utf-8")).edges_assignment.count("B") > 4
    capsys.readouterr()
    assert exit_code("check", str(lines)) == 0
    assert "folds flat" in capsys.readouterr().out
    bad.write_text(SHEET + "2 -200 50 200 50\n2 100 -200 100 200\n", encoding="utf-8")
    assert exit_code("check", str(bad)) == 1
    assert "at (100, 50): Maekawa: 4 mountains and 0 valleys" in capsys.readouterr().out


def exit_code(*arguments: str) -> object:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return ended.value.code


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.data())
def test_damaged_files_are_read_or_refused(seed: int, data: st.DataObject) -> None:
    """Whatever happened to a file: no other error comes out, and what is read can be checked."""
    rows = oripa_text(crease_pattern_of(random_paper(seed, 3))).splitlines()
    i = data.draw(st.integers(0, len(rows) - 1))
    fields = rows[i].split()
    fields[data.draw(st.integers(0, 4))] = data.draw(
        st.sampled_from(["0", "-200", "x", "7", "1e-300", "-0.5", "1e9"])
    )
    rows[i] = " ".join(fields)
    with suppress(ProgramError):
        check_pattern(read_oripa("\n".join(rows)), cap=2)
