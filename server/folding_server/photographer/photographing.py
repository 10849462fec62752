"""Photographing a program: keyframes that look like photos, and images in between, with the truth beside them.

The folder gets ``keyframes.json`` and ``frames/000001.jpg`` ... as any sequence has, and ``program.json`` and
``truth.json``, which say what was folded and where everything lies in the pictures.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_schemas.actions import Program

from folding_server.arrays import ByteMask
from folding_server.errors import PhotoError
from folding_server.photographer.color_spaces import near_color
from folding_server.photographer.hand_model import PlacedHand
from folding_server.photographer.imprecision import imprecise
from folding_server.photographer.levels import level_named
from folding_server.photographer.moments import Moment, checked_between
from folding_server.photographer.out_folder import require_usable
from folding_server.photographer.photo_rendering import render_photo
from folding_server.photographer.rng import stream
from folding_server.photographer.sensor import jpeg, png
from folding_server.photographer.session import Session, prepare
from folding_server.photographer.truth import NOTE, between_truth, frame_truth, scene_truth

SIZES = (64, 4096)
"""Least and greatest width and height of a picture in pixels."""
PhotographProgress = Callable[[int, int], None]


@dataclass(frozen=True)
class PhotographResult:
    """What was written: the sequence's folder, its name and the number of keyframes."""

    folder: Path
    name: str
    frames: int


def photograph(
    program: Program,
    folder: Path,
    seed: int,
    level: int = 1,
    size: tuple[int, int] = (800, 800),
    progress: PhotographProgress | None = None,
    between: int = 0,
) -> PhotographResult:
    """Write photo-like keyframes of a program into a folder; the same arguments always give the same files.

    ``size`` is (width, height) in pixels; ``progress`` is told (keyframes done, keyframes in all). ``between``
    images follow each keyframe but the last and show the paper on its way to the next; the keyframes are the
    same whatever their number. The program's colours are used where it states them. Raises PhotoError for a
    level, size, number of images, colour or folder that cannot be used, and ProgramError for a program that
    cannot be folded.
    """
    ranges = level_named(level)
    require_usable(folder)
    program = imprecise(program, _checked_seed(seed), ranges)
    session = prepare(program, seed, ranges, _checked_size(size), checked_between(between))
    frames = _cleared(folder)
    images: list[dict[str, Any]] = []
    for index, moment in enumerate(session.moments, 1):
        picture, hand = render_photo(session, moment)
        name = f"{index:06d}.jpg"
        (frames / name).write_bytes(jpeg(picture, session.level.quality))
        mask = None if hand is None else _write_mask(folder, index, hand.hidden)
        placed = None if hand is None else hand.placed
        images.append(_truth(session, program, moment, f"frames/{name}", placed, mask))
        if progress is not None and moment.image == 0:
            progress(moment.keyframe + 1, len(session.papers))
    _write_documents(folder, program, session, images, level)
    return PhotographResult(folder, program.name, len(session.papers))


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    low, high = SIZES
    if not all(low <= side <= high for side in size):
        raise PhotoError(
            f"The size {size[0]}x{size[1]} cannot be used; give a width and height from {low} to {high} "
            "pixels."
        )
    return size


def _checked_seed(seed: int) -> int:
    if seed < 0:
        raise PhotoError(f"The seed {seed} is negative; give a whole number from 0.")
    return seed


def _truth(
    session: Session, program: Program, moment: Moment, image: str, hand: PlacedHand | None, mask: str | None
) -> dict[str, Any]:
    """The truth of one image: of a keyframe, or of one on the way to the next."""
    if moment.image:
        movement, part = session.under_way(moment)
        return between_truth(moment, image, movement, part, session.view(moment), hand, mask)
    index = moment.keyframe
    step = program.steps[index - 1] if index else ()
    before = session.papers[max(index - 1, 0)]
    return frame_truth(
        index + 1,
        image,
        step,
        before,
        session.placement(index),
        session.drifts[index],
        hand,
        mask,
        session.curled(index),
        session.objects_at(moment),
    )


def _write_mask(folder: Path, index: int, hidden: ByteMask) -> str:
    """Write which pixels a hand hides, and say where."""
    name = f"masks/{index:06d}.png"
    (folder / "masks").mkdir(exist_ok=True)
    (folder / name).write_bytes(png(hidden))
    return name


def _cleared(folder: Path) -> Path:
    """The frames folder, without photos of an earlier run. PhotoError if it cannot be written."""
    frames = folder / "frames"
    try:
        frames.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PhotoError(f"{folder} cannot be written ({error.strerror}); give another folder.") from error
    for old in (*frames.iterdir(), *(folder / "masks").glob("*")):
        old.unlink()
    return frames


def _write_documents(
    folder: Path, program: Program, session: Session, images: list[dict[str, Any]], level: int
) -> None:
    rng = stream(session.seed, "declared")
    colors = {
        "front_color": near_color(rng, session.scene.front, 3.0),
        "back_color": near_color(rng, session.scene.back, 3.0),
    }
    manifest = {
        "name": program.name,
        "frames": "frames",
        **colors,
        "keyframes": [index for index, moment in enumerate(session.moments, 1) if moment.image == 0],
    }
    truth = {
        "name": program.name,
        "note": NOTE,
        "seed": session.seed,
        "level": level,
        "scene": scene_truth(session.scene, session.sheet_fraction, session.size),
        "front_color": session.scene.front,
        "back_color": session.scene.back,
        "sheet": list(program.sheet),
        "frames": [told for told, moment in zip(images, session.moments, strict=True) if moment.image == 0],
    }
    if session.earlier:
        truth["precreases"] = [[list(end) for end in crease] for crease in session.earlier]
    if len(images) > len(session.papers):
        truth["between"] = [
            told for told, moment in zip(images, session.moments, strict=True) if moment.image
        ]
    _write(folder / "keyframes.json", json.dumps(manifest, indent=1))
    _write(folder / "program.json", program.model_dump_json(indent=1, exclude_none=True))
    _write(folder / "truth.json", json.dumps(truth, separators=(",", ":")))


def _write(path: Path, text: str) -> None:
    path.write_text(text + "\n", encoding="utf-8")
