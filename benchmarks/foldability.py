"""How fast foldability is decided: ``python benchmarks/foldability.py [--golden DIR] [--flat-folder DIR]``. Prints one JSON
document.

Miura-ori by size, squares folded eight times through all layers, maps without letters (whose counts are known), and,
given its folder, the golden set with the number of verdicts and counts that agree. With ``--flat-folder`` and a clone of Flat-Folder,
only its examples of 500 to 6,000 faces are folded, by both, in processor seconds (``flat_folder.py``), or, with ``--counts``, the
numbers of layer orders compared with those that it lists (``flat_folder_counts.py``).
"""

import argparse
import json
import time
from pathlib import Path

from crease_patterns import all_layers, map_grid, miura
from flat_folder import SideBySide, side_by_side
from flat_folder_counts import counts_side_by_side
from folding_server.simulator.foldability import CreasePattern, check_pattern


def measured(name: str, pattern: CreasePattern, cap: int) -> dict[str, object]:
    """One check: its seconds and what it found."""
    started = time.perf_counter()
    report = check_pattern(pattern, cap)
    seconds = time.perf_counter() - started
    return {
        "pattern": name,
        "faces": len(pattern.cycles),
        "cap": cap,
        "foldable": report.foldable,
        "states": report.states,
        "capped": report.capped,
        "seconds": round(seconds, 3),
    }


def golden(folder: Path) -> dict[str, object]:
    """Agreement with the patterns whose verdict and number of layer orders are known."""
    rows = [json.loads(line) for line in (folder / "golden.jsonl").read_text().splitlines()]
    started, wrong = time.perf_counter(), []
    for row in rows:
        data = json.loads((folder / "patterns" / f"{row['name']}.fold").read_text())
        report = check_pattern(
            CreasePattern(
                tuple((x, y) for x, y in data["vertices_coords"]),
                tuple((u, v) for u, v in data["edges_vertices"]),
                tuple(data["edges_assignment"]),
            )
        )
        if row["valid"] is not None and (report.foldable, report.states) != (row["valid"], row["states"]):
            wrong.append(row["name"])
    known = sum(row["valid"] is not None for row in rows)
    return {
        "patterns": len(rows),
        "known": known,
        "wrong": wrong,
        "seconds": round(time.perf_counter() - started, 3),
    }


def main() -> None:
    """Measure everything and print it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--golden", type=Path, help="folder with golden.jsonl and patterns/")
    parser.add_argument("--flat-folder", type=Path, help="a clone of Flat-Folder; needs node")
    parser.add_argument("--every", type=int, default=1, help="compare every so many-th of its examples")
    parser.add_argument(
        "--seconds",
        type=float,
        default=600,
        help="seconds that each may take for one: of the processor, in counting of the clock",
    )
    parser.add_argument(
        "--results",
        type=Path,
        help="file that gets one JSON line a pattern; those in it are not measured again",
    )
    parser.add_argument(
        "--ours-again", action="store_true", help="measure ours again beside Flat-Folder's times in --results"
    )
    parser.add_argument(
        "--counts",
        action="store_true",
        help="compare numbers of orders with those that its tables list instead",
    )
    options = parser.parse_args()
    if options.flat_folder and options.counts:
        print(json.dumps(counts_side_by_side(options.flat_folder, options.every, options.seconds), indent=1))
        return
    if options.flat_folder:
        comparison = SideBySide(
            options.flat_folder, options.every, options.seconds, options.results, options.ours_again
        )
        print(json.dumps(side_by_side(comparison), indent=1))
        return
    rows = [measured("warm-up", miura(2, 2), 1)]
    rows += [measured(f"miura {n}x{n}", miura(n, n), 1000) for n in (4, 8, 12, 16)]
    rows += [measured(f"all layers, 8 folds, seed {seed}", all_layers(8, seed), 1) for seed in range(4)]
    rows += [measured("all layers, 8 folds, seed 0", all_layers(8, 0), 1000)]
    rows += [measured(f"map {m}x{n}", map_grid(m, n), 10_000) for m, n in ((2, 4), (3, 3), (8, 1))]
    document: dict[str, object] = {"patterns": rows[1:]}
    if options.golden:
        document["golden"] = golden(options.golden)
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
