"""One sitting of the photographer: the scene, the paper at each keyframe and on its way to the next."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import asin, degrees

import numpy as np
from folding_schemas.actions import Program

from folding_server.arrays import Float32s
from folding_server.geometry.line import Point
from folding_server.photographer.earlier_creases import EarlierCrease, earlier_creases
from folding_server.photographer.flap_rotation import FlapRotationView
from folding_server.photographer.framing import bounding_centre, fits, fitting_fraction, on_table, pivots
from folding_server.photographer.free_camera import Standpoint, seeing_all, standpoints
from folding_server.photographer.grasp import arm_side, grasp_point
from folding_server.photographer.levels import Level
from folding_server.photographer.moments import Moment, moments
from folding_server.photographer.movements import FLAT, Movement, Slide, Swing, movements
from folding_server.photographer.photo_scene import (
    Drift,
    PhotoScene,
    between_drifts,
    compose,
    frame_camera,
    sheet_drifts,
)
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.photographer.placement import PaperView, Placement, place
from folding_server.photographer.replaying import keyframe_papers
from folding_server.photographer.rng import stream
from folding_server.photographer.sheet_texture import SheetTexture, blank_sheet, worn
from folding_server.photographer.table import table_texture
from folding_server.photographer.table_objects import TableObject, table_objects, under_way
from folding_server.simulator import Paper

CURL_HEIGHT = 0.04
"""Sheet sides that the edge of a flap stands off at most: more, and people press it down before they take the photo."""
EARLIER_STRENGTH = 0.7
"""How worn creases of earlier folds are, beside those that stay folded."""
WAY = (0.1, 0.4, 0.7)
"""Parts of a movement at which an arm is looked for that is clear of the paper."""


@dataclass(frozen=True)
class Session:
    """All that the images of one sequence share; ``movements`` has those that lead on from each keyframe.

    At levels at which the camera moves, ``standpoints`` has where it is at each keyframe; ``objects`` has what lies on the table
    then, ``earlier`` the creases that the sheet had before.
    """

    seed: int
    level: Level
    size: tuple[int, int]
    scene: PhotoScene
    papers: tuple[Paper, ...]
    movements: tuple[tuple[Movement, ...], ...]
    moments: tuple[Moment, ...]
    drifts: tuple[Drift, ...]
    middle: Point
    centers: tuple[Point, ...]
    sheet_fraction: float
    sheet: SheetTexture
    table: Float32s
    standpoints: tuple[Standpoint, ...] = ()
    objects: tuple[tuple[TableObject, ...], ...] = ()
    earlier: tuple[EarlierCrease, ...] = ()

    @property
    def unit(self) -> float:
        """Pixels to a sheet side, where the camera is as far away as usual."""
        return self.sheet_fraction * min(self.size)

    def unit_at(self, moment: Moment) -> float:
        """Pixels to a sheet side at a moment."""
        here = self._standpoint(moment)
        return self.unit * (here.nearness if here else 1.0)

    def roll_at(self, moment: Moment) -> float:
        """By how many degrees the camera is rolled at a moment."""
        here = self._standpoint(moment)
        return here.roll if here else self.scene.roll

    def _standpoint(self, moment: Moment) -> Standpoint | None:
        """Where a camera that moves is at a moment."""
        if not self.standpoints:
            return None
        here = self.standpoints[moment.keyframe]
        return here.between(self.standpoints[moment.keyframe + 1], moment.share) if moment.image else here

    def objects_at(self, moment: Moment) -> tuple[TableObject, ...]:
        """The things on the table at a moment."""
        if not self.objects:
            return ()
        here = self.objects[moment.keyframe]
        return under_way(here, self.objects[moment.keyframe + 1], moment.share) if moment.image else here

    def curled(self, index: int) -> FlapRotationView | None:
        """The paper at a keyframe with the flap that was folded last not quite down; None where no flap was folded over the rest."""
        if self.level.curl == (0.0, 0.0) or index == 0:
            return None
        last = self.movements[index - 1][-1]
        if not isinstance(last, Swing) or last.action.action != "fold" or not last.over or last.whole:
            return None
        drawn = float(stream(self.seed, "curl", index).uniform(*self.level.curl))
        up = min(drawn, degrees(asin(CURL_HEIGHT / max(last.reach, CURL_HEIGHT))))
        motion = self.drifts[index].folded_to_table(self.middle)
        return FlapRotationView(last, FLAT - up, self.camera(Moment(index)), motion)

    def camera(self, moment: Moment) -> Camera:
        """The camera at a moment."""
        here = self._standpoint(moment)
        if here is not None:
            focal = self.scene.lens * min(self.size)
            return here.camera(self.size, focal, focal / self.unit)
        return frame_camera(self.scene, self.level, self.size, self.seed, moment, self.sheet_fraction)

    def placement(self, index: int) -> Placement:
        """The paper on the table at a keyframe, counted from 0."""
        motion = self.drifts[index].folded_to_table(self.centers[index])
        return place(self.papers[index], self.camera(Moment(index)), motion)

    def under_way(self, moment: Moment) -> tuple[Movement, float]:
        """What moves at a moment between two keyframes, and what part of it is done, 0 to 1."""
        steps = self.movements[moment.keyframe]
        done = moment.share * len(steps)
        number = min(int(done), len(steps) - 1)
        return steps[number], done - number

    def view(self, moment: Moment) -> PaperView:
        """The paper as the camera sees it at a moment."""
        if moment.image == 0:
            return self.curled(moment.keyframe) or self.placement(moment.keyframe)
        return self._moving(moment, *self.under_way(moment))

    def grasp(self, moment: Moment) -> tuple[Matrix, str] | None:
        """The spot (3,) over the table that a hand holds at a moment, and the side that it comes from.

        None where nothing moves, and at levels without hands.
        """
        movement, part = self.under_way(moment)
        if self.level.hands == 0 or (isinstance(movement, Slide) and movement.degrees == 0):
            return None
        number = self.movements[moment.keyframe].index(movement)
        rng = stream(self.seed, f"grip {number}", moment.keyframe)
        spot = grasp_point(movement, rng)
        way = np.array([self._spot(moment, movement, p, spot) for p in WAY])
        outline = self._moving(moment, movement, 0.0).corners
        pixels = self.camera(moment).project(way)
        side = arm_side(rng, pixels, (outline.min(0) + outline.max(0)) / 2, self.unit_at(moment))
        return self._spot(moment, movement, part, spot), side

    def _motion(self, moment: Moment) -> Matrix:
        """Where the sheet's middle spot lies at a moment between two keyframes: affine (2, 3)."""
        first, second = self.drifts[moment.keyframe : moment.keyframe + 2]
        return between_drifts(first, second, moment.share).folded_to_table(self.middle)

    def _moving(self, moment: Moment, movement: Movement, part: float) -> PaperView:
        camera, motion = self.camera(moment), self._motion(moment)
        if isinstance(movement, Slide):
            return place(movement.turned(part * movement.degrees), camera, motion)
        return FlapRotationView(movement, part * movement.degrees, camera, motion)

    def _spot(self, moment: Moment, movement: Movement, part: float, spot: Point) -> Matrix:
        """Where a spot of the moving paper is over the table after a part of the movement: (3,)."""
        motion = self._motion(moment)
        if isinstance(movement, Slide):
            moved = movement.motion(part * movement.degrees)(spot)
            return np.array([*(motion @ [*moved, 1.0]), 0.0])
        return FlapRotationView(movement, part * movement.degrees, self.camera(moment), motion).point(spot)


def prepare(program: Program, seed: int, level: Level, size: tuple[int, int], between: int) -> Session:
    """Draw the scene, fold the program and frame it."""
    papers = tuple(keyframe_papers(program))
    scene = compose(seed, level, program.front_color, program.back_color)
    walk = tuple(sheet_drifts(seed, level, len(papers)))
    spots = pivots(program)
    x, y = bounding_centre(papers, spots)
    centers = tuple((x + px, y + py) for px, py in spots)
    camera_at = partial(frame_camera, scene, level, size, seed, Moment(0))
    wanted = float(stream(seed, "framing").uniform(0.46, 0.56))
    fraction = fitting_fraction(camera_at, papers, walk, centers, size, wanted)
    earlier = earlier_creases(seed, level, program.sheet)
    lying = zip(papers, walk, centers, strict=True)
    reach = max(float(np.hypot(*on_table(*each).T).max()) for each in lying)
    return Session(
        seed,
        level,
        size,
        scene,
        papers,
        tuple(movements(program)) if between or level.curl != (0.0, 0.0) else (),
        tuple(moments(seed, len(papers), between)),
        walk,
        (x, y),
        centers,
        fraction,
        worn(blank_sheet(scene, seed, program.sheet), earlier, EARLIER_STRENGTH),
        table_texture(scene, seed),
        _standpoints(seed, level, scene, size, fraction, papers, walk, centers),
        tuple(table_objects(seed, level, len(papers), reach)),
        earlier,
    )


def _standpoints(
    seed: int,
    level: Level,
    scene: PhotoScene,
    size: tuple[int, int],
    fraction: float,
    papers: Sequence[Paper],
    drifts: Sequence[Drift],
    centers: Sequence[Point],
) -> tuple[Standpoint, ...]:
    """Where the camera is at each keyframe, so that it sees all of the paper; none at levels at which it stands."""
    if level.zoom is None:
        return ()
    focal = scene.lens * min(size)

    def sees_all(index: int, here: Standpoint) -> bool:
        camera = here.camera(size, focal, focal / (fraction * min(size)))
        return fits(camera, papers[index], drifts[index], centers[index], size)

    return seeing_all(standpoints(seed, level, len(papers)), sees_all)
