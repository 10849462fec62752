"""Numbers of layer orders beside those that a clone of Flat-Folder lists for its examples.

Compared are all that its tables give without a limit, of which the count of our own ends in time.
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from folding_server.interchange.fold_reading import read_crease_pattern
from folding_server.simulator.foldability import Counting, check_pattern

TABLES = ("grids", "instagram")
"""Folders of examples, of which a table beside each gives the numbers."""
NUMBERED = 3
"""Digits that the name of an example begins with, as in its row."""
UNLIMITED = "no limit"
MOST_FACES = 6000


def listed(clone: Path) -> Iterator[tuple[Path, int]]:
    """The examples with their number of layer orders, where the table has all of them."""
    for name in TABLES:
        files = {file.name[:NUMBERED]: file for file in (clone / "examples" / name).glob("*.fold")}
        table = (clone / "examples" / f"{name}_data.csv").read_text(encoding="utf-8")
        for row in csv.DictReader(table.splitlines()):
            small = int(row["faces"]) <= MOST_FACES
            if row["limited"] == UNLIMITED and row["number"] in files and small:
                yield files[row["number"]], int(row["states"])


def counts_side_by_side(clone: Path, every: int, seconds: float) -> dict[str, Any]:
    """How many of the examples have the listed number of layer orders, and which have another or take too long to count."""
    agree, cut_short, differ = 0, list[str](), list[dict[str, Any]]()
    for file, states in list(listed(clone))[::every]:
        pattern = read_crease_pattern(file.read_text(encoding="utf-8"))
        report = check_pattern(pattern, counting=Counting(cap=None, seconds=seconds))
        if report.capped:
            cut_short.append(file.stem)
        elif report.states == states:
            agree += 1
        else:
            ours = str(report.states) if report.foldable else report.reason
            differ.append({"pattern": file.stem, "listed": str(states), "ours": ours})
            sys.stderr.write(f"{file.stem}: {ours}, listed {states}\n")
    return {"clone": str(clone), "agree": agree, "not_counted_in_time": cut_short, "differ": differ}
