"""Time diagrams of many-faced papers and print JSON: python benchmarks/diagram.py [--repeats N].

Three papers of about 200 faces: a thick stack, a flat sheet full of crease marks, and a sheet of both kinds.
Each is drawn as SVG and as PNG at 768 px. In the same run the visible regions are timed by themselves, beside
shapely's shortest way to them: from the top down, each face minus a running union of those above it, to which faces that
show nothing are not added. The two must agree on the visible area. Times are medians of processor time in milliseconds.
"""

import argparse
import json
import random
import statistics
import time
from collections.abc import Callable

import shapely
from folding_server.diagram import draw_svg, rasterise
from folding_server.diagram.visibility import visible_faces
from folding_server.errors import FoldingError
from folding_server.simulator import Paper, add_vertex, fold, new_paper, unfold

FACES = 200
GOALS_MS = {"svg": 10.0, "png": 60.0}


def boundary_edges(paper: Paper) -> list[tuple[int, int]]:
    """The edges on the boundary of the sheet."""
    return [edge for edge, faces in paper.edge_faces.items() if len(faces) == 1]


def random_fold(paper: Paper, chance: random.Random) -> Paper:
    """A fold between two random points of the boundary; the same paper if it is refused."""
    try:
        points = []
        cut = paper
        for _ in range(2):
            edge = chance.choice(boundary_edges(cut))
            cut = add_vertex(cut, edge, chance.uniform(0.1, 0.9))
            points.append(max(cut.vertices_coords))
        return fold(cut, (points[0], points[1]), chance.choice((1, -1)))
    except FoldingError:
        return paper


def grown(chance: random.Random, marks: Callable[[int], bool]) -> Paper:
    """Random folds until the paper has about 200 faces; try k is opened again at once where ``marks(k)``."""
    paper = new_paper()
    tries = 0
    while len(paper.faces) < FACES:
        tries += 1
        folded = random_fold(paper, chance)
        if folded is not paper and marks(tries):
            try:
                folded = unfold(folded)
            except FoldingError:
                continue
        if len(folded.faces) <= FACES * 1.04:
            paper = folded
    return paper


def papers() -> dict[str, Paper]:
    """The three papers, the same in every run."""
    return {
        "stack": grown(random.Random(1), lambda _: False),
        "marks": grown(random.Random(2), lambda _: True),
        "mixed": grown(random.Random(3), lambda k: k % 3 > 0),
    }


def running_union_area(paper: Paper) -> float:
    """Total visible area by shapely's union of all that lies above."""
    above: shapely.Geometry = shapely.Polygon()
    total = 0.0
    for face in reversed(paper.order):
        outline = shapely.Polygon(paper.polygon(face))
        shown = shapely.difference(outline, above)
        if not shown.is_empty:
            above, total = shapely.union(above, outline), total + shown.area
    return total


def milliseconds(work: Callable[[], object], repeats: int) -> float:
    """Median processor time of a call: unlike the time on the wall it does not count other programs."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append((time.process_time() - start) * 1e3)
    return round(statistics.median(times), 2)


def fresh(paper: Paper) -> Paper:
    """The same paper without anything it has remembered about itself."""
    return Paper(**{name: getattr(paper, name) for name in Paper.__dataclass_fields__})


def measure(paper: Paper, repeats: int) -> dict[str, object]:
    """Times and agreement for one paper."""
    svg = draw_svg(paper)
    shown = visible_faces(paper)
    return {
        "faces": len(paper.faces),
        "visible_faces": len(shown),
        "svg_ms": milliseconds(lambda: draw_svg(fresh(paper)), repeats),
        "png_ms": milliseconds(lambda: rasterise(svg), repeats),
        "svg_with_labels_ms": milliseconds(lambda: draw_svg(fresh(paper), labels=True), max(3, repeats // 5)),
        "visible_regions_ms": milliseconds(lambda: visible_faces(fresh(paper)), repeats),
        "running_union_ms": milliseconds(lambda: running_union_area(paper), repeats),
        "visible_area": round(sum(face.area for face in shown), 3),
        "running_union_area": round(running_union_area(paper), 3),
    }


def main() -> None:
    """Print the measurements."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=20)
    repeats = parser.parse_args().repeats
    results = {name: measure(paper, repeats) for name, paper in papers().items()}
    print(json.dumps({"goals_ms": GOALS_MS, "papers": results}, indent=1))


if __name__ == "__main__":
    main()
