"""What keeps a pattern from folding flat is named with its places, and yes is quick."""

import json
from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path
from random import Random
from time import process_time

import pytest
from folding_server.cli import main
from folding_server.interchange.fault_svg import marked_svg
from folding_server.interchange.oripa import read_oripa
from folding_server.mcp.services.presenters import foldability
from folding_server.simulator.foldability import Counting, CreasePattern, check_pattern
from folding_server.simulator.foldability.constraints import Contacts
from folding_server.simulator.foldability.flat_faces import lay_flat
from folding_server.simulator.foldability.tolerances import stable_contacts
from known_patterns import map_of, miura, moved, strip

SHEET = "1 -200 -200 200 -200\n1 200 -200 200 200\n1 200 200 -200 200\n1 -200 200 -200 -200\n"
ROUNDED = 1e-9
"""How far ends at one point differ by rounding, on a sheet of 400."""


def on_rim(angle: float) -> tuple[float, float]:
    x, y = cos(angle), sin(angle)
    longer = max(abs(x), abs(y))
    return 200 * x / longer, 200 * y / longer


def hub(creases: int, letters: str, at: tuple[float, float] = (0.0, 0.0)) -> str:
    """Creases from one point to the rim, each with an end of its own rounding."""
    random = Random(1)  # noqa: S311
    rows = []
    for k in range(creases):
        x, y = (c + random.uniform(-1, 1) * ROUNDED for c in at)
        end = on_rim(2 * pi * k / creases)
        rows.append(f"{'MV'.index(letters[k % len(letters)]) + 2} {x!r} {y!r} {end[0]!r} {end[1]!r}\n")
    return SHEET + "".join(rows)


def rays(*degrees: float, letters: str) -> CreasePattern:
    """Creases in some directions from the middle of the sheet."""
    ends = [on_rim(degree * pi / 180) for degree in degrees]
    lines = [
        f"{'MV'.index(letter) + 2} 0 0 {x!r} {-y!r}\n" for letter, (x, y) in zip(letters, ends, strict=True)
    ]
    return read_oripa(SHEET + "".join(lines))


@pytest.mark.parametrize(
    ("degrees", "letters", "words"),
    [
        ((0, 45, 135, 270), "VVVM", "angle of 45 degrees between two valleys"),
        ((0, 30, 60, 150, 220, 280), "MMMVMV", "2 equal angles of 30 degrees"),
    ],
)
def test_big_little_big_is_named_with_vertex_and_place(
    degrees: tuple[float, ...], letters: str, words: str
) -> None:
    report = check_pattern(rays(*degrees, letters=letters))
    assert not report.foldable
    assert report.reason.startswith("Big-little-big fails at vertex 4 at (0, 0): ")
    assert words in report.reason
    assert [(fault.kind, fault.places) for fault in report.faults] == [("Big-little-big", ((0.0, 0.0),))]


def test_two_conditions_at_one_vertex_are_one_bad_vertex() -> None:
    report = check_pattern(rays(0, 60, 130, 270, letters="MVMV"))
    assert {violation.condition for violation in report.violations} == {"Maekawa", "Kawasaki"}
    assert "more" not in report.reason


def test_more_bad_vertices_are_counted() -> None:
    lines = "2 -200 -100 200 -100\n2 -200 100 200 100\n2 0 -200 0 200\n"
    assert "and 1 more vertex: 4 mountains" in check_pattern(read_oripa(SHEET + lines)).reason


def test_every_loose_end_is_named_where_the_file_has_it() -> None:
    report = check_pattern(read_oripa(SHEET + "2 -200 50 0 50\n3 -100 -200 -100 -120\n"))
    assert [(fault.kind, fault.places) for fault in report.faults] == [
        ("loose end", ((0.0, 50.0),)),
        ("loose end", ((-100.0, -120.0),)),
    ]
    assert report.reason.endswith("There is 1 more fault.")


def test_faces_without_an_order_are_named_and_others_are_not() -> None:
    """Three panels that cannot be rolled up, and two beside them that lie flat."""
    report = check_pattern(strip((1, 0.5, 1, 1, 1), "VVFF"))
    (fault,) = report.faults
    assert fault.kind == "layers"
    assert len(fault.places) == 3
    assert "no order of the layers" in report.reason
    assert "every vertex folds flat" not in report.reason.lower()


def test_the_drawing_of_a_fault_has_a_ring_at_its_place(tmp_path: Path) -> None:
    pattern = read_oripa(SHEET + "2 -200 0 100 0\n3 0 -200 0 -0.4\n")
    drawn = marked_svg(pattern, check_pattern(pattern).faults)
    assert drawn.count("<circle") == 2, "the loose end, and the end that was joined"
    right_of_middle = 768 * (0.06 + 0.88 * 0.75)
    assert f'cx="{right_of_middle:.1f}" cy="384.0"' in drawn
    file, out = tmp_path / "loose.cp", tmp_path / "loose.svg"
    file.write_text(SHEET + "2 -200 0 100 0\n", encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["check", str(file), "--svg", str(out)])
    assert "<circle" in out.read_text(encoding="utf-8")


def test_many_creases_at_one_point_are_read_as_one_vertex() -> None:
    started = process_time()
    pattern = read_oripa(hub(1000, "MV"))
    report = check_pattern(pattern)
    assert process_time() - started < 5.0
    assert (len(pattern.cycles), len(pattern.vertices_coords)) == (1000, 1001)
    assert report.reason.startswith("Maekawa fails at vertex 4 at (0, 0): 500 mountains and 500 valleys")


def test_a_hub_of_64_creases_folds_flat() -> None:
    report = check_pattern(read_oripa(hub(64, "MM" + "VM" * 31)))
    assert (report.foldable, report.states) == (True, 1)


@pytest.mark.parametrize(
    "pattern",
    [map_of(12, 12, "U" * 264), strip((1,) * 100, "U" * 99), strip((1,) * 200, ("MMVV" * 50)[:199])],
    ids=["map of 12 by 12", "100 pleats", "200 lettered pleats"],
)
def test_yes_is_quick(pattern: CreasePattern) -> None:
    started = process_time()
    assert check_pattern(pattern, counting=Counting(seconds=0.2)).foldable
    assert process_time() - started < 8.0


def comb(teeth: int) -> CreasePattern:
    """Strips of four panels side by side on a flat one, their creases without letters."""
    lines, step = ["1 -200 0 -200 30", "1 200 0 200 30", "1 -200 30 200 30"], 200 / teeth
    for k in range(teeth):
        left, right = -200 + 2 * k * step, -200 + (2 * k + 1) * step
        lines += [f"1 {left} 0 {left} -80", f"1 {right} 0 {right} -80", f"1 {left} -80 {right} -80"]
        lines += [f"1 {right} 0 {right + step} 0", f"4 {left} 0 {right} 0"]
        lines += [f"4 {left} {y} {right} {y}" for y in (-20, -40, -60)]
    pattern = read_oripa("\n".join(lines))
    letters = tuple(
        "U" if letter == "F" and pattern.vertices_coords[u][1] > 1 else letter
        for letter, (u, _) in zip(pattern.edges_assignment, pattern.edges_vertices, strict=True)
    )
    return replace(pattern, edges_assignment=letters)


def test_independent_parts_are_counted_apart_and_multiplied() -> None:
    """All digits of a number that no reader of JSON keeps."""
    ways = check_pattern(comb(1)).states
    report = check_pattern(comb(60), counting=Counting(None))
    assert ways > 5
    assert (report.states, report.capped) == (ways**60, False)
    assert foldability(report).exact == str(ways**60)
    assert check_pattern(comb(60), 5).states == 5**60


def test_counting_ends_in_time_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "square.cp"
    file.write_text(SHEET, encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["check", str(file), "--count", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert (answer["states"], answer["exact"], answer["capped"]) == (1, "1", False)
    report = check_pattern(map_of(6, 6, "U" * 60), counting=Counting(None, 0.3))
    assert report.foldable
    assert report.capped
    assert "at least" in report.reason


def test_a_displaced_vertex_does_not_drop_overlaps() -> None:
    """The tolerance is the coarsest of which half as much sees the same, not twice what the faces disagree by."""
    sound, off = miura(4, 4, 0.05), moved(miura(4, 4, 0.05), 2e-4 + 1e-4j)
    spread = lay_flat(off).spread
    assert spread > 1e-4
    chosen = stable_contacts(lay_flat(off), 2 * spread)
    assert chosen.size == Contacts(lay_flat(off), chosen.tolerance / 2).size
    assert check_pattern(off).states == check_pattern(sound).states
