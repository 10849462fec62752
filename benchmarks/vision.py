"""How well photos with truth are seen: corners, labels, thin parts, hands, outlines, seconds. Prints JSON.

    python benchmarks/vision.py FOLDER...    sequence folders, or folders of them, each with a truth.json
    python benchmarks/vision.py --levels 1 3 --seeds 1 2 [--programs NAME ...] [--size 800]

Seeds below 100 are for development, figures that are reported anywhere use seeds from 100 on.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from folding_server.errors import PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.interchange.programs import load_program
from folding_server.photographer import photograph
from folding_server.vision.pose import Pose
from folding_server.vision.seeing import see_sequence
from label_scores import Truth, outline_score, scores
from reconstruction.studio import seed_of

PIXELS_PER_UNIT = 160.0
HERE = Path(__file__).resolve().parent
FOLDERS = (HERE / "reconstruction" / "programs", HERE.parent / "examples" / "programs")


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
    """Measure what the command line asks for."""
    options = _options()
    results = []
    for folder in options.folders:
        for place in sequences(folder):
            results.append(measure(place, options.undeclared, place.name))
            sys.stderr.write(f"{len(results)} sequences\n")
    for name, level, seed in _asked(options):
        results.append(photographed(name, level, seed, options))
        sys.stderr.write(f"{name}, level {level}, seed {seed}: {_in_short(results[-1])}\n")
    json.dump({"sequences": results, "overall": overall(results)}, sys.stdout, indent=1)
    sys.stdout.write("\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--levels", nargs="+", type=int, choices=(1, 2, 3), default=[])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1], help="development: 1 to 99")
    parser.add_argument(
        "--programs", nargs="+", metavar="NAME", choices=sorted(programs()), help="only these"
    )
    parser.add_argument("--size", type=int, default=800, help="side of the photographs in pixels")
    parser.add_argument("--undeclared", action="store_true", help="do not tell the declared colours")
    return parser.parse_args()


def programs() -> dict[str, Path]:
    """The benchmark's programs and the examples', by name."""
    return {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.json"))}


def _asked(options: argparse.Namespace) -> Iterator[tuple[str, int, int]]:
    for level in options.levels:
        for seed in options.seeds:
            for name in options.programs or programs():
                yield name, level, seed


def _in_short(result: dict[str, Any]) -> str:
    keys = (
        "refused",
        "accuracy_mean",
        "thin_recall",
        "false_share",
        "hand_paper",
        "hand_table",
        "outline_pixels",
        "inner_shift",
    )
    return ", ".join(f"{key} {result[key]}" for key in keys if result.get(key) is not None)


def sequences(folder: Path) -> Iterator[Path]:
    """The folders with a truth.json in or below one."""
    yield from sorted(path.parent for path in folder.rglob("truth.json"))


def photographed(name: str, level: int, seed: int, options: argparse.Namespace) -> dict[str, Any]:
    """Photograph a program and measure how it is seen."""
    program = load_program(programs()[name].read_text(encoding="utf-8"))
    size = (options.size, options.size)
    with TemporaryDirectory() as place:
        photograph(program, Path(place), seed_of(program.name, seed), level, size)
        return measure(Path(place), options.undeclared, f"{name}-{level}-{seed}")


def measure(folder: Path, undeclared: bool, name: str) -> dict[str, Any]:
    """One sequence: errors of its pose and, frame by frame, of its labels."""
    sequence: Any = load_sequence(folder)
    if undeclared:
        sequence = Undeclared(sequence, sequence.name, sequence.frame_count)
    truth = json.loads((folder / "truth.json").read_text())["frames"]
    started = time.process_time()
    try:
        observer = see_sequence(sequence)
    except PhotoError as error:
        return {"sequence": name, "refused": str(error)}
    learned = time.process_time()
    seen = [observer.frame(i + 1, PIXELS_PER_UNIT) for i in range(len(truth))]
    seconds = time.process_time() - learned
    truths = [
        Truth(folder, frame, observer.pose, photo.grid) for photo, frame in zip(seen, truth, strict=True)
    ]
    frames = [
        scores(photo, true) | outline_score(observer.outlines(photo.frame), true)
        for photo, true in zip(seen, truths, strict=True)
    ]
    return {
        "sequence": name,
        "corner_error_pixels": round(corner_error(observer.pose, truth[0]), 3),
        **summary(frames),
        "two_coloured": observer.two_coloured,
        "learn_seconds": round(learned - started, 3),
        "frame_seconds": round(seconds / len(frames), 3),
        "frames": [{key: _rounded(value) for key, value in frame.items()} for frame in frames],
    }


def corner_error(pose: Pose, frame: dict[str, Any]) -> float:
    """Largest distance in pixels between a found corner and the true one."""
    pixels = frame.get("vertex_pixels") or frame["camera"]["vertex_pixels"]
    true = np.array([pixels[str(v)] for v in (1, 2, 3, 4)]) - 0.5
    return float(np.linalg.norm(np.array(pose.corners) - true, axis=1).max())


def summary(frames: Sequence[dict[str, float | None]]) -> dict[str, Any]:
    """Means over frames of what was scored, and the worst."""
    means: dict[str, Any] = {}
    for key in frames[0]:
        values = [frame[key] for frame in frames]
        known = [value for value in values if value is not None]
        means[key if key == "thin_lost" else f"{key}_mean" if key == "accuracy" else key] = _rounded(
            (float(sum(known)) if key == "thin_lost" else mean(known)) if known else None
        )
    accuracies = [frame["accuracy"] or 0.0 for frame in frames]
    worst = min(range(len(frames)), key=lambda i: accuracies[i])
    return means | {"accuracy_worst": _rounded(accuracies[worst]), "worst_frame": worst + 1}


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def overall(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians and worst cases over all sequences that could be used."""
    used = [r for r in results if "refused" not in r]
    if not used:
        return {"sequences": len(results), "refused": len(results)}
    frames = [frame for r in used for frame in r["frames"]]
    every = [frame["accuracy"] for frame in frames]
    return {
        "sequences": len(results),
        "refused": len(results) - len(used),
        "corner_error_pixels_worst": max(r["corner_error_pixels"] for r in used),
        "accuracy_median": round(median(every), 4),
        **summary(frames),
        "frames_below_0.985": sum(a < 0.985 for a in every),
        "frames_below_0.95": sum(a < 0.95 for a in every),
        "frame_count": len(every),
        "learn_seconds_mean": round(mean(r["learn_seconds"] for r in used), 3),
        "frame_seconds_mean": round(mean(r["frame_seconds"] for r in used), 3),
    }


if __name__ == "__main__":
    main()
