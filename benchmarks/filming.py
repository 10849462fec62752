"""Films of someone folding a program, painted by the photographer from a screenplay, with the truth beside them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import cos, pi, radians, sin
from pathlib import Path

import cv2
import numpy as np
from folding_schemas.actions import Program
from folding_server.arrays import Float32s
from folding_server.photographer.color_spaces import floats, to_srgb
from folding_server.photographer.grasp import grasping_hand
from folding_server.photographer.hand_model import PlacedHand, RenderedHand, render_hand
from folding_server.photographer.layer_rendering import Shading, paint_stack, shadow_direction
from folding_server.photographer.levels import LEVELS
from folding_server.photographer.lighting import Lamp, lamp_light
from folding_server.photographer.moments import Moment
from folding_server.photographer.photo_scene import PhotoScene
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.photographer.placement import PaperView
from folding_server.photographer.rng import stream
from folding_server.photographer.session import Session, prepare
from folding_server.photographer.sheet_texture import SheetTexture, creased
from folding_server.photographer.table import seen_table
from numpy.typing import NDArray
from screenplay import TROUBLES, Beat, Seen, Trouble, screenplay
from video_writing import Camera as Recorder
from video_writing import encode

SIZE = (400, 300)
RATE = 15
_GRAINS = 7
_ROOM = 260
"""Pixels around the picture in which a hand is painted too, as it moves."""
_LAMP_SECONDS = 0.4


@dataclass(frozen=True)
class Film:
    """A written film: for each image its time, the state that it shows (counted from 0) and how."""

    path: Path
    times: tuple[float, ...] = field(repr=False)
    shows: tuple[tuple[int, Seen], ...] = field(repr=False)
    states: int


@dataclass(frozen=True)
class Look:
    """Light and camera from the middle of a beat on: the lamp, and the camera's nudge in pixels and degrees."""

    lamp: Lamp
    nudge: tuple[float, float, float]


def make_film(program: Program, path: Path, trouble: str, level: int, seed: int) -> Film:
    """Film a program with one of the TROUBLES in a scene of a level; the same arguments give the same film."""
    chances = TROUBLES[trouble]
    stage = Stage.built(program, level, seed)
    beats = screenplay(stage.session.movements, chances, seed)
    ends = np.cumsum([beat.seconds for beat in beats])
    times = list(_times(float(ends[-1]), chances, seed))
    places = [int(place) for place in np.searchsorted(ends, times, side="right")]
    parts = [1 - (ends[b] - time) / beats[b].seconds for b, time in zip(places, times, strict=True)]
    looks = _looks(stage.session.scene, len(beats), chances, seed)
    encode(path, _images(stage, beats, looks, places, parts), times, Recorder(rate=RATE))
    shows = tuple((beats[b].state, beats[b].seen) for b in places)
    return Film(path, tuple(times), shows, len(program.steps) + 1)


def _times(end: float, trouble: Trouble, seed: int) -> Iterator[float]:
    """When images are taken, in seconds."""
    rng, time = stream(seed, "clock"), 0.0
    while time < end:
        yield round(time, 3)
        uneven = float(rng.choice([0.034, 0.05, 0.08, 0.12], p=[0.4, 0.3, 0.2, 0.1]))
        time += uneven if trouble.uneven else 1 / RATE


def _looks(scene: PhotoScene, beats: int, trouble: Trouble, seed: int) -> list[Look]:
    rng = stream(seed, "looks")
    looks = [Look(Lamp(scene.lamp_azimuth, 1.0, 0.0), (0.0, 0.0, 0.0))]
    for _ in range(beats):
        look = looks[-1]
        if rng.random() < trouble.lamp:
            turn, tint = rng.normal(0, 20), rng.normal(0, 0.06)
            look = replace(look, lamp=Lamp(scene.lamp_azimuth + turn, rng.uniform(0.7, 1.05), tint))
        if rng.random() < trouble.bumps:
            x, y, angle = rng.normal(0, 1, 3) * (3.0, 3.0, 0.4) + look.nudge
            look = replace(look, nudge=(float(x), float(y), float(angle)))
        looks.append(look)
    return looks


@dataclass(frozen=True)
class Stage:
    """What all images of a film share: the photographer's session, one camera, the table as it sees it."""

    session: Session
    camera: Camera
    table: Float32s = field(repr=False)

    @classmethod
    def built(cls, program: Program, level: int, seed: int) -> "Stage":
        """A scene of a level with a steady camera and a person who folds."""
        ranges = replace(LEVELS[level], unsteady=0.0, hands=1.0)
        session = prepare(program, seed, ranges, SIZE, between=1)
        camera = session.camera(Moment(0))
        return cls(session, camera, seen_table(session.table, camera, SIZE))

    def moment(self, beat: Beat, part: float) -> Moment:
        """The moment of the session that a part of a beat shows."""
        if beat.seen is not Seen.MAKING:
            return Moment(beat.state)
        return self._under_way(beat, beat.done[0] + part * (beat.done[1] - beat.done[0]))

    def _under_way(self, beat: Beat, done: float) -> Moment:
        """The moment at which part of the beat's movement is done."""
        movements = len(self.session.movements[beat.step])
        return Moment(beat.step, 1, (beat.movement + float(np.clip(done, 0.001, 0.999))) / movements)

    def paint(self, view: PaperView, worn: SheetTexture) -> tuple[Float32s, NDArray[np.uint8]]:
        """Linear colour (height, width, 3) of the table with a paper on it, and its coverage, 0 to 255."""
        tones = dict.fromkeys(view.paper.faces, 1.0)
        unit = self.session.unit
        albedo, light, coverage = paint_stack(self.table, view, worn, self.shading, unit, tones)
        return floats(albedo * light[..., None]), coverage

    @property
    def shading(self) -> Shading:
        """How shadows fall."""
        scene = self.session.scene
        towards = shadow_direction(scene.lamp_azimuth, scene.roll)
        return Shading(towards, scene.shadow, scene.lamp_azimuth)

    def grip(self, beat: Beat, done: float) -> tuple[Matrix, str] | None:
        """The spot (3,) that the beat's hand holds when part of its movement is done, and the hand's side."""
        return self.session.grasp(self._under_way(beat, done))

    def pixel(self, spot: Matrix) -> Matrix:
        """Where a spot over the table is in the picture."""
        return np.asarray(self.camera.project(spot[None])[0])


class Actor:
    """The hand of one movement, painted once and then moved along with what it holds."""

    def __init__(self, stage: Stage, beat: Beat, coverage: NDArray[np.uint8]) -> None:
        """The hand at the start of the beat's movement, over a paper's ``coverage``; none if nothing moves."""
        self._stage = stage
        self._cover: RenderedHand | None = None
        grip = stage.grip(beat, 0.0)
        if grip is not None:
            session = stage.session
            number = beat.step + 100 * beat.movement
            reach = grasping_hand(
                session.seed, number, grip[1], grip[0], stage.camera, coverage, session.unit
            )
            self._reach, self._start = reach, stage.pixel(grip[0])
            self._cover = _painted(stage, reach, number)

    def over(self, picture: Float32s, beat: Beat, part: float) -> Float32s:
        """The picture with the hand over it at a part of a beat."""
        inside = beat.hand[0] + (beat.hand[1] - beat.hand[0]) * (1 - cos(pi * part)) / 2
        if self._cover is None or inside <= 0:
            return picture
        offset = self._offset(beat, part, inside)
        color, opacity, light = (
            _shifted(plane, offset) for plane in (self._cover.color, self._cover.opacity, self._cover.light)
        )
        solid = opacity[..., None]
        return floats(picture * light[..., None] * (1 - solid) + color * solid)

    def _offset(self, beat: Beat, part: float, inside: float) -> Matrix:
        """How far the hand is from where it was painted, in pixels."""
        done = beat.done[0] + part * (beat.done[1] - beat.done[0])
        grip = self._stage.grip(beat, done)
        moved = self._stage.pixel(grip[0]) - self._start if grip is not None else np.zeros(2)
        angle, size = radians(self._reach.angle), self._reach.scale
        along = np.array([cos(angle), -sin(angle)])
        sway = 0.12 * size * sin(2 * pi * 1.3 * part * beat.seconds) if beat.sway else 0.0
        offset: Matrix = moved - (1 - inside) * 2.2 * size * along + sway * np.array([along[1], -along[0]])
        return offset


def _painted(stage: Stage, reach: PlacedHand, number: int) -> RenderedHand:
    """A hand in a picture with room around it."""
    x, y = reach.wrist
    shape = SIZE[1] + 2 * _ROOM, SIZE[0] + 2 * _ROOM
    shifted = replace(reach, wrist=(x + _ROOM, y + _ROOM))
    return render_hand(shifted, shape, stage.shading.towards, stage.session.seed, number)


def _shifted(plane: Float32s, offset: Matrix) -> Float32s:
    """The part of a painted plane that is in the picture when the hand has moved by ``offset`` pixels."""
    motion = np.array([[1, 0, offset[0] - _ROOM], [0, 1, offset[1] - _ROOM]])
    return floats(cv2.warpAffine(plane, motion, SIZE, borderMode=cv2.BORDER_REPLICATE))


class _Painter:
    """Paints image after image of a film, keeping what the next one shows again."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._worn: tuple[object, SheetTexture] = (None, stage.session.sheet)
        self._still: tuple[Moment | None, tuple[Float32s, NDArray[np.uint8]]] | None = None
        self._actor: tuple[tuple[int, int], Actor] | None = None

    def light(self, beat: Beat, part: float) -> Float32s:
        """The linear colour of the scene at part of a beat."""
        moment = self._stage.moment(beat, part)
        if self._still is None or self._still[0] != moment:
            self._still = moment, self._painted(moment)
        picture, coverage = self._still[1]
        if beat.hand == (0.0, 0.0):
            return picture
        owner = beat.step, beat.movement
        if self._actor is None or self._actor[0] != owner:
            self._actor = owner, Actor(self._stage, beat, coverage)
        return self._actor[1].over(picture, beat, part)

    def _painted(self, moment: Moment) -> tuple[Float32s, NDArray[np.uint8]]:
        view = self._stage.session.view(moment)
        if self._worn[0] is not view.paper:
            self._worn = view.paper, creased(self._stage.session.sheet, view.paper)
        return self._stage.paint(view, self._worn[1])


def _images(
    stage: Stage, beats: Sequence[Beat], looks: Sequence[Look], places: Sequence[int], parts: Sequence[float]
) -> Iterator[NDArray[np.uint8]]:
    """The images, sRGB (height, width, 3). ``looks`` begins with the one before the first beat."""
    scene = stage.session.scene
    noise = stream(stage.session.seed, "grain").normal(0, scene.noise, (_GRAINS, SIZE[1], SIZE[0], 3))
    painter, lamps = _Painter(stage), _Lamps(scene)
    for number, (place, part) in enumerate(zip(places, parts, strict=True)):
        before, after, beat = looks[place], looks[place + 1], beats[place]
        share = float(np.clip((part - 0.5) * beat.seconds / _LAMP_SECONDS, 0, 1))
        lit = painter.light(beat, part) * lamps.light(before.lamp, after.lamp, share)
        nudge = _nudge(after if part >= 0.5 else before)
        lit = cv2.warpAffine(lit, nudge, SIZE, borderMode=cv2.BORDER_REFLECT_101)
        encoded = to_srgb(floats(cv2.GaussianBlur(lit, (0, 0), scene.blur)))
        yield np.clip(np.rint(encoded + noise[number % _GRAINS]), 0, 255).astype(np.uint8)


def _nudge(look: Look) -> Matrix:
    x, y, angle = look.nudge
    motion = np.asarray(cv2.getRotationMatrix2D((SIZE[0] / 2, SIZE[1] / 2), angle, 1.0), np.float64)
    motion[:, 2] += (x, y)
    return motion


class _Lamps:
    """The light of each image."""

    def __init__(self, scene: PhotoScene) -> None:
        self._scene = scene
        self._fields: dict[Lamp, Float32s] = {}

    def light(self, before: Lamp, after: Lamp, share: float) -> Float32s:
        """Light (height, width, 3) on the way from one lamp to another."""
        if before == after or share == 1:
            return self._field(after)
        return floats((1 - share) * self._field(before) + share * self._field(after))

    def _field(self, lamp: Lamp) -> Float32s:
        if lamp not in self._fields:
            self._fields[lamp] = lamp_light(self._scene, lamp, SIZE)
        return self._fields[lamp]
