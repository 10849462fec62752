"""Crease patterns as people have them: kinds of files, encodings, frames, planes, holes, gaps; damaged files get a sentence."""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from folding_server.cli import main
from folding_server.errors import FoldingError, ProgramError
from folding_server.interchange.fold_reading import read_crease_pattern
from folding_server.interchange.oripa import oripa_text
from folding_server.interchange.pattern_files import (
    LINE_READERS,
    ending_of_text,
    read_pattern,
    read_patterns,
    written_pattern,
)
from folding_server.pattern_text import decoded
from folding_server.simulator.foldability import CreasePattern, check_pattern
from fuzz_readers import SEEDS, fuzzed
from known_patterns import miura, waterbomb

SHEET = "1 -200 -200 200 -200\n1 200 -200 200 200\n1 200 200 -200 200\n1 -200 200 -200 -200\n"
BOOK: dict[str, Any] = {
    "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
    "edges_assignment": [*"BBBBV"],
    "faces_vertices": [[0, 1, 2], [0, 2, 3]],
}
"""A square with a valley along its diagonal."""


def turned(
    points: list[list[float]], axes: list[list[float]], origin: tuple[float, ...]
) -> list[list[float]]:
    """Points of a sheet in space."""
    return (np.array(points) @ np.array(axes) + np.array(origin)).tolist()


def run(*arguments: str) -> object:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return ended.value.code


def opx(lines: list[tuple[int, float, float, float, float]]) -> str:
    """What ORIPA writes: zeros are left out."""
    objects = ""
    for number, (kind, *numbers) in enumerate(lines):
        values = dict(zip(("x0", "y0", "x1", "y1"), numbers, strict=True))
        doubles = "".join(
            f'<void property="{k}"><double>{v}</double></void>' for k, v in sorted(values.items()) if v
        )
        objects += (
            f'<void index="{number}"><object class="oripa.OriLineProxy"><void property="type"><int>{kind}</int></void>'
            f"{doubles}</object></void>"
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?><java class="java.beans.XMLDecoder"><object class="oripa.DataSet">'
        f'<void property="lines"><array class="oripa.OriLineProxy">{objects}</array></void></object></java>'
    )


def rows(text: str) -> list[tuple[int, float, float, float, float]]:
    return [
        (int(kind), *map(float, numbers)) for kind, *numbers in (row.split() for row in text.splitlines())
    ]


def ori(text: str) -> str:
    """What Oriedita writes."""
    colors = {1: "BLACK_0", 2: "RED_1", 3: "BLUE_2", 4: "CYAN_3"}
    lines = [{"a": f"{a},{b}", "b": f"{c},{d}", "color": colors[kind]} for kind, a, b, c, d in rows(text)]
    return json.dumps({"@version": "v1.1", "lineSegments": lines, "circles": []})


def svg(text: str) -> str:
    """Lines of a drawing that is moved and halved."""
    colors = {1: "#000", 2: "rgb(220,20,20)", 3: "blue", 4: "grey"}
    body = "".join(
        f'<path d="M{a} {b}L{c} {d}" style="fill:none;stroke:{colors[kind]}"/>'
        for kind, a, b, c, d in rows(text)
    )
    return f'<svg xmlns="http://www.w3.org/2000/svg"><g transform="translate(7 3) scale(.5)">{body}</g></svg>'


def dxf(text: str) -> str:
    """Lines of a drawing, told apart by layer or colour; y runs up."""
    body = ""
    for kind, a, b, c, d in rows(text):
        how = {1: "8\nBorder\n", 2: "8\n0\n62\n1\n", 3: "8\n0\n62\n5\n", 4: "8\naux\n"}[kind]
        body += f"0\nLINE\n{how}10\n{a}\n20\n{-b}\n11\n{c}\n21\n{-d}\n"
    return f"0\nSECTION\n2\nENTITIES\n{body}0\nENDSEC\n0\nEOF\n"


WRITERS: dict[str, Callable[[str], str]] = {
    ".opx": lambda text: opx(rows(text)),
    ".ori": ori,
    ".svg": svg,
    ".dxf": dxf,
    ".cp": str,
}


@pytest.mark.parametrize("ending", LINE_READERS)
@pytest.mark.parametrize("pattern", [waterbomb(), miura(3, 3, 0.05)], ids=["waterbomb", "Miura"])
def test_lines_are_the_same_pattern_in_every_format(ending: str, pattern: CreasePattern) -> None:
    text = WRITERS[ending](oripa_text(pattern))
    assert ending_of_text(text) == ending
    read = read_pattern(text, ending)
    assert sorted(read.edges_assignment) == sorted(pattern.edges_assignment)
    assert check_pattern(read).states == check_pattern(pattern).states


@pytest.mark.parametrize("ending", [".fold", ".cp", ".svg"])
def test_what_is_converted_is_read_back(ending: str) -> None:
    pattern = miura(3, 3, 0.05)
    again = read_pattern(written_pattern(pattern, ending), ending)
    assert sorted(again.edges_assignment) == sorted(pattern.edges_assignment)
    assert check_pattern(again).states == check_pattern(pattern).states


def test_convert_writes_another_format_and_refuses_others_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given, out = tmp_path / "book.fold", tmp_path / "book.cp"
    given.write_text(json.dumps(BOOK), encoding="utf-8")
    assert run("convert", str(given), str(out)) == 0
    assert check_pattern(read_pattern(out.read_text(encoding="utf-8"), ".cp")).states == 1
    assert run("convert", str(given), str(tmp_path / "book.dxf")) == 1
    assert "'.dxf'" in capsys.readouterr().err
    page = tmp_path / "book.pdf"
    page.write_text("%PDF", encoding="utf-8")
    assert run("check", str(page)) == 1
    assert "export the drawing as SVG" in capsys.readouterr().err


def test_entities_are_not_expanded() -> None:
    bomb = '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><svg>&b;</svg>'
    for ending in (".svg", ".opx"):
        with pytest.raises(ProgramError, match="entities"):
            read_pattern(bomb, ending)


def test_a_drawing_without_edges_is_framed_and_says_so() -> None:
    text = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><line x1="0" y1="0" x2="1" y2="1" stroke="red"/></svg>'
    pattern = read_pattern(text, ".svg")
    assert check_pattern(pattern).states == 1
    assert "rectangle around the creases" in pattern.notes[0]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "shift_jis"])
def test_text_of_other_programs_is_read(encoding: str) -> None:
    text = json.dumps({**BOOK, "file_author": "折り紙"}, ensure_ascii=False)
    assert decoded(text.encode(encoding)) == text


def test_latin_1_is_read_and_other_bytes_are_no_text() -> None:
    assert decoded('{"file_author": "Zoë"}'.encode("latin-1")) is not None
    assert decoded(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR") is None


@pytest.mark.parametrize(
    ("axes", "origin"),
    [
        ([[1, 0, 0], [0, 0, 1]], (0.0, 0.0, 0.0)),
        ([[1, 0, 0], [0, 1, 0]], (0.0, 0.0, 5.0)),
        ([[0, 1, 0], [0, 0, 1]], (2.0, 0.0, 0.0)),
        ([[0.6, 0.8, 0], [0, 0, 1]], (1.0, 2.0, 3.0)),
    ],
    ids=["y = 0", "z = 5", "x = 2", "askew"],
)
def test_a_flat_sheet_in_any_plane_is_laid_flat(axes: list[list[float]], origin: tuple[float, ...]) -> None:
    """The letter stays seen from the front: a valley has face 0 below face 1."""
    points = turned(BOOK["vertices_coords"], axes, origin)
    pattern = read_crease_pattern({**BOOK, "vertices_coords": points})
    assert check_pattern(pattern).lying == ((0, 1),)
    assert pattern.place(2) == pytest.approx(points[2])


def test_a_sheet_that_stands_up_is_three_dimensional() -> None:
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]]
    with pytest.raises(ProgramError, match=r"three-dimensional: vertex \d at \("):
        read_crease_pattern({**BOOK, "vertices_coords": points})


def test_a_folded_form_that_is_not_folded_yet_is_the_sheet() -> None:
    assert check_pattern(read_crease_pattern({**BOOK, "frame_classes": ["foldedForm"]})).states == 1


def test_partial_fold_angles_are_named() -> None:
    pattern = read_crease_pattern({**BOOK, "edges_foldAngle": [0, 0, 0, 0, 90]})
    assert "Edge 0-2 with a fold angle of 90 degrees is folded only in part" in pattern.notes[0]


@pytest.mark.parametrize("inner", [[(1.0, 1.5), (2.0, 1.5)], []], ids=["on a crease", "in a face"])
def test_a_sheet_with_a_hole_is_one_sheet(inner: list[tuple[float, float]]) -> None:
    hole = "1 100 100 150 100\n1 150 100 150 150\n1 150 150 100 150\n1 100 150 100 100\n"
    crease = "3 -200 120 100 120\n3 150 120 200 120\n" if inner else "3 -200 0 200 0\n"
    assert check_pattern(read_pattern(SHEET + hole + crease, ".cp")).foldable


def test_two_sheets_in_one_file_are_refused_with_their_places() -> None:
    other = "1 300 0 400 0\n1 400 0 400 100\n1 400 100 300 0\n"
    report = check_pattern(read_pattern(SHEET + other, ".cp"))
    assert "more than one sheet" in report.reason
    assert (300.0, 0.0) in [place for fault in report.faults for place in fault.places]


def test_creases_listed_twice_are_one_and_a_mountain_on_a_valley_is_named() -> None:
    edges = [*BOOK["edges_vertices"], [2, 0]]
    twice = {**BOOK, "edges_vertices": edges, "edges_assignment": [*"BBBBVF"]}
    assert check_pattern(read_crease_pattern(twice)).states == 1
    with pytest.raises(ProgramError, match=r"mountain and a valley .* from \(1, 1\) to \(0, 0\)"):
        read_crease_pattern({**twice, "edges_assignment": [*"BBBBVM"]})


@pytest.mark.parametrize("number", ["1e400", "-1e400", "NaN", "1e99"])
def test_a_coordinate_that_is_no_number_is_a_sentence(number: str) -> None:
    text = json.dumps(BOOK).replace("[1, 1]", f"[1, {number}]")
    with pytest.raises(ProgramError, match="y coordinate of vertex 2|NaN"):
        read_crease_pattern(text)


def test_faces_without_edges_and_an_outline_as_the_only_face_are_read() -> None:
    bare = {key: BOOK[key] for key in ("vertices_coords", "faces_vertices")}
    assert check_pattern(read_crease_pattern(bare)).states == 2
    assert check_pattern(read_crease_pattern({**BOOK, "faces_vertices": [[0, 1, 2, 3]]})).states == 1


def test_the_answer_says_which_frame_it_is_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = {"frame_classes": ["creasePattern"], **BOOK, "edges_assignment": [*"BBBBV"]}
    bad["vertices_coords"] = [*BOOK["vertices_coords"], [0.4, 0.6]]
    bad["edges_vertices"] = [*BOOK["edges_vertices"][:4], [0, 4]]
    del bad["faces_vertices"]
    file = tmp_path / "two.fold"
    file.write_text(json.dumps({**BOOK, "file_frames": [bad]}), encoding="utf-8")
    assert run("check", "--frame", "1", str(file)) == 0
    assert run("check", "--frame", "2", str(file)) == 1
    assert run("check", "--frame", "all", "--json", str(file)) == 1
    assert run("check", "--frame", "3", str(file)) == 1
    told = capsys.readouterr()
    assert "Frame 1 of 2: The pattern folds flat" in told.out
    assert "Frame 2 of 2 (creasePattern): Crease" in told.out
    assert "no frame 3" in told.err
    assert [read.frame for read in read_patterns(file.read_text(encoding="utf-8"), ".fold", "all")] == [1, 2]


def test_frames_are_numbered_from_1_wherever_they_are_spoken_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damaged = {"frame_classes": ["creasePattern"], **BOOK, "edges_assignment": ["V"]}
    file = tmp_path / "damaged.fold"
    for frames, number in (([BOOK, damaged], "3"), ([damaged, BOOK], "2")):
        file.write_text(json.dumps({**BOOK, "file_frames": frames}), encoding="utf-8")
        assert run("check", "--frame", number, str(file)) == 1
        assert f"In frame {number} of the FOLD file, edges_assignment" in capsys.readouterr().err
    file.write_text(json.dumps(damaged), encoding="utf-8")
    assert run("check", "--frame", "1", str(file)) == 1
    assert "In frame 1 (the key frame) of the FOLD file" in capsys.readouterr().err
    file.write_text(json.dumps(BOOK), encoding="utf-8")
    assert run("check", "--frame", "0", str(file)) == 1
    assert "There is no frame 0 in the FOLD file; it has frames 1 to 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "states", "joined"),
    [
        ("3 -200 0 199.5 0", 1, 1),
        ("3 -200 0 200.5 0", 1, 1),
        ("3 -199.5 0 199.5 0", 1, 2),
        ("3 -200 0 0.5 0\n3 1 0 200 0", 1, 1),
        ("3 -200 0 190 0", 0, 0),
    ],
)
def test_ends_that_miss_by_little_are_joined_and_listed(line: str, states: int, joined: int) -> None:
    pattern = read_pattern(SHEET + line + "\n", ".cp")
    report = check_pattern(pattern)
    assert (report.states, len(pattern.joined)) == (states, joined)
    if not states:
        assert "its end at (190, 0) is loose, 10 (0.025 of the side) from (200, 0)" in report.reason


def test_how_far_ends_may_miss_is_an_option() -> None:
    text = SHEET + "3 -200 0 199.5 0\n"
    assert not check_pattern(read_pattern(text, ".cp", 0.0)).foldable
    assert check_pattern(read_pattern(text.replace("199.5", "190"), ".cp", 0.03)).foldable


def test_an_answer_with_joined_ends_lists_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "gap.cp"
    file.write_text(SHEET + "3 -200 10 199.5 10\n", encoding="utf-8")
    assert run("check", str(file), "--json") == 0
    (note,) = json.loads(capsys.readouterr().out)["notes"]
    assert note == "An end at (199.5, 10) was joined to (200, 10), 0.00125 of the side away."


@pytest.mark.parametrize("kind", SEEDS)
def test_damaged_files_get_a_sentence_or_an_answer(kind: str) -> None:
    """Truncated, deep, huge, of wrong types: no other error comes out of reading and checking."""
    chance = random.Random(kind)  # noqa: S311
    for _ in range(60):
        text = fuzzed(kind, chance)
        try:
            pattern = read_pattern(text, kind)
        except FoldingError as refused:
            assert "\n" not in str(refused)
        else:
            check_pattern(pattern, 1)
