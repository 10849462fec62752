"""What is written beside the photos: for each frame the actions, the folded state, the camera, the pixels."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from folding_schemas.actions import Action

from folding_server.photographer.flap_rotation import FlapRotationView
from folding_server.photographer.hand_model import PlacedHand
from folding_server.photographer.moments import Moment
from folding_server.photographer.movements import FLAT, Movement, Swing
from folding_server.photographer.photo_scene import Drift, PhotoScene
from folding_server.photographer.pinhole_camera import Camera, Matrix
from folding_server.photographer.placement import PaperView, Placement
from folding_server.photographer.table_objects import TableObject
from folding_server.simulator import Paper

NOTE = (
    "Rendered, not taken. Pixels: x right, y down, image corner at 0,0. Camera: x_cam = R x_table + t"
    " (y down, z forward), then K; table plane z = 0, unit = sheet side. folded_to_pixel is the homography at"
    " z = 0; vertex_pixels are at the rendered height (the mean over the layers). orientations: 0 = front"
    " side up; order: faces bottom to top."
)


def frame_truth(
    frame: int,
    image: str,
    step: tuple[Action, ...],
    before: Paper,
    placement: Placement,
    drift: Drift,
    hand: PlacedHand | None,
    mask: str | None,
    curled: FlapRotationView | None = None,
    objects: Sequence[TableObject] = (),
) -> dict[str, Any]:
    """The truth of one frame as plain JSON values; ``before`` is the paper that the step started from.

    ``mask`` names the picture of the pixels that the hand hides, ``curled`` is the paper with a flap that stands up, if one does.
    """
    paper = placement.paper
    return {
        "frame": frame,
        "image": image,
        "step": [_action(action, before, paper) for action in step],
        **_state(paper),
        "camera": _camera(placement),
        "vertex_pixels": {str(v): _rounded(placement.pixels[v], 2) for v in sorted(placement.pixels)},
        "drift": {"rotation_deg": round(drift.rotation, 4), "shift": _rounded(drift.shift, 6)},
        "hand": hand and {**_hand(hand), "mask": mask},
        **({"curl": _curl(curled)} if curled else {}),
        **({"objects": [_object(each, placement.camera) for each in objects]} if objects else {}),
    }


def _curl(view: FlapRotationView) -> dict[str, Any]:
    """By how much a flap stands up, and where its vertices are seen then."""
    seen = {
        v: place
        for face in view.swing.starts
        for v, place in zip(view.paper.faces[face], view.outline(face), strict=True)
    }
    return {
        "degrees": round(FLAT - view.angle, 3),
        "vertex_pixels": {str(v): _rounded(seen[v], 2) for v in sorted(seen)},
    }


def _object(thing: TableObject, camera: Camera) -> dict[str, Any]:
    """A thing on the table, and its outline in the picture."""
    flat = np.column_stack([thing.outline, np.zeros(len(thing.outline))])
    return {
        "kind": thing.kind,
        "middle": _rounded(thing.middle, 4),
        "pixels": _matrix(camera.project(flat), 1),
    }


def between_truth(
    moment: Moment,
    image: str,
    movement: Movement,
    part: float,
    view: PaperView,
    hand: PlacedHand | None,
    mask: str | None,
) -> dict[str, Any]:
    """The truth of an image between two keyframes as plain JSON values: what moves there and how far it has come.

    ``faces`` has what the camera sees, in the order of painting: each face's outline on the sheet and in pixels.
    """
    action = movement.action
    moving = set(movement.starts) if isinstance(movement, Swing) else set(view.paper.faces)
    return {
        "image": image,
        "after_frame": moment.keyframe + 1,
        "share": round(moment.share, 4),
        "action": action and _action(action, movement.before, view.paper),
        "degrees": round(part * movement.degrees, 3),
        "faces": [
            {
                "face": face,
                "moves": action is not None and face in moving,
                "back": int(view.back_up(face)),
                "sheet": [_rounded(place, 6) for place in view.paper.sheet_polygon(face)],
                "pixels": _matrix(view.outline(face), 2),
            }
            for group in view.groups
            for face in group.faces
        ],
        "hand": hand and {**_hand(hand), "mask": mask},
    }


def scene_truth(scene: PhotoScene, sheet_fraction: float, size: tuple[int, int]) -> dict[str, Any]:
    """The scene as plain JSON values."""
    rounded = {
        key: round(value, 4) if isinstance(value, float) else value for key, value in asdict(scene).items()
    }
    return {**rounded, "sheet_fraction": round(sheet_fraction, 4), "size": list(size)}


def _action(action: Action, before: Paper, after: Paper) -> dict[str, Any]:
    """An action with its endpoints on the unfolded sheet, so that it can be read without vertex ids."""
    plain = action.model_dump(mode="json", exclude_none=True)
    edge = plain.get("edge")
    if edge is not None:
        plain["at"] = [_rounded(before.vertices_coords.get(v) or after.vertices_coords[v], 6) for v in edge]
    return plain


def _hand(placed: PlacedHand) -> dict[str, Any]:
    """What is known of a hand; ``cover`` is the part of the paper that it hides."""
    return {
        "pose": placed.hand.pose,
        "side": placed.side,
        "left": placed.hand.left,
        "cover": round(placed.covered, 4),
    }


def _state(paper: Paper) -> dict[str, Any]:
    positions = paper.folded_vertices_coords
    return {
        "vertices": {
            str(v): {"sheet": _rounded(paper.vertices_coords[v], 6), "folded": _rounded(positions[v], 6)}
            for v in sorted(positions)
        },
        "faces": {str(f): list(paper.faces[f]) for f in sorted(paper.faces)},
        "order": list(paper.order),
        "orientations": {str(f): int(paper.back_up(f)) for f in sorted(paper.faces)},
    }


def _camera(placement: Placement) -> dict[str, Any]:
    camera = placement.camera
    return {
        "K": _matrix(camera.K, 4),
        "R": _matrix(camera.R, 8),
        "t": _rounded(camera.t, 8),
        "table_to_pixel": _matrix(camera.table_to_pixel, 8),
        "folded_to_table": _matrix(placement.folded_to_table, 8),
        "folded_to_pixel": _matrix(placement.folded_to_pixel, 8),
    }


def _matrix(matrix: Matrix, decimals: int) -> list[list[float]]:
    return [_rounded(row, decimals) for row in matrix]


def _rounded(values: tuple[float, ...] | Matrix, decimals: int) -> list[float]:
    return [float(v) + 0.0 for v in np.round(np.asarray(values, float), decimals)]
