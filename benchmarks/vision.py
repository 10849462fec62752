"""How well photos with truth are seen: corner error, label accuracy, hidden share, seconds. Prints JSON.

python benchmarks/vision.py FOLDER...    sequence folders, or folders of them, each with a truth.json
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import mean, median
from typing import Any

import cv2
import numpy as np
from folding_server.errors import PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.vision.labels import UNKNOWN, Labels, is_paper
from folding_server.vision.pose import Pose
from folding_server.vision.raster import draw_labels
from folding_server.vision.seeing import SeenFrame, see_sequence

PIXELS_PER_UNIT = 128.0


@dataclass(frozen=True)
class Undeclared:
    """A sequence whose colours nobody declared."""

    sequence: Any
    name: str
    frame_count: int
    front_color: None = None
    back_color: None = None

    def photo(self, frame: int) -> Any:
        """One photo."""
        return self.sequence.photo(frame)


def main() -> None:
    """Measure the folders given on the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--undeclared", action="store_true", help="do not tell the declared colours")
    options = parser.parse_args()
    results = [measure(folder, options.undeclared) for folder in sequences(options.folders)]
    json.dump({"sequences": results, "overall": overall(results)}, sys.stdout, indent=1)
    sys.stdout.write("\n")


def sequences(folders: list[Path]) -> Iterator[Path]:
    """The folders with a truth.json in or below those given."""
    for folder in folders:
        yield from sorted(path.parent for path in folder.rglob("truth.json"))


def measure(folder: Path, undeclared: bool) -> dict[str, Any]:
    """One sequence: errors of its pose and, frame by frame, of its labels."""
    sequence: Any = load_sequence(folder)
    if undeclared:
        sequence = Undeclared(sequence, sequence.name, sequence.frame_count)
    truth = json.loads((folder / "truth.json").read_text())["frames"]
    started = time.perf_counter()
    try:
        eyes = see_sequence(sequence)
    except PhotoError as error:
        return {"sequence": folder.name, "refused": str(error)}
    learned = time.perf_counter()
    frames = [score(eyes.frame(i + 1, PIXELS_PER_UNIT), frame, eyes.pose) for i, frame in enumerate(truth)]
    seconds = time.perf_counter() - learned
    return {
        "sequence": folder.name,
        "corner_error_pixels": round(corner_error(eyes.pose, truth[0]), 3),
        "accuracy_median": round(median(f["accuracy"] for f in frames), 4),
        "accuracy_worst": round(min(f["accuracy"] for f in frames), 4),
        "worst_frame": 1 + min(range(len(frames)), key=lambda i: frames[i]["accuracy"]),
        "unknown_paper_worst": round(max(f["unknown"] for f in frames), 4),
        "two_coloured": eyes.two_coloured,
        "learn_seconds": round(learned - started, 3),
        "frame_seconds": round(seconds / len(frames), 3),
        "accuracies": [round(f["accuracy"], 4) for f in frames],
    }


def score(seen: SeenFrame, frame: dict[str, Any], pose: Pose) -> dict[str, float]:
    """Share of known paper pixels whose label is true, and share of the true paper that is unknown."""
    true = true_labels(frame, pose, seen)
    known = seen.labels != UNKNOWN
    union = (is_paper(true) | is_paper(seen.labels)) & known
    if not seen.two_coloured:
        true = cv2.min(true, 1)
    hidden = int((is_paper(true) & ~known).sum()) / max(int(is_paper(true).sum()), 1)
    return {"accuracy": float((true == seen.labels)[union].mean()), "unknown": hidden}


def true_labels(frame: dict[str, Any], pose: Pose, seen: SeenFrame) -> Labels:
    """What the labels should be, from where the vertices lie in the picture; half a pixel is allowed."""
    pixels = frame.get("vertex_pixels") or frame["camera"]["vertex_pixels"]
    places = dict(zip(pixels, pose.to_plane(np.array(list(pixels.values())) - 0.5).tolist(), strict=True))
    polygons = [[tuple(places[str(v)]) for v in frame["faces"][str(f)]] for f in frame["order"]]
    backs = [bool(frame["orientations"][str(f)]) for f in frame["order"]]
    fine = replace(
        seen.grid,
        pixels_per_unit=seen.grid.pixels_per_unit * 2,
        rows=seen.grid.rows * 2,
        cols=seen.grid.cols * 2,
    )
    drawn = draw_labels(polygons, backs, fine)
    corners = np.stack([drawn[i::2, j::2] for i in (0, 1) for j in (0, 1)])
    agrees = (corners == seen.labels).any(axis=0)
    return np.where(agrees, seen.labels, draw_labels(polygons, backs, seen.grid))


def corner_error(pose: Pose, frame: dict[str, Any]) -> float:
    """Largest distance in pixels between a found corner and the true one."""
    pixels = frame.get("vertex_pixels") or frame["camera"]["vertex_pixels"]
    true = np.array([pixels[str(v)] for v in (1, 2, 3, 4)]) - 0.5
    return float(np.linalg.norm(np.array(pose.corners) - true, axis=1).max())


def overall(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians and worst cases over all sequences that could be used."""
    used = [r for r in results if "refused" not in r]
    if not used:
        return {"sequences": len(results), "refused": len(results)}
    every = [a for r in used for a in r["accuracies"]]
    return {
        "sequences": len(results),
        "refused": len(results) - len(used),
        "corner_error_pixels_worst": max(r["corner_error_pixels"] for r in used),
        "accuracy_median": round(median(every), 4),
        "accuracy_mean": round(mean(every), 4),
        "frames_below_0.985": sum(a < 0.985 for a in every),
        "frames_below_0.95": sum(a < 0.95 for a in every),
        "frames": len(every),
        "frame_seconds_mean": round(mean(r["frame_seconds"] for r in used), 3),
    }


if __name__ == "__main__":
    main()
