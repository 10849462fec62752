"""Taking one picture: table, paper, hand, light and sensor put together."""

from dataclasses import dataclass

import numpy as np

from folding_server.arrays import ByteMask, RgbImage
from folding_server.photographer.grasp import grasping_hand
from folding_server.photographer.hand_model import PlacedHand, reaching_hand, render_hand
from folding_server.photographer.layer_rendering import Shading, paint_stack, shadow_direction
from folding_server.photographer.lighting import frame_lamp, lamp_light
from folding_server.photographer.moments import Moment
from folding_server.photographer.rng import stream
from folding_server.photographer.sensor import expose
from folding_server.photographer.session import Session
from folding_server.photographer.sheet_texture import creased
from folding_server.photographer.table import seen_table
from folding_server.photographer.table_objects import laid_on
from folding_server.simulator import Paper


@dataclass(frozen=True)
class HandInPhoto:
    """A hand in a picture, and the pixels (height, width) that it hides, 0 or 255."""

    placed: PlacedHand
    hidden: ByteMask


def render_photo(session: Session, moment: Moment) -> tuple[RgbImage, HandInPhoto | None]:
    """One picture (height, width, 3) RGB, and the hand in it."""
    scene, seed = session.scene, session.seed
    view = session.view(moment)
    lamp = frame_lamp(scene, session.level, seed, moment)
    towards = shadow_direction(lamp.azimuth, session.roll_at(moment))
    table = laid_on(session.table, session.objects_at(moment))
    albedo, light, coverage = paint_stack(
        seen_table(table, view.camera, session.size),
        view,
        creased(session.sheet, view.paper),
        Shading(towards, scene.shadow, lamp.azimuth),
        session.unit_at(moment),
        _tones(seed, moment, view.paper),
    )
    lit = albedo * light[..., None]
    placed = _hand(session, moment, coverage)
    hand = None
    if placed is not None:
        rendered = render_hand(placed, coverage.shape, towards, seed, moment.number)
        opacity = rendered.opacity[..., None]
        lit = lit * rendered.light[..., None] * (1 - opacity) + rendered.color * opacity
        hand = HandInPhoto(placed, (rendered.opacity > 0.5).astype(np.uint8) * np.uint8(255))
    return expose(lit * lamp_light(scene, lamp, session.size), scene, seed, moment.number), hand


def _tones(seed: int, moment: Moment, paper: Paper) -> dict[int, float]:
    """The brightness of each face, as faces do not lie quite level: on the way that of the next keyframe."""
    keyframe = moment.keyframe + (moment.image > 0)
    tones = stream(seed, "tones", keyframe).normal(1, 0.018, len(paper.faces))
    return dict(zip(sorted(paper.faces), tones.tolist(), strict=True))


def _hand(session: Session, moment: Moment, coverage: ByteMask) -> PlacedHand | None:
    """The hand in a picture, if there is one: over the paper at a keyframe, moving it in between."""
    seed, unit = session.seed, session.unit_at(moment)
    if moment.image == 0:
        return reaching_hand(seed, session.level, moment.keyframe, coverage, unit)
    grasp = session.grasp(moment)
    if grasp is None:
        return None
    spot, side = grasp
    return grasping_hand(seed, moment.keyframe, side, spot, session.camera(moment), coverage, unit)
