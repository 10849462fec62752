"""A lesson as pictures one after the other: movements with easing, pauses between them, the words below."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi

import numpy as np

from folding_server.animation.film_camera import EYE_TILT, FilmCamera, PaintedFace, painted
from folding_server.animation.scenes import FilmScene, extent_of, faces_in_space, film_scenes
from folding_server.arrays import RgbImage
from folding_server.diagram.palette import DiagramColors, colors_of, diagram_colors
from folding_server.diagram.svg import svg_document, svg_text
from folding_server.instructions.ink_colors import printed
from folding_server.instructions.lettering import broken_lines
from folding_server.instructions.moves import Lesson
from folding_server.simulator import Paper

SECONDS_MOVING, SECONDS_RESTING, SECONDS_POSTER = 1.1, 0.7, 1.0
"""How long a movement takes, how long the paper then lies still, and how long the finished model is shown first and last."""
CAPTION_PART = 0.16
"""The part of the picture's height, at the bottom, that the words have."""
CAPTION_LINES = 3
FRAMING = 0.86
"""The largest state fills this part of what the words leave."""
NEAREST = 2.2
"""A model is shown at most so many times as large as the flat sheet standing on a corner."""
GROUND, EDGE_INK = (255, 255, 255), (40, 40, 44)
CORNER_BITS = 4
"""Bits of a pixel in which OpenCV is given corners."""


@dataclass(frozen=True)
class FilmForm:
    """Size in pixels, pictures a second, and the view: straight from above, or tilted."""

    width: int = 1280
    height: int = 720
    rate: int = 24
    view: str = "tilted"


@dataclass(frozen=True)
class FilmMoment:
    """What one picture shows: a part (0 to 1, eased) of a scene, and the number of the words below, None for the title."""

    scene: int | None
    part: float
    words: int | None


def eased(part: float) -> float:
    """A part of the time as a part of the movement: slow, quick, slow."""
    return (1 - cos(pi * part)) / 2


def film_moments(scenes: Sequence[FilmScene], rate: int) -> Iterator[FilmMoment]:
    """The pictures of a film: the finished model as a poster, each movement and a rest, the finished model."""
    poster = [FilmMoment(None, 1.0, None)] * round(SECONDS_POSTER * rate)
    yield from poster
    moving, resting = round(SECONDS_MOVING * rate), round(SECONDS_RESTING * rate)
    for number, scene in enumerate(scenes):
        yield from (FilmMoment(number, 0.0, scene.move) for _ in range(resting))
        yield from (FilmMoment(number, eased(i / moving), scene.move) for i in range(1, moving + 1))
        yield from (FilmMoment(number, 1.0, scene.move) for _ in range(resting // 2))
    yield from poster


class LessonFilm:
    """A lesson that is painted picture by picture."""

    def __init__(self, lesson: Lesson, words: Sequence[str], form: FilmForm) -> None:
        program = lesson.program
        self.form, self.title, self.words = form, lesson.title, words
        self.scenes = film_scenes(lesson)
        self.final = lesson.final
        self.inks = printed(diagram_colors(colors_of(program.front_color, program.back_color)))
        self._ground = np.full((form.height, form.width, 3), GROUND[0], np.uint8)
        self._captions: dict[int | None, RgbImage] = {}

    def pictures(self) -> Iterator[RgbImage]:
        """All pictures, (height, width, 3)."""
        last: tuple[FilmMoment, RgbImage] | None = None
        for moment in film_moments(self.scenes, self.form.rate):
            if last is None or last[0] != moment:
                last = moment, self.picture(moment)
            yield last[1]

    def picture(self, moment: FilmMoment) -> RgbImage:
        """One picture."""
        canvas = self._ground.copy()
        paper, faces = self.seen(moment)
        for face in faces:
            paint_face(canvas, paper, face, self.inks)
        caption = self._caption(moment.words)
        canvas[-caption.shape[0] :] = caption
        return canvas

    def seen(self, moment: FilmMoment) -> tuple[Paper, list[PaintedFace]]:
        """The paper of a picture and its faces in the order in which they are painted."""
        if moment.scene is None or moment.part == 0.0:
            paper = self.final if moment.scene is None else self.scenes[moment.scene].before
            still = FilmScene(0, paper, paper)
            return paper, painted(faces_in_space(still, 0.0), self._camera(still, 0.0), over=True)
        scene = self.scenes[moment.scene]
        over = scene.swing is None or scene.swing.over
        camera = self._camera(scene, moment.part)
        return scene.after, painted(faces_in_space(scene, moment.part), camera, over)

    def _camera(self, scene: FilmScene, part: float) -> FilmCamera:
        """An eye that comes nearer as the model gets smaller, and goes back as it opens."""
        width, room = self.form.width, self.form.height * (1 - CAPTION_PART)
        near = NEAREST / hypot(*scene.after.sheet)
        first, last = (min(1 / extent_of(paper), near) for paper in (scene.before, scene.after))
        scale = FRAMING * min(room, width) * (first + (last - first) * part)
        return FilmCamera(scale, (width / 2, room / 2 + 0.02 * room), EYE_TILT[self.form.view])

    def _caption(self, number: int | None) -> RgbImage:
        """The words of a move, or the title, as a strip (height, width, 3)."""
        if number not in self._captions:
            text = self.title if number is None else f"{number + 1}. {self.words[number]}"
            self._captions[number] = caption_strip(
                text, self.form.width, round(self.form.height * CAPTION_PART)
            )
        return self._captions[number]


def paint_face(canvas: RgbImage, paper: Paper, face: PaintedFace, inks: DiagramColors) -> None:
    """Fill the outline of a face in its colour and draw its edges, creases thin."""
    import cv2

    fill = _shaded(inks.back if face.back_seen else inks.front, face.light)
    corners = np.round(face.outline * 2**CORNER_BITS).astype(np.int32)
    cv2.fillConvexPoly(canvas, corners, fill, cv2.LINE_AA, CORNER_BITS)
    cycle = paper.faces[face.face]
    for i, (u, v) in enumerate(zip(cycle, (*cycle[1:], cycle[0]), strict=True)):
        crease = paper.edge_assignment((u, v) if u < v else (v, u)) == "F"
        ink = _shaded(inks.back if face.back_seen else inks.front, 0.72) if crease else EDGE_INK
        start, end = (tuple(map(int, corners[k % len(cycle)])) for k in (i, i + 1))
        cv2.line(canvas, start, end, ink, 1 if crease else 2, cv2.LINE_AA, CORNER_BITS)


def _shaded(color: str, light: float) -> tuple[int, int, int]:
    red, green, blue = (min(255, round(int(color[i : i + 2], 16) * light)) for i in (1, 3, 5))
    return red, green, blue


def caption_strip(text: str, width: int, height: int) -> RgbImage:
    """Words in the middle of a white strip, in as large letters as three lines of them leave, (height, width, 3)."""
    from folding_server.diagram.rasterise import rasterise
    from folding_server.frames.image_files import decode_bytes

    size = height / (CAPTION_LINES * 1.45)
    lines = broken_lines(text, size, 0.92 * width)
    while len(lines) > CAPTION_LINES:
        size *= 0.92
        lines = broken_lines(text, size, 0.92 * width)
    step = 1.35 * size
    top = (height - step * len(lines)) / 2 + size
    body = [
        svg_text(width / 2, top + i * step, line, size, "#1d1d1f", 'text-anchor="middle"')
        for i, line in enumerate(lines)
    ]
    return decode_bytes(rasterise(svg_document(width, height, "#ffffff", body)), "the caption")
