"""Photographing a program: keyframes that look like photos, with the truth beside them.

The folder gets ``keyframes.json`` and ``frames/000001.jpg`` ... as any sequence has, and ``program.json`` and
``truth.json``, which say what was folded and where everything lies in the pictures.
"""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from folding_schemas.actions import Program
from numpy.typing import NDArray

from folding_server.errors import PhotoError
from folding_server.photographer.camera import Camera
from folding_server.photographer.chance import stream
from folding_server.photographer.colors import Floats, near_color
from folding_server.photographer.framing import fitting_fraction, middle, pivots
from folding_server.photographer.geometry import Placement, place
from folding_server.photographer.hands import Reach, cover_with, reaching_hand
from folding_server.photographer.imprecision import imprecise
from folding_server.photographer.levels import Level, level_named
from folding_server.photographer.lighting import frame_lamp, lamp_light
from folding_server.photographer.replaying import keyframe_papers
from folding_server.photographer.scene import Drift, Scene, compose, drifts, frame_camera
from folding_server.photographer.sensor import expose, jpeg, png
from folding_server.photographer.sheet_texture import SheetTexture, blank_sheet, creased
from folding_server.photographer.stacking import Shading, paint_stack, throw_direction
from folding_server.photographer.table import seen_table, table_texture
from folding_server.photographer.truth import NOTE, frame_truth, scene_truth
from folding_server.simulator import Paper
from folding_server.simulator.plane_geometry import Point

SIZES = (64, 4096)
"""Least and greatest width and height of a picture in pixels."""
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class PhotographResult:
    """What was written: the sequence's folder, its name and the number of keyframes."""

    folder: Path
    name: str
    frames: int


@dataclass(frozen=True)
class Session:
    """All that the frames of one sequence share."""

    seed: int
    level: Level
    size: tuple[int, int]
    scene: Scene
    papers: tuple[Paper, ...]
    drifts: tuple[Drift, ...]
    centers: tuple[Point, ...]
    sheet_fraction: float
    sheet: SheetTexture
    table: Floats

    def camera(self, index: int) -> Camera:
        """The camera at a keyframe, counted from 0."""
        return frame_camera(self.scene, self.level, self.size, self.sheet_fraction, self.seed, index)

    def placement(self, index: int) -> Placement:
        """The paper on the table at a keyframe, counted from 0."""
        motion = self.drifts[index].folded_to_table(self.centers[index])
        return place(self.papers[index], self.camera(index), motion)


def photograph(
    program: Program,
    folder: Path,
    seed: int,
    level: int = 1,
    size: tuple[int, int] = (800, 800),
    progress: Progress | None = None,
) -> PhotographResult:
    """Write photo-like keyframes of a program into a folder; the same arguments always give the same files.

    ``size`` is (width, height) in pixels; ``progress`` is told (frames done, frames in all). The program's
    colours are used where it states them. Raises PhotoError for a level, size, colour or folder that cannot
    be used, and ProgramError for a program that cannot be folded.
    """
    ranges = level_named(level)
    program = imprecise(program, _checked_seed(seed), ranges)
    session = _prepare(program, seed, ranges, _checked_size(size))
    frames = _cleared(folder)
    truths = []
    for index in range(len(session.papers)):
        picture, hand = _photo(session, index)
        name = f"{index + 1:06d}.jpg"
        (frames / name).write_bytes(jpeg(picture, session.level.quality))
        mask = None if hand is None else _write_mask(folder, index, hand.hidden)
        reach = None if hand is None else hand.reach
        truths.append(_truth(session, program, index, f"frames/{name}", reach, mask))
        if progress is not None:
            progress(index + 1, len(session.papers))
    _write_documents(folder, program, session, truths, level)
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


def _prepare(program: Program, seed: int, level: Level, size: tuple[int, int]) -> Session:
    """Draw the scene, fold the program and frame it."""
    papers = tuple(keyframe_papers(program))
    scene = compose(seed, level, program.front_color, program.back_color)
    walk = tuple(drifts(seed, level, len(papers)))
    spots = pivots(program)
    x, y = middle(papers, spots)
    centers = tuple((x + px, y + py) for px, py in spots)
    fraction = fitting_fraction(
        lambda f: frame_camera(scene, level, size, f, seed, 0),
        papers,
        walk,
        centers,
        size,
        wanted=float(stream(seed, "framing").uniform(0.46, 0.56)),
    )
    sheet, table = blank_sheet(scene, seed, program.sheet), table_texture(scene, seed)
    return Session(seed, level, size, scene, papers, walk, centers, fraction, sheet, table)


@dataclass(frozen=True)
class _Covering:
    """A hand in a picture, and the pixels (height, width) that it hides, 0 or 255."""

    reach: Reach
    hidden: NDArray[np.uint8]


def _photo(session: Session, index: int) -> tuple[NDArray[np.uint8], _Covering | None]:
    """One picture (height, width, 3) RGB, and the hand in it."""
    scene, seed = session.scene, session.seed
    placement = session.placement(index)
    lamp = frame_lamp(scene, session.level, seed, index)
    tones = stream(seed, "tones", index).normal(1, 0.018, len(placement.paper.faces))
    unit = session.sheet_fraction * min(session.size)
    towards = throw_direction(lamp.azimuth, scene.roll)
    albedo, light, coverage = paint_stack(
        seen_table(session.table, placement.camera, session.size),
        placement,
        creased(session.sheet, placement.paper),
        Shading(towards, scene.shadow),
        unit,
        dict(zip(sorted(placement.paper.faces), tones.tolist(), strict=True)),
    )
    lit = albedo * light[..., None]
    reach = reaching_hand(seed, session.level, index, coverage, unit)
    covering = None
    if reach is not None:
        cover = cover_with(reach, coverage.shape, towards, seed, index)
        opacity = cover.opacity[..., None]
        lit = lit * cover.light[..., None] * (1 - opacity) + cover.color * opacity
        covering = _Covering(reach, (cover.opacity > 0.5).astype(np.uint8) * np.uint8(255))
    return expose(lit * lamp_light(scene, lamp, session.size), scene, seed, index), covering


def _truth(
    session: Session, program: Program, index: int, image: str, hand: Reach | None, mask: str | None
) -> dict[str, Any]:
    step = program.steps[index - 1] if index else ()
    before = session.papers[max(index - 1, 0)]
    placement, drift = session.placement(index), session.drifts[index]
    return frame_truth(index + 1, image, step, before, placement, drift, hand, mask)


def _write_mask(folder: Path, index: int, hidden: NDArray[np.uint8]) -> str:
    """Write which pixels a hand hides, and say where."""
    name = f"masks/{index + 1:06d}.png"
    (folder / "masks").mkdir(exist_ok=True)
    (folder / name).write_bytes(png(hidden))
    return name


def _cleared(folder: Path) -> Path:
    """The frames folder, without photos of an earlier run. PhotoError if the folder holds something else."""
    if folder.exists() and not folder.is_dir():
        raise PhotoError(f"{folder} is a file; give a folder to write the sequence into.")
    if (folder / "keyframes.json").exists() and not (folder / "truth.json").exists():
        raise PhotoError(f"{folder} holds a sequence that was not made here; give another folder.")
    frames = folder / "frames"
    try:
        frames.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PhotoError(f"{folder} cannot be written ({error.strerror}); give another folder.") from error
    for old in (*frames.iterdir(), *(folder / "masks").glob("*")):
        if re.fullmatch(r"\d{6}\.(jpg|png)", old.name):
            old.unlink()
    return frames


def _write_documents(
    folder: Path, program: Program, session: Session, truths: list[dict[str, Any]], level: int
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
        "keyframes": list(range(1, len(truths) + 1)),
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
        "frames": truths,
    }
    _write(folder / "keyframes.json", json.dumps(manifest, indent=1))
    _write(folder / "program.json", program.model_dump_json(indent=1, exclude_none=True))
    _write(folder / "truth.json", json.dumps(truth, separators=(",", ":")))


def _write(path: Path, text: str) -> None:
    path.write_text(text + "\n", encoding="utf-8")
