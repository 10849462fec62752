"""Steps laid out on pages: drawings in columns, each with its number, its words and, if wanted, the photo beside it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from folding_server.diagram.palette import colors_of, diagram_colors
from folding_server.geometry.line import Point
from folding_server.instructions.ink_colors import printed
from folding_server.instructions.lettering import broken_lines
from folding_server.instructions.marks import Drawn, DrawnPath, DrawnPhoto, DrawnText, polyline
from folding_server.instructions.moves import Lesson
from folding_server.instructions.step_drawing import StepFigure, base_scale, draw_scene, enlargement, moved_by
from folding_server.instructions.step_scene import finished, scene_of
from folding_server.instructions.symbols import enlarge_sign

PAPER_SIZES = {"a4": (595.28, 841.89), "letter": (612.0, 792.0)}
"""Width and height in points."""
MARGIN_POINTS, COLUMN_GAP, ROW_GAP = 40.0, 14.0, 14.0
TITLE_SIZE, WORDS_SIZE, NUMBER_SIZE, FOOT_SIZE = 16.0, 8.6, 11.0, 8.0
"""Letters in points: none is smaller than 8, so that they can be read in print."""
LINE_STEP = 1.3
"""Distance between lines of words, in sizes of the letters."""
TITLE_ROOM, FOOT_ROOM, HEADROOM = 34.0, 22.0, 17.0
"""Points for the title, for the page's number, and above a figure for its number and the sign of enlargement."""


@dataclass(frozen=True)
class SheetForm:
    """How a sheet is laid out: ``paper`` is a4 or letter. An ``endless`` sheet has one page, as long as it needs to be."""

    paper: str = "a4"
    columns: int = 3
    endless: bool = False

    @property
    def column_width(self) -> float:
        """In points."""
        return (
            PAPER_SIZES[self.paper][0] - 2 * MARGIN_POINTS - (self.columns - 1) * COLUMN_GAP
        ) / self.columns


@dataclass(frozen=True)
class StepWords:
    """What is said of a step; the words give ``letters`` to points, and ``dots`` are the points that are to be met."""

    text: str
    letters: Mapping[str, Point]
    dots: tuple[Point, ...] = ()


@dataclass(frozen=True)
class SheetStep:
    """A step as it is printed: its number above, its figure, its words in lines. ``kind`` is its move's, or ``finished``."""

    number: int
    kind: str
    text: str
    figure: StepFigure
    lines: tuple[str, ...]
    enlarged: float = 1.0

    @property
    def own_height(self) -> float:
        """The height in points of number and figure."""
        return HEADROOM + self.figure.height

    def drawn(self, height: float, *, with_words: bool = True) -> list[Drawn]:
        """All of it from (0, 0) on, number and figure in so many points of height, the figure in their middle."""
        head: list[Drawn] = [
            DrawnText("number", (0.0, NUMBER_SIZE), f"{self.number}.", NUMBER_SIZE, bold=True)
        ]
        if self.enlarged != 1.0:
            head += enlarge_sign((26.0, 7.5), self.enlarged)
        down = HEADROOM + (height - self.own_height) / 2
        words = [
            DrawnText("words", (0.0, height + WORDS_SIZE * (1.2 + LINE_STEP * i)), line, WORDS_SIZE)
            for i, line in enumerate(self.lines if with_words else ())
        ]
        return [*head, *(moved_by(each, 0.0, down) for each in self.figure.drawn), *words]


@dataclass(frozen=True)
class SheetPage:
    """A page: its size in points, what stands on it beside the steps, and the steps in their places."""

    width: float
    height: float
    drawn: tuple[Drawn, ...]
    steps: tuple["PlacedStep", ...]


@dataclass(frozen=True)
class PlacedStep:
    """A step with its upper left corner on the page, and the height of number and figure that it shares with its row."""

    at: Point
    step: SheetStep
    height: float


@dataclass(frozen=True)
class InstructionSheet:
    """All pages of the instructions to a model."""

    title: str
    pages: tuple[SheetPage, ...]

    @property
    def steps(self) -> list[SheetStep]:
        """The steps in order."""
        return [placed.step for page in self.pages for placed in page.steps]


def lay_out(
    lesson: Lesson, words: Sequence[StepWords], form: SheetForm, photos: Mapping[int, bytes] | None = None
) -> InstructionSheet:
    """The sheet of a lesson. ``words`` are those of its moves and, last, of the finished model.

    ``photos`` are JPEGs by keyframe: beside a drawing stands that of the paper before its step.
    """
    steps = sheet_steps(lesson, words, form.column_width, photos or {})
    return InstructionSheet(lesson.title, tuple(_pages(lesson.title, steps, form)))


def sheet_steps(
    lesson: Lesson, words: Sequence[StepWords], width: float, photos: Mapping[int, bytes]
) -> list[SheetStep]:
    """The steps of a lesson, each ``width`` points wide, and the finished model."""
    program = lesson.program
    inks = printed(diagram_colors(colors_of(program.front_color, program.back_color)))
    scenes = [
        *(scene_of(move, said.letters, said.dots) for move, said in zip(lesson.moves, words, strict=False)),
        finished(lesson.final),
    ]
    kinds = [*(move.kind for move in lesson.moves), "finished"]
    frames = [*(move.step for move in lesson.moves), len(program.steps) + 1]
    side = (width - COLUMN_GAP / 2) / 2 if photos else width
    steps, size = list[SheetStep](), 1.0
    for number, (scene, kind, said, frame) in enumerate(zip(scenes, kinds, words, frames, strict=True), 1):
        last, size = size, enlargement(scene, side, size)
        figure = draw_scene(scene, inks, side, size * base_scale(scene.paper, side))
        if frame in photos:
            figure = _beside_photo(figure, photos[frame], side)
        lines = tuple(broken_lines(said.text, WORDS_SIZE, width))
        steps.append(SheetStep(number, kind, said.text, figure, lines, size / last))
    return steps


def _beside_photo(figure: StepFigure, jpeg: bytes, side: float) -> StepFigure:
    """A figure with a square photo on its right."""
    left, height = side + COLUMN_GAP / 2, max(figure.height, side)
    photo = DrawnPhoto("photo", (left, (height - side) / 2, left + side, (height + side) / 2), jpeg)
    return StepFigure(
        (*(moved_by(each, 0.0, (height - figure.height) / 2) for each in figure.drawn), photo), height
    )


def words_height(lines: int) -> float:
    """The height in points of so many lines of words below a figure."""
    return WORDS_SIZE * (0.6 + LINE_STEP * lines)


def _pages(title: str, steps: Sequence[SheetStep], form: SheetForm) -> Iterable[SheetPage]:
    """The pages: rows as high as their highest step, broken where the next would not fit."""
    width, height = PAPER_SIZES[form.paper]
    rows = [steps[i : i + form.columns] for i in range(0, len(steps), form.columns)]
    bottom = float("inf") if form.endless else height - MARGIN_POINTS - FOOT_ROOM
    pages: list[list[PlacedStep]] = [[]]
    y = MARGIN_POINTS + TITLE_ROOM
    for row in rows:
        tall = max(step.own_height for step in row)
        full = tall + max(words_height(len(step.lines)) for step in row)
        if y + full > bottom and pages[-1]:
            pages.append([])
            y = MARGIN_POINTS
        for column, step in enumerate(row):
            x = MARGIN_POINTS + column * (form.column_width + COLUMN_GAP)
            pages[-1].append(PlacedStep((x, y), step, tall))
        y += full + ROW_GAP
    for number, placed in enumerate(pages, 1):
        tall = y + MARGIN_POINTS + FOOT_ROOM - ROW_GAP if form.endless else height
        yield SheetPage(width, tall, tuple(_around(title, number, len(pages), width, tall)), tuple(placed))


def _around(title: str, number: int, count: int, width: float, height: float) -> list[Drawn]:
    """The title of the first page, and the number of every page where there are several."""
    drawn: list[Drawn] = []
    if number == 1:
        drawn.append(
            DrawnText("title", (MARGIN_POINTS, MARGIN_POINTS + TITLE_SIZE), title, TITLE_SIZE, bold=True)
        )
        rule = [(MARGIN_POINTS, MARGIN_POINTS + 24.0), (width - MARGIN_POINTS, MARGIN_POINTS + 24.0)]
        drawn.append(DrawnPath("rule", polyline(rule), "#8f8f8f", None, 0.5))
    if count > 1:
        foot = width - MARGIN_POINTS, height - MARGIN_POINTS
        drawn.append(DrawnText("page", foot, f"{number} / {count}", FOOT_SIZE, anchor="end"))
    return drawn


def all_drawn(page: SheetPage) -> Iterable[Drawn]:
    """Everything on a page, in the page's own points."""
    yield from page.drawn
    for placed in page.steps:
        yield from (moved_by(each, *placed.at) for each in placed.step.drawn(placed.height))
