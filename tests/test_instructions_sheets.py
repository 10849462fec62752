"""Sheets of instructions: symbols say what the program does, arrows go where flaps go, everything is on the page and legible."""

import json
import re
import xml.etree.ElementTree as ET
from collections import Counter
from math import dist
from pathlib import Path

import pytest
import shapely
from commands_here import run_here
from folding_schemas.actions import Actions, AddVertex, Flip, Fold, Program, Rotate, Unfold
from folding_server.instructions.marks import DrawnPath, DrawnText, bounds_of
from folding_server.instructions.moves import Lesson, lesson_of
from folding_server.instructions.sheet_files import sheet_content
from folding_server.instructions.sheet_layout import InstructionSheet, SheetForm, all_drawn, lay_out
from folding_server.instructions.step_scene import flap_tip, scene_of
from folding_server.instructions.symbols import LINE_INK
from folding_server.interchange.programs import load_program, load_published
from folding_server.photographer.movements import swing_of
from folding_server.wording.repeats import with_repeats
from folding_server.wording.sheet_words import lesson_words
from papers import FIGURES
from paths import EXAMPLES

PROGRAMS = [*sorted((EXAMPLES / "programs").glob("*.json")), *FIGURES]
SVG = "{http://www.w3.org/2000/svg}"
CORNERS_BEHIND: tuple[Actions, ...] = (
    (Fold(edge=(1, 3), direction=1), Unfold()),
    (
        Flip(axis="x"),
        AddVertex(edge=(1, 2), position=0.25),
        AddVertex(edge=(1, 4), position=0.25),
        Fold(edge=(5, 6), direction=1),
        Flip(axis="x"),
    ),
    (Rotate(angle=-22.5),),
    (Unfold(),),
    (Flip(axis="y"),),
)
"""Every kind of move, with a fold behind among them."""
SYMBOLS = {
    "fold": {"valley-line", "valley-arrow", "solid-head"},
    "fold-behind": {"mountain-line", "mountain-arrow", "half-head"},
    "fold-and-unfold": {"valley-line", "fold-and-unfold-arrow", "solid-head", "hollow-head"},
    "unfold": {"unfold-arrow", "hollow-head"},
    "turn-over": {"turn-over", "solid-head"},
    "rotate": {"rotate", "solid-head", "angle"},
    "finished": set[str](),
}
"""The symbols of each kind of move."""
NOT_SYMBOLS = frozenset(
    {
        "front",
        "back",
        "edge",
        "crease",
        "number",
        "words",
        "reference-dot",
        "letter",
        "spot",
        "enlarge",
        "factor",
        "x-ray-line",
    }
)


def lesson_in(path: Path) -> Lesson:
    return lesson_of(load_published(path.read_text(encoding="utf-8")).program)


def sheets_in(path: Path) -> list[Lesson]:
    """A lesson fold by fold, and with repeats."""
    return [lesson_in(path), with_repeats(lesson_in(path))]


def sheet_of(lesson: Lesson, columns: int = 3) -> InstructionSheet:
    return lay_out(lesson, lesson_words(lesson), SheetForm(columns=columns))


def symbols_in(svg: str) -> list[tuple[str, set[str], list[str]]]:
    """The kind of each step of an SVG, the classes of its symbols, and the angles that it tells."""
    groups = [group for group in ET.fromstring(svg).iter(f"{SVG}g") if group.get("class") == "step"]
    return [
        (
            group.get("data-move", ""),
            {name for each in group if (name := each.get("class", "")) not in NOT_SYMBOLS},
            [each.text or "" for each in group if each.get("class") == "angle"],
        )
        for group in groups
    ]


def expected(program: Program) -> list[tuple[str, list[str]]]:
    """The moves of a program as its actions say them, without looking at any drawing."""
    found: list[tuple[str, list[str]]] = []
    for step in program.steps:
        kinds = [action for action in step if not isinstance(action, AddVertex)]
        if [type(each) for each in kinds] == [Flip, Fold, Flip]:
            found.append(("fold-behind", []))
            continue
        for action in kinds:
            if isinstance(action, Unfold) and action.edge is None and found and found[-1][0] == "fold":
                found[-1] = ("fold-and-unfold", [])
            else:
                angle = [f"{abs(action.angle):g}°"] if isinstance(action, Rotate) else []
                found.append(
                    (
                        {Fold: "fold", Unfold: "unfold", Flip: "turn-over", Rotate: "rotate"}[type(action)],
                        angle,
                    )
                )
    return [*found, ("finished", [])]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_the_symbols_of_a_sheet_are_the_actions_of_its_program(path: Path) -> None:
    lesson = lesson_in(path)
    svg = sheet_content(lesson, ".svg", SheetForm(), {}).decode()
    shown = symbols_in(svg)
    assert [(kind, angles) for kind, _, angles in shown] == expected(lesson.program)
    assert [symbols for _, symbols, _ in shown] == [SYMBOLS[kind] for kind, _, _ in shown]


def test_a_repeated_fold_has_a_stroke_through_its_arrow_and_an_arrow_on_the_other_side() -> None:
    cat = lesson_in(EXAMPLES / "programs" / "cat.json")
    svg = sheet_content(with_repeats(cat), ".svg", SheetForm(), {}).decode()
    groups = [group for group in ET.fromstring(svg).iter(f"{SVG}g") if group.get("class") == "step"]
    counts = [Counter(each.get("class") for each in group) for group in groups]
    folds = [count["valley-arrow"] for count in counts]
    assert folds == [0, 1, 0, 2, 1, 0, 0]
    assert [count["repeat-sign"] for count in counts] == [0, 0, 0, 1, 0, 0, 0]
    assert sum(folds) == sum(kind == "fold" for kind, _ in expected(cat.program))


def test_every_kind_of_move_has_its_symbols() -> None:
    program = Program(steps=CORNERS_BEHIND)
    shown = symbols_in(sheet_content(lesson_of(program), ".svg", SheetForm(), {}).decode())
    assert [kind for kind, _, _ in shown] == [
        "fold-and-unfold",
        "fold-behind",
        "rotate",
        "unfold",
        "turn-over",
        "finished",
    ]
    assert [symbols for _, symbols, _ in shown] == [SYMBOLS[kind] for kind, _, _ in shown]
    assert shown[2][2] == ["22.5°"]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_an_arrow_starts_on_the_flap_that_moves_and_ends_where_it_lands(path: Path) -> None:
    for move in lesson_in(path).moves:
        for way in scene_of(move).ways:
            swing = swing_of(move.action, move.before, move.turned)
            _, face = flap_tip(swing)
            outline = [swing.starts[face](swing.paper.vertices_coords[v]) for v in swing.paper.faces[face]]
            assert shapely.Polygon(outline).contains(shapely.Point(way.start))
            assert shapely.Polygon(swing.paper.polygon(face)).contains(shapely.Point(way.end))
            sheet = swing.starts[face].inverse()(way.start)
            assert dist(swing.paper.isometries[face](sheet), way.end) < 1e-6


@pytest.mark.parametrize("columns", [2, 3, 4])
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_nothing_is_clipped_and_all_text_is_at_least_8_points(path: Path, columns: int) -> None:
    form = SheetForm("letter", columns)
    for page in (page for each in sheets_in(path) for page in lay_out(each, lesson_words(each), form).pages):
        left, top, right, bottom = bounds_of(all_drawn(page))
        assert left >= 36 and top >= 30 and right <= page.width - 30 and bottom <= page.height - 30
        assert min(each.size for each in all_drawn(page) if isinstance(each, DrawnText)) >= 8
        for placed in page.steps:
            drawn = placed.step.drawn(placed.height, with_words=False)
            box = bounds_of(drawn)
            assert box[0] >= -0.1 and box[2] <= form.column_width + 0.1
            assert box[1] >= -0.1 and box[3] <= placed.height + 0.1


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_arrows_cross_no_letter_and_letters_lie_apart(path: Path) -> None:
    for step in (step for each in sheets_in(path) for step in sheet_of(each).steps):
        letters = [
            shapely.box(*bounds_of([each]))
            for each in step.figure.drawn
            if isinstance(each, DrawnText) and each.kind == "letter"
        ]
        shafts = [
            shapely.MultiPoint([p for segment in each.segments for p in curve_points(segment)])
            for each in step.figure.drawn
            if isinstance(each, DrawnPath) and each.kind.endswith("-arrow")
        ]
        assert not [1 for letter in letters for shaft in shafts if letter.intersects(shaft)]
        assert not [
            1 for i, first in enumerate(letters) for second in letters[:i] if first.intersects(second)
        ]


def curve_points(segment: tuple[tuple[float, float], ...]) -> list[tuple[float, float]]:
    """Points along a part of a path."""
    if len(segment) != 4:
        return list(segment)
    weights = [
        ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3) for t in (i / 40 for i in range(41))
    ]
    return [
        (
            sum(w * x for w, (x, _) in zip(row, segment, strict=True)),
            sum(w * y for w, (_, y) in zip(row, segment, strict=True)),
        )
        for row in weights
    ]


def test_lines_are_drawn_as_books_draw_them() -> None:
    svg = sheet_content(lesson_of(Program(steps=CORNERS_BEHIND)), ".svg", SheetForm(), {}).decode()
    dashes = dict(re.findall(r'class="(valley-line|mountain-line)"[^>]*stroke-dasharray="([^"]+)"', svg))
    assert len(dashes["valley-line"].split()) == 2
    assert len(dashes["mountain-line"].split()) == 6
    widths = dict(re.findall(rf'class="(edge|crease)"[^>]*stroke="{LINE_INK}" stroke-width="([^"]+)"', svg))
    assert float(widths["crease"]) < float(widths["edge"])


def test_a_model_that_gets_small_is_drawn_larger_and_says_so() -> None:
    heart = sheet_of(lesson_in(EXAMPLES / "programs" / "heart.json")).steps
    enlarged = [step for step in heart if step.enlarged > 1]
    assert enlarged
    assert any(
        isinstance(each, DrawnText) and each.kind == "factor"
        for each in enlarged[0].drawn(enlarged[0].own_height)
    )


def test_what_opens_below_other_paper_is_dotted() -> None:
    actions: Actions = (
        AddVertex(edge=(1, 2), position=0.4),
        AddVertex(edge=(4, 3), position=0.4),
        Fold(edge=(5, 6), direction=-1),
        AddVertex(edge=(1, 5), position=0.5),
        AddVertex(edge=(4, 6), position=0.5),
    )
    lesson = lesson_of(Program(steps=(actions, (Flip(axis="x"),), (Unfold(),))))
    lines = scene_of(lesson.moves[-1]).lines
    assert set(lines) == {"x-ray-line"}


def test_a_program_that_fails_at_step_5_gives_four_steps_and_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heart = json.loads((EXAMPLES / "programs" / "heart.json").read_text())
    heart["steps"][4] = [{"action": "fold", "edge": [1, 99], "direction": 1}]
    program, sheet = tmp_path / "bad.json", tmp_path / "bad.svg"
    program.write_text(json.dumps(heart))
    done = run_here(capsys, "instructions", program, "-o", sheet)
    assert done.code == 1
    assert "Step 5, action 1" in done.err and "no vertex 99" in done.err and "\n" not in done.err.strip()
    kinds = [kind for kind, _, _ in symbols_in(sheet.read_text())]
    assert kinds == ["rotate", "fold-and-unfold", "fold", "finished"]


def test_other_endings_are_refused_in_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = run_here(capsys, "instructions", EXAMPLES / "programs" / "cat.json", "-o", tmp_path / "cat.docx")
    assert done.code == 1
    assert "'.docx'" in done.err and ".pdf" in done.err


def test_a_pdf_holds_its_pages_as_vectors_with_its_fonts_in_it() -> None:
    lesson = lesson_in(EXAMPLES / "programs" / "heart.json")
    pdf = sheet_content(lesson, ".pdf", SheetForm(), {})
    assert pdf.startswith(b"%PDF-1.")
    assert len(re.findall(rb"/Type /Page\b", pdf)) == len(sheet_of(lesson).pages)
    assert b"/Subtype /Image" not in pdf and b"/FontFile2" in pdf
    assert pdf == sheet_content(lesson, ".pdf", SheetForm(), {})


@pytest.mark.slow
def test_photos_stand_beside_their_drawings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    run.mkdir()
    program = load_program((EXAMPLES / "cat" / "program.json").read_text())
    (run / "program.json").write_text((EXAMPLES / "cat" / "program.json").read_text())
    (run / "run.json").write_text(json.dumps({"sequence": {"folder": str(EXAMPLES / "cat")}}))
    done = run_here(capsys, "instructions", run, "-o", tmp_path / "cat.svg", "--photos", "--columns", "2")
    assert done.code == 0, done.err
    drawn = (tmp_path / "cat.svg").read_text()
    assert drawn.count("<image") == len(symbols_in(drawn)) <= len(program.steps) + 1


def test_html_needs_nothing_from_elsewhere() -> None:
    html = sheet_content(lesson_in(EXAMPLES / "programs" / "cup.json"), ".html", SheetForm(), {}).decode()
    assert "default-src 'none'" in html
    assert set(re.findall(r"https?://[^\s\"'<]+", html)) == {"http://www.w3.org/2000/svg"}
    assert html.count("<figure>") == html.count("<figcaption>") == 8
