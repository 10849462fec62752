"""Folded papers drawn by shapely and cairo, apart from the rasteriser of the project: test pictures that share no error with it.

Shapely says what shows of each face, cairo which of 8 by 8 places in each pixel that covers. (Its own smoothing of edges is not
used: cairo 1.16 with it fills whole pixels beside some corners.) Places are taken to pixels by the definition of a grid: x to
the right of ``left``, y down from ``top``.
"""

from collections.abc import Iterable, Sequence

import cairocffi
import numpy as np
import numpy.typing as npt
from folding_server.geometry.convex import Polygon as Outline
from folding_server.geometry.isometry import IDENTITY
from folding_server.geometry.similarity import Similarity
from folding_server.simulator import Paper
from folding_server.simulator.planes import planes
from folding_server.vision.grid import Grid
from folding_server.vision.labels import LabelImage
from PIL import Image
from shapely import Polygon, get_coordinates, get_parts, get_rings, unary_union
from shapely.geometry.base import BaseGeometry

Coverage = npt.NDArray[np.float32]
"""How much of each pixel something covers, (rows, cols) from 0 to 1."""
SAMPLES = 8
"""Places along each side of a pixel at which it is looked up what covers it."""
_HAIR = 1e-6
"""Sheet units within which two lines are the same line."""


def label_image(paper: Paper, grid: Grid, motion: Similarity = IDENTITY) -> LabelImage:
    """A folded sheet as labels: each pixel has the class that covers most of it."""
    return label_polygons(
        [paper.polygon(f) for f in paper.order], [paper.back_up(f) for f in paper.order], grid, motion
    )


def label_polygons(
    outlines: Sequence[Outline], backs: Sequence[bool], grid: Grid, motion: Similarity = IDENTITY
) -> LabelImage:
    """The same of polygons, bottom to top, and whether each lies back up."""
    return np.asarray(np.argmax(_shares(outlines, backs, grid, motion), axis=0), np.uint8)


def shares(paper: Paper, grid: Grid, motion: Similarity = IDENTITY) -> Coverage:
    """How much of each pixel is table, front and back, (3, rows, cols)."""
    order = paper.order
    return _shares([paper.polygon(f) for f in order], [paper.back_up(f) for f in order], grid, motion)


def layer_lines(paper: Paper, grid: Grid, motion: Similarity, width: float) -> Coverage:
    """The lines within the silhouette at which planes of the paper end, so many pixels wide."""
    shown = dict(zip(paper.order, visible([paper.polygon(f) for f in paper.order], motion), strict=True))
    seen = [_joined(shown[f] for f in plane) for plane in planes(paper)]
    rim = _joined(seen).boundary.buffer(9 * _HAIR)
    surface, context = _canvas(grid)
    context.set_line_width(width * SAMPLES)
    for plane in seen:
        for line in get_parts(plane.boundary.difference(rim)) if not plane.is_empty else ():
            _trace(context, grid, get_coordinates(line))
    context.stroke()
    return _pixels(surface, grid)


def _joined(regions: Iterable[BaseGeometry]) -> BaseGeometry:
    """The union of regions, those that touch made one and those as thin as a hair left out."""
    return unary_union([region.buffer(-_HAIR).buffer(2 * _HAIR) for region in regions])


def visible(outlines: Sequence[Outline], motion: Similarity = IDENTITY) -> list[BaseGeometry]:
    """What shows of each polygon, bottom to top, once those above it lie on it."""
    shown: list[BaseGeometry] = []
    above: BaseGeometry = Polygon()
    for outline in reversed(outlines):
        polygon = Polygon([motion(point) for point in outline])
        shown.append(polygon.difference(above))
        above = above.union(polygon)
    return shown[::-1]


def coverage(regions: Iterable[BaseGeometry], grid: Grid) -> Coverage:
    """How much of each pixel regions cover that do not overlap."""
    surface, context = _canvas(grid)
    for region in regions:
        for polygon in get_parts(region):
            for ring in get_rings(polygon):
                _trace(context, grid, get_coordinates(ring))
    context.fill()
    return _pixels(surface, grid)


def _shares(outlines: Sequence[Outline], backs: Sequence[bool], grid: Grid, motion: Similarity) -> Coverage:
    """Table, front and back."""
    shown = visible(outlines, motion)
    front, back = (
        coverage([part for part, turned in zip(shown, backs, strict=True) if turned == side], grid)
        for side in (False, True)
    )
    return np.stack([1 - np.minimum(front + back, 1), front, back])


def _canvas(grid: Grid) -> tuple[cairocffi.ImageSurface, cairocffi.Context]:
    """A picture of coverage alone, and a pen for it."""
    surface = cairocffi.ImageSurface(cairocffi.FORMAT_A8, SAMPLES * grid.cols, SAMPLES * grid.rows)
    context = cairocffi.Context(surface)
    context.set_antialias(cairocffi.ANTIALIAS_NONE)
    context.set_fill_rule(cairocffi.FILL_RULE_EVEN_ODD)
    return surface, context


def _trace(context: cairocffi.Context, grid: Grid, places: npt.NDArray[np.float64]) -> None:
    """A path through places of the plane."""
    scale = SAMPLES * grid.pixels_per_unit
    context.new_sub_path()
    for x, y in places.tolist():
        context.line_to((x - grid.left) * scale, (grid.top - y) * scale)


def _pixels(surface: cairocffi.ImageSurface, grid: Grid) -> Coverage:
    """What was drawn."""
    surface.flush()
    size, stride = (SAMPLES * grid.cols, SAMPLES * grid.rows), surface.get_stride()
    sampled = Image.frombuffer("L", size, surface.get_data(), "raw", "L", stride, 1)
    return np.asarray(sampled.reduce(SAMPLES), np.float32) / 255
