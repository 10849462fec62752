"""Whether a reconstruction stays the same when its photos are saved, shifted, scaled or lit a little differently. Prints JSON.

    python benchmarks/reconstruction/stability.py [--sequences NAME ...] [--changes NAME ...] [--mode solver|run]

The sequences are the examples that README names. Each is reconstructed from its photos as they are, and once for each change
of them: saved anew as JPEG of quality 85 or as PNG, moved by a pixel, made larger or smaller by 2 %, with a gamma of 0.9 or 1.1.
`same` says that every state is that of the photos as they are, `exact` that the last state is the true one, both by
`exactness.py`; `parted_at` is the first frame whose state is another, and what was done there and found.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from exactness import exactness
from folding_schemas.actions import Program, action_text
from folding_server.arrays import RgbImage
from folding_server.frames.image_files import decode, encode_jpeg, encode_png
from folding_server.frames.manifest import FILE_NAME, read_manifest
from folding_server.interchange.programs import load_program
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper
from reconstructing import Reconstruction, reconstruct

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NAMES = ("cat", "cup", "heart")
QUALITY = 85
"""Of a JPEG that is saved once more: what phones and messengers use, about."""
SCALES, GAMMAS = (0.98, 1.02), (0.9, 1.1)
Change = Callable[[RgbImage], RgbImage]


def _shifted(rgb: RgbImage) -> RgbImage:
    """Everything a pixel further right and down."""
    return np.asarray(np.pad(rgb, ((1, 0), (1, 0), (0, 0)), mode="edge")[:-1, :-1], np.uint8)


def _scaled(factor: float) -> Change:
    """All of the picture larger or smaller."""

    def change(rgb: RgbImage) -> RgbImage:
        way = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
        return np.asarray(cv2.resize(rgb, None, fx=factor, fy=factor, interpolation=way), np.uint8)

    return change


def _gamma(exponent: float) -> Change:
    """The picture as shown with another gamma: brighter below 1, darker above."""
    table = np.rint(255 * (np.arange(256) / 255) ** exponent).astype(np.uint8)
    return lambda rgb: np.asarray(table[rgb], np.uint8)


def _same(rgb: RgbImage) -> RgbImage:
    return rgb


CHANGES: dict[str, Change] = {
    "jpeg 85": _same,
    "png": _same,
    "a pixel": _shifted,
    **{f"scale {factor}": _scaled(factor) for factor in SCALES},
    **{f"gamma {exponent}": _gamma(exponent) for exponent in GAMMAS},
}
"""What is done to the photos. All but the first are kept without loss."""


def changed_sequence(source: Path, change: str, folder: Path) -> Path:
    """A sequence whose keyframes are those of another, changed; written into an empty folder."""
    manifest = read_manifest(source)
    frames = folder / "frames"
    frames.mkdir(parents=True)
    for index in manifest.indices:
        rgb = CHANGES[change](decode(source / (manifest.frames or "frames") / f"{index:06d}.jpg"))
        lossy = change.startswith("jpeg")
        picture = encode_jpeg(rgb, QUALITY) if lossy else encode_png(rgb)
        (frames / f"{index:06d}.{'jpg' if lossy else 'png'}").write_bytes(picture.data)
    (folder / FILE_NAME).write_text((source / FILE_NAME).read_text(encoding="utf-8"), encoding="utf-8")
    return folder


def papers_of(name: str, made: Reconstruction) -> list[Paper]:
    """The states that a reconstruction has, the flat sheet first."""
    return keyframe_papers(Program(name=name, steps=made.steps))


def compared(name: str, usual: Reconstruction, made: Reconstruction) -> dict[str, Any]:
    """How a reconstruction differs from that of the photos as they are, and whether it ends in the truth."""
    truth = load_program((EXAMPLES / name / "program.json").read_text(encoding="utf-8"))
    wanted, found = papers_of(name, usual), papers_of(name, made)
    pairs = list(zip(wanted, found, strict=False))
    parted = [frame for frame, (a, b) in enumerate(pairs, 1) if not exactness(a, b).holds()]
    same = not parted and len(wanted) == len(found)
    row: dict[str, Any] = {
        "same": same,
        "exact": made.completed and exactness(keyframe_papers(truth)[-1], found[-1]).holds(),
    }
    if not same:
        frame = parted[0] if parted else len(pairs) + 1
        row["parted_at"] = {
            "frame": frame,
            "usual": _step(usual, frame),
            "found": _step(made, frame) if frame <= len(found) else made.reason,
        }
    return row


def _step(made: Reconstruction, frame: int) -> list[str]:
    return [action_text(action) for step in made.steps[frame - 2 : frame - 1] for action in step]


def measured(name: str, changes: Sequence[str], mode: str) -> dict[str, Any]:
    """One row a change for one example."""
    usual = reconstruct(EXAMPLES / name, mode)
    rows: dict[str, Any] = {"as they are": compared(name, usual, usual)}
    for change in changes:
        started = time.perf_counter()
        with TemporaryDirectory() as folder:
            made = reconstruct(changed_sequence(EXAMPLES / name, change, Path(folder) / name), mode)
        rows[change] = {**compared(name, usual, made), "seconds": round(time.perf_counter() - started, 1)}
        sys.stderr.write(f"{name}, {change}: {'same' if rows[change]['same'] else rows[change]}\n")
    return rows


def main() -> None:
    """Reconstruct everything that was asked for and print how it compares."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sequences", nargs="+", choices=NAMES, default=list(NAMES))
    parser.add_argument("--changes", nargs="+", choices=list(CHANGES), default=list(CHANGES))
    parser.add_argument("--mode", choices=("solver", "run"), default="solver")
    options = parser.parse_args()
    rows = {name: measured(name, options.changes, options.mode) for name in options.sequences}
    changed = [row for found in rows.values() for change, row in found.items() if change != "as they are"]
    answer = {
        "mode": options.mode,
        "reconstructions": len(changed),
        "same": sum(row["same"] for row in changed),
        "exact": sum(row["exact"] for row in changed),
        "sequences": rows,
    }
    json.dump(answer, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
