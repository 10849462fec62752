"""The words of a lesson's sheet: sentences under each drawing, its letters, and the points that are to be met."""

from collections.abc import Iterable, Sequence

from folding_server.geometry.line import Point
from folding_server.instructions.moves import Lesson, Move
from folding_server.instructions.sheet_layout import StepWords
from folding_server.simulator import Paper
from folding_server.wording.describing import SaidMove, letters_of, say
from folding_server.wording.landmarks import MEETING, Landmarks
from folding_server.wording.refolding import SaidPlaces
from folding_server.wording.said import SaidFold
from folding_server.wording.same_state import shift_between
from folding_server.wording.sentences import Language, Sentences


def lesson_words(lesson: Lesson, language: Language = "en") -> list[StepWords]:
    """The words of each move, and last those of the finished model."""
    sentences = Sentences(language)
    told = zip(lesson.moves, say(lesson), strict=True)
    words = [_words(move, said, sentences) for move, said in told]
    return [*words, StepWords(sentences.finished(lesson.title), {})]


def numbered_lines(words: Iterable[StepWords]) -> str:
    """Words as text, one numbered line a step."""
    return "".join(f"{number}. {each.text}\n" for number, each in enumerate(words, 1))


def _words(move: Move, told: SaidMove, sentences: Sentences) -> StepWords:
    text = sentences.say(told.said)
    if isinstance(told.said, SaidFold) and not told.said.unfold:
        text = sentences.together(text, sentences.check(corner_count(move.after)))
    shift = shift_between(move.base, told.before) or (0.0, 0.0)
    letters = {letter: _back(at, shift) for letter, at in letters_of(told).items()}
    return StepWords(text, letters, tuple(_back(at, shift) for at in _met(told)))


def _met(told: SaidMove) -> Sequence[Point]:
    """The points that a fold is to meet: those that it brings together, or goes through."""
    said = told.said
    if not isinstance(said, SaidFold):
        return []
    places = SaidPlaces(Landmarks(told.before), said.marks)
    return [places.point(key) for key in said.places]


def _back(point: Point, shift: Point) -> Point:
    return point[0] - shift[0], point[1] - shift[1]


def corner_count(paper: Paper) -> int:
    """How many corners the outline of the folded paper has, those of its holes too."""
    import shapely

    shape = shapely.union_all(
        [shapely.Polygon(paper.polygon(face)).buffer(MEETING, join_style="mitre") for face in paper.faces]
    )
    rings = [ring for part in shapely.get_parts(shape) for ring in (part.exterior, *part.interiors)]
    return sum(len(ring.simplify(4 * MEETING).coords) - 1 for ring in rings)
