"""How fast the simulator folds, beside a plain shapely version of the same cut: ``python benchmarks/simulator.py``.

Prints one JSON document: milliseconds an action on the recorded programs (of the folder that FOLDING_REFERENCE_DATA
names, or of ../shared, where present), seconds for each fold that halves the whole stack again, milliseconds for each
of six random folds, the peak memory per face, and the microseconds to find the planes of three papers of 200 faces from
the pairs of faces that lie flat together, by our union-find and by networkx. Times are processor times. ``--folds``
sets how often the stack is halved (12 makes 4,096 faces).
"""

import json
import os
import random
import statistics
import timeit
import tracemalloc
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import dist, log
from pathlib import Path
from time import process_time

import networkx as nx
from diagram import papers
from folding_schemas.actions import Action
from folding_server.errors import ActionRefused
from folding_server.geometry.graph import components
from folding_server.geometry.line import Point
from folding_server.simulator import Paper, add_vertex, apply, fold, folded_state, new_paper
from pydantic import TypeAdapter
from shapely.affinity import affine_transform
from shapely.geometry import box
from shapely.geometry.base import BaseGeometry
from shapely.ops import split

REFERENCE = Path(os.environ.get("FOLDING_REFERENCE_DATA") or Path(__file__).resolve().parents[2] / "shared")
RECORDED = REFERENCE / "programs" / "recorded"
ACTION: TypeAdapter[Action] = TypeAdapter(Action)
MOST_PLAIN = 10
"""The plain version is slow: it stops after this many halvings."""


def recorded_actions() -> list[float]:
    """Milliseconds of each action of the recorded programs, with the state given to models after each."""
    times = []
    for path in sorted(RECORDED.glob("*.json")):
        paper = new_paper()
        for recorded in json.loads(path.read_text())["actions"]:
            action = {key: value for key, value in recorded.items() if key != "at"}
            if "at" in recorded:
                action["edge"] = [
                    min(paper.vertices_coords, key=lambda v: dist(paper.vertices_coords[v], at))
                    for at in recorded["at"]
                ]
            known = ACTION.validate_python(action)
            start = process_time()
            paper = apply(paper, known)
            times.append(1000 * (process_time() - start))
            folded_state(paper)
    return times


def halvings(folds: int) -> Iterator[tuple[int, float]]:
    """Fold the whole stack in half again and again: (faces made, seconds of the fold, the best of three)."""
    paper = new_paper()
    for _ in range(folds):
        halved, edge = halving_line(paper)
        seconds = []
        for _ in range(3):
            fresh = replace(halved)
            start = process_time()
            paper = fold(fresh, edge, 1)
            seconds.append(process_time() - start)
        yield len(paper.faces), min(seconds)


def halving_line(paper: Paper) -> tuple[Paper, tuple[int, int]]:
    """Two vertices in the middle of the long sides of the lowest face, so that every layer moves."""
    lowest = paper.order[0]
    outline = paper.polygon(lowest)
    low = min(p[0] for p in outline), min(p[1] for p in outline)
    high = max(p[0] for p in outline), max(p[1] for p in outline)
    along = 0 if high[0] - low[0] >= high[1] - low[1] - 1e-9 else 1
    middle = (low[along] + high[along]) / 2
    ends = []
    for side in (low[1 - along], high[1 - along]):
        target = (middle, side) if along == 0 else (side, middle)
        paper, vertex = vertex_at(paper, lowest, target)
        ends.append(vertex)
    return paper, (ends[0], ends[1])


def vertex_at(paper: Paper, face: int, target: Point) -> tuple[Paper, int]:
    """A vertex of a face at a place on its boundary, added if there is none."""
    cycle = paper.faces[face]
    for v in cycle:
        if dist(paper.folded_vertices_coords[v], target) < 1e-6:
            return paper, v
    for u, v in zip(cycle, cycle[1:] + cycle[:1], strict=True):
        p, q = paper.folded_vertices_coords[u], paper.folded_vertices_coords[v]
        if abs(dist(p, target) + dist(target, q) - dist(p, q)) < 1e-9:
            paper = add_vertex(paper, (u, v), dist(p, target) / dist(p, q))
            return paper, max(paper.vertices_coords)
    message = f"no edge of face {face} passes {target}"
    raise LookupError(message)


def plain_halvings(folds: int) -> Iterator[tuple[int, float]]:
    """The same cuts on bare shapely polygons, without ids, creases or layers."""
    stack: list[BaseGeometry] = [box(0, 0, 1, 1)]
    for _ in range(folds):
        left, low, right, high = stack[0].bounds
        wide = right - left >= high - low - 1e-9
        start = process_time()
        stack = plain_fold(stack, (left + right) / 2 if wide else (low + high) / 2, wide=wide)
        yield len(stack), process_time() - start


def plain_fold(stack: list[BaseGeometry], middle: float, *, wide: bool) -> list[BaseGeometry]:
    """Split every polygon at a line with shapely, and mirror the parts beyond it."""
    cutter = box(middle, -9, 9, 9).boundary if wide else box(-9, middle, 9, 9).boundary
    mirror = [-1, 0, 0, 1, 2 * middle, 0] if wide else [1, 0, 0, -1, 0, 2 * middle]
    stays: list[BaseGeometry] = []
    turns: list[BaseGeometry] = []
    for polygon in stack:
        for part in split(polygon, cutter).geoms:
            beyond = (part.centroid.x if wide else part.centroid.y) > middle
            (turns if beyond else stays).append(affine_transform(part, mirror) if beyond else part)
    return [*stays, *reversed(turns)]


def random_folds(programs: int, folds: int, seed: int) -> list[list[float]]:
    """Milliseconds of the k-th fold of random programs, by k."""
    chance = random.Random(seed)  # noqa: S311
    times: list[list[float]] = [[] for _ in range(folds)]
    for _ in range(programs):
        paper, done = new_paper(), 0
        while done < folds:
            edges = sorted(paper.edge_faces)
            try:
                marked = paper
                for _ in range(2):
                    marked = add_vertex(marked, chance.choice(edges), chance.uniform(0.1, 0.9))
                    edges = sorted(marked.edge_faces)
                ends = (max(marked.vertices_coords) - 1, max(marked.vertices_coords))
                start = process_time()
                paper = fold(marked, ends, chance.choice((1, -1)))
            except ActionRefused:
                continue
            times[done].append(1000 * (process_time() - start))
            done += 1
    return times


def planes_microseconds() -> dict[str, dict[str, float]]:
    """Microseconds to find connected components, the best of 50, by paper and by method; both find the same."""
    found = {}
    for name, paper in papers().items():
        flat = [f for edge, f in paper.edge_faces.items() if len(f) == 2 and not paper.is_folded(edge)]
        ours, theirs = partial(components, paper.faces, flat), partial(by_networkx, list(paper.faces), flat)
        assert ours() == theirs()
        found[name] = {"union_find": fastest(ours), "networkx": fastest(theirs)}
    return found


def by_networkx(faces: Sequence[int], pairs: Sequence[tuple[int, ...]]) -> list[list[int]]:
    """Connected components by networkx."""
    graph: nx.Graph[int] = nx.Graph()
    graph.add_edges_from((pair[0], pair[1]) for pair in pairs)
    graph.add_nodes_from(faces)
    return sorted(map(sorted, nx.connected_components(graph)))


def fastest(work: Callable[[], object]) -> float:
    """Microseconds of a call, the best of 50."""
    return round(1e6 * min(timeit.repeat(work, timer=process_time, number=10, repeat=50)) / 10)


def bytes_per_face(folds: int) -> dict[int, int]:
    """Memory held by a halved stack, in bytes a face, by number of faces."""
    held = {}
    for count in (folds // 2, folds):
        tracemalloc.start()
        paper = new_paper()
        for _ in range(count):
            paper, edge = halving_line(paper)
            paper = fold(paper, edge, 1)
        held[len(paper.faces)] = tracemalloc.get_traced_memory()[0] // len(paper.faces)
        tracemalloc.stop()
    return held


def growth(sizes: list[tuple[int, float]]) -> float:
    """The exponent of the time in the number of faces, over the last doublings."""
    (small, before), (large, after) = sizes[-4], sizes[-1]
    return log(after / before) / log(large / small)


def main() -> None:
    """Measure and print."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--folds", type=int, default=12)
    parser.add_argument("--programs", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    ours = list(halvings(options.folds))
    plain = list(plain_halvings(min(options.folds, MOST_PLAIN)))
    actions = recorded_actions()
    by_fold = random_folds(options.programs, 6, options.seed)
    report = {
        "recorded_median_ms": statistics.median(actions) if actions else None,
        "recorded_max_ms": max(actions, default=None),
        "halving_seconds": dict(ours),
        "halving_plain_shapely_seconds": dict(plain),
        "halving_growth_exponent": growth(ours),
        "random_fold_median_ms": [statistics.median(times) for times in by_fold],
        "random_fold_p95_ms": [statistics.quantiles(times, n=20)[-1] for times in by_fold],
        "bytes_per_face": bytes_per_face(options.folds),
        "planes_microseconds": planes_microseconds(),
    }
    print(json.dumps(report, indent=1))  # noqa: T201


if __name__ == "__main__":
    main()
