"""Steps in words: what is said leads to the same paper, in English it is read back, and every language says everything."""

import re
from math import dist, hypot
from pathlib import Path
from string import Formatter

import pytest
from folding_schemas.actions import Actions, AddVertex, Fold, Program
from folding_server.errors import ProgramError
from folding_server.geometry.isometry import mirror
from folding_server.geometry.line import Line, line_through
from folding_server.instructions.moves import lesson_of
from folding_server.interchange.programs import load_published
from folding_server.simulator import flip, fold, new_paper, rotate
from folding_server.wording import axioms
from folding_server.wording.describing import say
from folding_server.wording.landmarks import Landmarks
from folding_server.wording.reading import program_in_words, read_line
from folding_server.wording.repeats import with_repeats
from folding_server.wording.same_state import shift_between
from folding_server.wording.sentences import messages
from folding_server.wording.sheet_words import lesson_words, numbered_lines
from hypothesis import assume, given
from hypothesis import strategies as st
from papers import FIGURES, states
from paths import EXAMPLES
from test_instructions_sheets import CORNERS_BEHIND
from wording import is_refolded, random_program

PROGRAMS = [*sorted((EXAMPLES / "programs").glob("*.json")), *FIGURES]
POINTS = st.tuples(st.floats(-2, 2), st.floats(-2, 2))
LINES = st.tuples(st.floats(0, 6.3), st.floats(-1, 1)).map(
    lambda each: line_through((0.0, each[1]), (1.0, each[1] + each[0] - 3.1))
)


def program_at(path: Path) -> Program:
    return load_published(path.read_text(encoding="utf-8")).program


@pytest.mark.parametrize("repeats", [False, True], ids=["one by one", "with repeats"])
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_folded_from_its_words_ends_in_the_same_state(path: Path, *, repeats: bool) -> None:
    program = program_at(path)
    lesson = lesson_of(program)
    text = numbered_lines(lesson_words(with_repeats(lesson) if repeats else lesson))
    again = program_in_words(text, sheet=program.sheet)
    assert shift_between(states(program)[-1], states(again)[-1]) is not None


def test_a_fold_behind_and_an_unfolding_are_read_back() -> None:
    program = Program(steps=CORNERS_BEHIND)
    text = numbered_lines(lesson_words(lesson_of(program)))
    assert "behind the model" in text and "Crease sharply; unfold." in text
    assert shift_between(states(program)[-1], states(program_in_words(text))[-1]) is not None


def test_the_second_ear_of_the_cat_is_a_repetition_of_the_first() -> None:
    lesson = with_repeats(lesson_of(program_at(EXAMPLES / "programs" / "cat.json")))
    assert [move.repeat is not None for move in lesson.moves] == [False, False, False, True, False, False]
    assert "Repeat on the other side." in lesson_words(lesson)[3].text


def test_a_fold_is_no_repetition_of_one_that_is_not_its_mirror_image() -> None:
    def corner(position: float) -> Actions:
        """Fold down the upper right corner, marked at a part of the two edges from it."""
        return (
            AddVertex(edge=(2, 5), position=position),
            AddVertex(edge=(2, 3), position=0.75 * position),
            Fold(edge=(7, 8), direction=1),
        )

    left: Actions = (
        AddVertex(edge=(1, 2), position=0.25),
        AddVertex(edge=(1, 4), position=0.25),
        Fold(edge=(5, 6), direction=1),
    )
    found = [
        [
            move.repeat is not None
            for move in with_repeats(lesson_of(Program(steps=(left, corner(part))))).moves
        ]
        for part in (1 / 3, 0.3)
    ]
    assert found == [[True], [False, False]]


def test_random_programs_are_refolded_from_their_words() -> None:
    assert [seed for seed in range(5000, 5020) if not is_refolded(random_program(seed, 5))[0]] == []


@pytest.mark.slow
def test_a_hundred_random_programs_are_refolded_from_their_words() -> None:
    assert [seed for seed in range(6000, 6100) if not is_refolded(random_program(seed, 6))[0]] == []


def test_the_heart_is_said_as_people_say_it() -> None:
    words = [each.text for each in lesson_words(lesson_of(program_at(EXAMPLES / "programs" / "heart.json")))]
    assert words[1] == "Bring the left corner to the right corner (axiom 2). Crease sharply; unfold."
    assert words[3].startswith("Bring the top corner to the centre (axiom 2). Check: ")
    assert "; both layers (axiom 2)." in words[5]
    assert words[-1] == "The finished heart."


def test_another_number_of_layers_is_another_fold() -> None:
    start = "Bring the bottom left corner to the top left corner (axiom 2).\n"
    again = "Bring the top left corner to the bottom left corner; {} (axiom 2).\n"
    both, top = (
        states(program_in_words(start + again.format(how)))[-1] for how in ("both layers", "top layer only")
    )
    assert (len(both.faces), len(top.faces)) == (4, 3)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("Crumple it.", "no sentence that is known"),
        ("Bring the top corner to the left corner (axiom 2).", "has no 'corner.top'"),
        ("Mark A on the top edge, 1/0 of the way from its left end.", "no part of a length"),
        ("Unfold the last fold.", "Nothing is folded"),
        (
            "Bring the top left corner to the bottom right corner; all 3 layers (axiom 2).",
            "cannot be folded so",
        ),
    ],
)
def test_what_cannot_be_done_is_told_in_a_sentence(line: str, said: str) -> None:
    with pytest.raises(ProgramError) as refusal:
        program_in_words(f"1. {line}")
    assert said in str(refusal.value) and "Line 1" in str(refusal.value) and "\n" not in str(refusal.value)


def test_what_is_only_looked_at_says_nothing() -> None:
    assert read_line("9. The finished cat.") is None


@pytest.mark.parametrize("language", ["de", "ja"])
def test_every_language_says_everything(language: str) -> None:
    english, other = messages("en"), messages(language)  # type: ignore[arg-type]
    assert structure(english) == structure(other)


def structure(words: object) -> object:
    """The keys of a message file with the places of each template, whatever their order and forms."""
    if isinstance(words, dict):
        return {key: structure(value) for key, value in words.items()}
    first = words if isinstance(words, str) else words[0]  # type: ignore[index]
    return {(name or "").rstrip("*") for _, name, _, _ in Formatter().parse(first)} - {""}


@pytest.mark.parametrize(
    ("language", "said"),
    [("de", "Lege die untere Ecke auf die obere Ecke"), ("ja", "下の角を上の角に合わせて折る")],
)
def test_the_cat_in_other_languages(language: str, said: str) -> None:
    words = lesson_words(lesson_of(program_at(EXAMPLES / "programs" / "cat.json")), language)  # type: ignore[arg-type]
    assert words[1].text.startswith(said)
    assert not re.search(r"[{}*]", "".join(each.text for each in words))


def test_corners_and_edges_are_named_as_they_are_seen() -> None:
    places = Landmarks(rotate(new_paper(), 45))
    assert {key for key in places.points if key.startswith("corner")} == {
        f"corner.{s}" for s in ("top", "left", "right", "bottom")
    }
    assert set(places.lines) == {
        f"edge.{s}" for s in ("top-left", "top-right", "bottom-left", "bottom-right")
    }


class TestAxioms:
    @given(p=POINTS, q=POINTS)
    def test_2_brings_a_point_to_a_point(self, p: tuple[float, float], q: tuple[float, float]) -> None:
        assume(dist(p, q) > 0.01)
        (line,) = axioms.point_to_point(p, q)
        assert dist(mirror(line)(p), q) < 1e-9

    @given(first=LINES, second=LINES)
    def test_3_brings_a_line_to_a_line(self, first: Line, second: Line) -> None:
        assume(abs(first.nx * second.ny - first.ny * second.nx) > 0.05)
        for line in axioms.line_to_line(first, second):
            foot = first.nx * first.offset, first.ny * first.offset
            for along in (0.0, 1.0):
                at = foot[0] - along * first.ny, foot[1] + along * first.nx
                assert abs(second.distance(mirror(line)(at))) < 1e-6

    @given(p=POINTS, line=LINES)
    def test_4_brings_a_line_onto_itself_through_a_point(self, p: tuple[float, float], line: Line) -> None:
        (found,) = axioms.through_point_across_line(p, line)
        assert abs(found.distance(p)) < 1e-9
        assert abs(found.nx * line.nx + found.ny * line.ny) < 1e-9

    @given(p=POINTS, q=POINTS, line=LINES)
    def test_5_brings_a_point_to_a_line_through_a_point(
        self, p: tuple[float, float], q: tuple[float, float], line: Line
    ) -> None:
        for found in axioms.point_to_line_through_point(p, line, q):
            assert abs(found.distance(q)) < 1e-6
            assert abs(line.distance(mirror(found)(p))) < 1e-6

    @given(p=POINTS, q=POINTS, wanted=LINES, slant=st.floats(0.3, 1.2))
    def test_6_finds_a_fold_that_brings_two_points_to_two_lines(
        self, p: tuple[float, float], q: tuple[float, float], wanted: Line, slant: float
    ) -> None:
        assume(min(abs(wanted.distance(p)), abs(wanted.distance(q))) > 0.1 and dist(p, q) > 0.1)
        images = mirror(wanted)(p), mirror(wanted)(q)
        lines = [
            line_through(at, (at[0] + 1, at[1] + way))
            for at, way in zip(images, (slant, -slant), strict=True)
        ]
        found = axioms.two_points_to_two_lines(p, lines[0], q, lines[1])
        off = [
            min(hypot(a.nx - wanted.nx, a.ny - wanted.ny), hypot(a.nx + wanted.nx, a.ny + wanted.ny))
            for a in found
        ]
        assert 1 <= len(found) <= 3
        assert min(off) < 1e-3

    @given(p=POINTS, first=LINES, second=LINES)
    def test_7_brings_a_point_to_a_line_square_to_another(
        self, p: tuple[float, float], first: Line, second: Line
    ) -> None:
        for found in axioms.point_to_line_across_line(p, first, second):
            assert abs(found.nx * second.nx + found.ny * second.ny) < 1e-6
            assert abs(first.distance(mirror(found)(p))) < 1e-6


def test_the_same_state_is_known_wherever_it_lies_and_no_other() -> None:
    paper = fold(new_paper(), (1, 3), 1)
    assert shift_between(paper, paper) == (0.0, 0.0)
    assert shift_between(paper, flip(flip(paper, "x"), "x")) is not None
    assert shift_between(paper, flip(paper, "x")) is None
    assert shift_between(paper, rotate(paper, 10)) is None
    assert shift_between(paper, fold(new_paper(), (2, 4), 1)) is None


def test_what_is_said_of_a_lesson_is_exact() -> None:
    told = say(lesson_of(program_at(EXAMPLES / "programs" / "cup.json")))
    assert all(each.exact for each in told)
