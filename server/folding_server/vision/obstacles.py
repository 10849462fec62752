"""What is in the way: hands, sleeves and tools, told by colour, by what the table looked like, and by their reach."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask, RgbImage
from folding_server.vision.appearance import LAB_FLOOR, ColourModels, pixel_cost
from folding_server.vision.colours import cluster, skin
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, FRONT, LabelImage, is_paper
from folding_server.vision.table_memory import Recalled

UNEXPLAINED = 16.0
"""Cost, in nats, beyond which a pixel is neither table nor paper."""
SKIN_UNEXPLAINED = 6.0
"""The same where the colour is one that skin can have."""
DOUBTFUL = 5.0
"""The same, shadows on paper not allowed for, in whatever reaches in from the edge of the photo."""
LEAST_STRANGE = 2.5
"""Distance in Lab, shadows allowed for, from which it may be more than paper in the shadow of a hand."""
SKIN_DOUBTFUL, SKIN_ON_TABLE = 4.0, 2.0
"""The same where the colour is one that skin can have, on what is like paper and like the table: distance in Lab, shadows
allowed for. A table of many browns is given more.
"""
STRANGE = 16.0
"""Distance in Lab from every class, shadows allowed for, that such a pixel must have."""
SKIN_STRANGE = 11.0
"""The same where the colour is one that skin can have."""
CHANGED_COST, CHANGED_STRANGE = 7.0, 4.5
"""Cost, and distance in Lab, from which a pixel is not the table that it was in the first photo."""
THINNEST_CHANGE = 0.04
"""Width, in sheet units, below which such a change is a blurred edge of the paper."""
ARM_CHANGED = 12.0
"""Cost, shadows not allowed for, from which what reaches in from the edge is an arm or its deep shadow."""
ARM_STRANGE, ARM_FACTOR = 2.8, 2.5
"""Distance in Lab, shadows allowed for, from which it is one too, and how many times the usual that must be."""
ARM_DEPARTS, DEPARTS_FACTOR = 3.0, 4.5
"""Distance in Lab on the average, light and shadow or not, from which it is one as well, and the same."""
SHADES = 4
"""Colours that an obstacle may have."""
FEWEST_OBSTACLE_PIXELS = 60
"""Pixels of an obstacle from which its colours are known."""
FEWEST_SHADE_PIXELS = 21
"""Pixels of one of its colours from which that is known: of fewer the spread is chance."""
LEAD = 1.0
"""Nats by which a pixel must rather be the obstacle than table or paper to belong to it."""
THINNEST_FINGER = 0.03
"""Width, in sheet units, below which what has the obstacle's colours is none of it."""
THINNEST_UNKNOWN = 0.03
"""Width, in sheet units, below which what fits no class is a blurred edge or a crease, not an object."""
SMALLEST_UNKNOWN = 0.004
"""Area, in sheet units squared, of the smallest object that may be in the way."""
THINNEST_SLEEVE = 0.05
"""Width, in sheet units, below which paper colour that reaches in from the edge of the photo is no arm."""
WIDEST_FINGER = 0.08
"""Width, in sheet units, below which what looks like table beside a hand may be the end of a finger."""
SMALLEST_SHEET = 0.05
"""Area, in sheet units squared, of the least paper that is certainly the sheet."""


@dataclass(frozen=True)
class ObstacleView:
    """One photo as obstacles are looked for in it.

    ``lab`` and ``rgb`` (rows, cols, 3), ``costs`` (rows, cols, classes), ``seen`` (rows, cols), and what the
    remembered table should look like, if that is of use.
    """

    lab: Image
    rgb: RgbImage
    costs: Image
    seen: Mask
    grid: Grid
    palette: ColourModels
    recalled: Recalled | None

    @cached_property
    def strange(self) -> Image:
        """Distance in Lab of each pixel from the nearest class, lit or shaded, (rows, cols)."""
        distances = [look.strangeness(self.lab, self.grid) for look in self.palette.looks]
        if self.recalled is not None:
            distances[0] = np.where(self.recalled.known, self.unlike_table, distances[0])
        return np.asarray(np.minimum.reduce(distances), np.float32)

    @cached_property
    def unlike_table(self) -> Image:
        """Distance in Lab of each pixel from the remembered table, shadows allowed for; 0 without a memory."""
        if self.recalled is None:
            return np.zeros(self.seen.shape, np.float32)
        return self.recalled.strangeness(self.lab)


def obstacles(view: ObstacleView) -> Mask:
    """Where something that is neither table nor paper is in the way: hands, sleeves, tools."""
    odd = _odd(view)
    kernel = _disc(THINNEST_UNKNOWN, view.grid)
    solid = _as_wide_as(THINNEST_UNKNOWN, odd, view.grid)
    solid |= _alike(view, _large(solid, view.grid))
    closed = cv2.morphologyEx(solid.astype(np.uint8), cv2.MORPH_CLOSE, kernel) > 0
    large = _large(np.asarray(closed), view.grid)
    return np.asarray(cv2.dilate(large.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)


def _odd(view: ObstacleView) -> Mask:
    """Pixels that no class explains."""
    least = cv2.blur(view.costs.min(axis=-1).clip(0, 60), (3, 3))
    odd = (least > UNEXPLAINED) & (view.strange > STRANGE)
    odd |= (least > SKIN_UNEXPLAINED) & (view.strange > SKIN_STRANGE) & skin(view.rgb)
    strange = cv2.medianBlur(view.strange, 5)
    if view.recalled is not None:
        changed = view.recalled.known & (least > CHANGED_COST) & (strange > CHANGED_STRANGE)
        odd |= _as_wide_as(THINNEST_CHANGE, changed, view.grid) | _arms(view, view.recalled)
    doubtful, kernel = _doubtful(view, strange), _disc(THINNEST_UNKNOWN, view.grid)
    solid = _as_wide_as(THINNEST_UNKNOWN, doubtful | odd, view.grid)
    arms = cv2.morphologyEx(solid.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    return np.asarray(odd | (doubtful & touching_edge(np.asarray(arms > 0), view.seen)))


def _doubtful(view: ObstacleView, strange: cv2.typing.MatLike) -> Mask:
    """Pixels that may be a hand or a sleeve if they belong to what reaches in; ``strange`` is smoothed."""
    like_paper = view.costs.argmin(axis=-1) > 0
    plain = [look.cost(view.lab, view.grid, shadows=False) for look in view.palette.looks[1:]]
    unlit = cv2.medianBlur(np.minimum.reduce(plain).clip(0, 60), 5) > DOUBTFUL
    table = view.strange[view.seen & ~like_paper]
    on_table = max(SKIN_ON_TABLE, ARM_FACTOR * float(np.median(table)) if len(table) else 0.0)
    like_skin = skin(view.rgb) & (strange > np.where(like_paper, SKIN_DOUBTFUL, on_table))
    return np.asarray((like_paper & unlit & (strange > LEAST_STRANGE)) | like_skin)


def _arms(view: ObstacleView, recalled: Recalled) -> Mask:
    """What is not the table that was there, not paper, and reaches in broadly from the edge, if by a sleeve like paper."""
    lit = np.where(recalled.known, cv2.medianBlur(recalled.cost(view.lab, shadows=False).clip(0, 60), 5), 0)
    known = recalled.known.astype(np.float32)
    steady = cv2.blur(view.unlike_table.clip(0, 30) * known, (7, 7))
    steady = steady / np.maximum(cv2.blur(known, (7, 7)), 1e-3)
    usual = float(np.median(steady[recalled.known])) if recalled.known.any() else 0.0
    departing = float(np.median(recalled.departure[recalled.known])) if recalled.known.any() else 0.0
    changed = (lit > ARM_CHANGED) | (steady > max(ARM_STRANGE, ARM_FACTOR * usual))
    changed |= recalled.departure > max(ARM_DEPARTS, DEPARTS_FACTOR * departing)
    changed &= recalled.known
    other = changed & (view.costs[..., 1:].min(axis=-1) > ARM_CHANGED)
    whole, broad = (_as_wide_as(THINNEST_SLEEVE, mask, view.grid) for mask in (changed, other))
    return np.asarray(broad & touching_edge(whole, view.seen))


def _alike(view: ObstacleView, core: Mask) -> Mask:
    """What is joined to the obstacles found so far and has their colours rather than those of table or paper."""
    inner = cv2.erode(core.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    colours = view.lab[inner]
    if len(colours) < FEWEST_OBSTACLE_PIXELS:
        return np.zeros(core.shape, bool)
    numbers, _ = cluster(colours[:: max(1, len(colours) // 4000)], SHADES)
    sampled = colours[:: max(1, len(colours) // 4000)].astype(np.float64)
    shades = [sampled[numbers == k] for k in range(SHADES)]
    large = [shade for shade in shades if len(shade) >= FEWEST_SHADE_PIXELS] or [sampled]
    own = np.minimum.reduce([_likeness(view.lab, shade) for shade in large])
    classes = [_normaliser(look.surfaces[0].covariance) for look in view.palette.looks]
    others = (view.costs + np.array(classes, np.float32)).min(axis=-1)
    lead = cv2.blur((others - own).clip(-10, 10), (5, 5))
    alike = _as_wide_as(THINNEST_FINGER, lead > LEAD, view.grid)
    _, numbered = cv2.connectedComponents((alike | core).astype(np.uint8))
    return np.asarray(alike & np.isin(numbered, np.unique(numbered[core])))


def _likeness(lab: Image, colours: Floats) -> Image:
    """The cost, in nats, of every pixel as one of these colours (N, 3)."""
    covariance = np.cov(colours.T)
    mean = np.broadcast_to(colours.mean(axis=0).astype(np.float32), lab.shape)
    return pixel_cost(lab, mean, covariance, shadows=False) + np.float32(_normaliser(covariance))


def _normaliser(covariance: Floats) -> float:
    """By how many nats a wide spread of colours makes each of them less likely."""
    return 0.5 * float(np.linalg.slogdet(covariance + np.diag(LAB_FLOOR))[1])


def _large(mask: Mask, grid: Grid) -> Mask:
    """The connected regions of a mask that are large enough to be in the way."""
    _, numbered, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    large = stats[:, cv2.CC_STAT_AREA] >= SMALLEST_UNKNOWN * grid.pixels_per_unit**2
    large[0] = False
    return np.asarray(large[numbered])


def _as_wide_as(width: float, mask: Mask, grid: Grid) -> Mask:
    """The parts of a mask that are at least so wide, in sheet units."""
    return np.asarray(cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, _disc(width, grid)) > 0)


def _disc(width: float, grid: Grid) -> cv2.typing.MatLike:
    side = max(3, round(width * grid.pixels_per_unit)) | 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))


def sleeves(labels: LabelImage, unknown: Mask, seen: Mask, grid: Grid) -> Mask:
    """Sleeves and hands of the paper's colour, which reach in from the edge of the photo, and thin shadows beside arms.

    If the sheet would go with them they are looked for on its front and its back alone; none if there would still be no
    sheet left.
    """
    reach = len(_disc(THINNEST_SLEEVE, grid))
    around = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    paper = is_paper(labels) & ~unknown
    for part in (paper, paper & (labels == FRONT), paper & (labels == BACK)):
        thick = _as_wide_as(THINNEST_SLEEVE, part, grid)
        reaching = touching_edge(thick, seen)
        sheet = _as_wide_as(THINNEST_SLEEVE, paper & ~reaching, grid)
        if np.count_nonzero(sheet) >= SMALLEST_SHEET * grid.pixels_per_unit**2:
            thin = part & ~thick & (cv2.dilate((reaching | unknown).astype(np.uint8), around) > 0)
            return np.asarray(reaching | thin)
    return np.zeros(paper.shape, bool)


def fingertips(table: Mask, hidden: Mask, grid: Grid) -> Mask:
    """Narrow parts of the table that touch what is ``hidden`` by an obstacle.

    They are fingers or nails of the table's colour, or gaps between fingers: nothing that says where paper ends.
    """
    if not hidden.any():
        return np.zeros(table.shape, bool)
    narrow = (table & ~_as_wide_as(WIDEST_FINGER, table, grid)).astype(np.uint8)
    _, numbered = cv2.connectedComponents(narrow, connectivity=4)
    beside = cv2.dilate(hidden.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return np.asarray((narrow > 0) & np.isin(numbered, np.unique(numbered[beside])))


def touching_edge(mask: Mask, seen: Mask) -> Mask:
    """The connected regions of a mask that reach the edge of what the photo covers, as arms do."""
    inner = cv2.copyMakeBorder(seen.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    rim = cv2.erode(inner, np.ones((5, 5), np.uint8))[1:-1, 1:-1] == 0
    thick = cv2.morphologyEx((mask & seen).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    _, numbered = cv2.connectedComponents(thick)
    reaching = np.unique(numbered[rim & (thick > 0)])
    return np.asarray(np.isin(numbered, reaching[reaching > 0]))
