"""A rectified photo to labels: table, front, back, unknown, with outlines that are right below the pixel."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from folding_server.vision.appearance import Look, coordinates, pixel_cost
from folding_server.vision.colours import Image, skin, to_lab, to_linear
from folding_server.vision.grid import Grid
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, Labels, is_paper
from folding_server.vision.photos import Picture
from folding_server.vision.surfaces import Surface, fit_surface

Bools = npt.NDArray[np.bool_]

CLASSES = (BACKGROUND, FRONT, BACK)
UNEXPLAINED = 16.0
"""Cost, in nats, beyond which a pixel is neither table nor paper."""
SKIN_UNEXPLAINED = 6.0
"""The same where the colour is one that skin can have."""
DOUBTFUL = 5.0
"""The same, shadows on paper not allowed for, in whatever reaches in from the edge of the photo."""
STRANGE = 16.0
"""Distance in Lab from every class, shadows allowed for, that such a pixel must have."""
SKIN_STRANGE = 11.0
"""The same where the colour is one that skin can have."""
THINNEST_UNKNOWN = 0.03
"""Width, in sheet units, below which what fits no class is a blurred edge or a crease, not an object."""
SMALLEST_UNKNOWN = 0.004
"""Area, in sheet units squared, of the smallest object that may be in the way."""
SMALLEST_REGION = 0.0012
"""Area, in sheet units squared, of the smallest region that is believed."""
THINNEST_SLEEVE = 0.05
"""Width, in sheet units, below which paper colour that reaches in from the edge of the photo is no arm."""
SMALLEST_SHEET = 0.05
"""Area, in sheet units squared, of the least paper that is certainly the sheet."""
SMOOTHING = 3.5
"""How strongly neighbours pull towards the same class."""


@dataclass(frozen=True)
class Palette:
    """How everything looks. ``back`` is None if the sides look alike or the back was never seen."""

    table: Look
    front: Look
    back: Look | None

    @property
    def looks(self) -> tuple[Look, ...]:
        """Table, front and, if there is one, back, in the order of their labels."""
        return (self.table, self.front) if self.back is None else (self.table, self.front, self.back)


@dataclass(frozen=True)
class Segmented:
    """``shares`` (rows, cols, 3): how much of each pixel is table, front, back; ``unknown`` (rows, cols)."""

    shares: Image
    unknown: Bools


def segment(rgb: Picture, seen: Bools, grid: Grid, palette: Palette) -> Segmented:
    """Segment a rectified photo whose pixels within the photo are ``seen``."""
    lab = to_lab(np.asarray(cv2.GaussianBlur(rgb, (3, 3), 0), np.uint8))
    tuned = adapt(lab, seen, grid, palette)
    costs = class_costs(lab, grid, tuned)
    unknown = unexplained(lab, costs, rgb, seen, grid, tuned) | ~seen
    shares = _smooth(costs)
    labels = shares.argmax(axis=-1).astype(np.uint8)
    unknown |= _sleeves(np.asarray(is_paper(labels) & ~unknown), unknown, seen, grid)
    labels = _without_specks(labels, unknown, grid)
    labels, stray = _one_sheet(labels, unknown, grid)
    return Segmented(_sharpen(labels, unknown | stray, rgb), unknown | stray)


def class_costs(lab: Image, grid: Grid, palette: Palette) -> Image:
    """The cost of each class at each pixel, (rows, cols, 2 or 3)."""
    return np.stack([look.cost(lab, grid) for look in palette.looks], axis=-1)


def adapt(lab: Image, seen: Bools, grid: Grid, palette: Palette) -> Palette:
    """The palette under this photo's light: the table fitted afresh, the sides of the sheet shifted."""
    step = max(1, round(grid.pixels_per_unit / 32))
    coarse_lab, coarse_seen = np.ascontiguousarray(lab[::step, ::step]), seen[::step, ::step]
    x, y = np.meshgrid(*(axis[::step] for axis in coordinates(grid)))
    tuned = palette
    for limit in (ODD_LIGHT, SHADOW_FREE):
        costs = np.stack([_sampled_cost(look, coarse_lab, x, y) for look in tuned.looks], axis=-1)
        nearest, least = costs.argmin(axis=-1), costs.min(axis=-1)
        sure = coarse_seen & (least < limit)
        sure &= (nearest == 0) | ~touching_edge(sure & (nearest > 0), coarse_seen)
        looks = [
            _tuned(tuned.looks[k], k == 0, coarse_lab, x, y, sure & (nearest == k))
            for k in range(costs.shape[-1])
        ]
        tuned = Palette(looks[0], looks[1], looks[2] if len(looks) > 2 else None)
    return tuned


SHADOW_FREE = 4.0
"""Cost below which a pixel shows its class in plain light."""
ODD_LIGHT = 12.0
"""The same before it is known how the light has changed."""
FARTHEST_SHIFT = 12.0
"""How far, in Lab, light may move a side's colour between photos."""


def _sampled_cost(look: Look, lab: Image, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> Image:
    """A look's cost at sampled coordinates."""
    costs = [pixel_cost(lab, s.at(x, y), s.covariance) for s in look.surfaces]
    return np.asarray(np.minimum.reduce(costs), np.float32)


def _tuned(
    look: Look, table: bool, lab: Image, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64], own: Bools
) -> Look:
    """A look fitted to the pixels that are surely its own, if there are enough."""
    if own.sum() < 40:
        return look
    if table and len(look.surfaces) == 1:
        fitted = fit_surface(x[own], y[own], lab[own].astype(np.float64), 2)
        spread = 0.5 * (fitted.covariance + look.surfaces[0].covariance)
        return Look((Surface(2, fitted.coefficients, spread, fitted.span),))
    main = look.surfaces[0]
    shift = np.median(lab[own] - main.at(x[own], y[own]), axis=0) if len(look.surfaces) == 1 else np.zeros(3)
    length = float(np.linalg.norm(shift))
    shift = shift * min(1.0, FARTHEST_SHIFT / max(length, 1e-9))
    return Look(tuple(_moved(s, shift) for s in look.surfaces))


def _moved(surface: Surface, shift: npt.NDArray[np.float64]) -> Surface:
    coefficients = surface.coefficients.copy()
    coefficients[0] += shift
    return Surface(surface.order, coefficients, surface.covariance, surface.span)


def touching_edge(mask: Bools, seen: Bools) -> Bools:
    """The connected regions of a mask that reach the edge of what the photo covers, as arms do."""
    inner = cv2.copyMakeBorder(seen.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    rim = cv2.erode(inner, np.ones((5, 5), np.uint8))[1:-1, 1:-1] == 0
    thick = cv2.morphologyEx((mask & seen).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    _, numbered = cv2.connectedComponents(thick)
    reaching = np.unique(numbered[rim & (thick > 0)])
    return np.asarray(np.isin(numbered, reaching[reaching > 0]))


def unexplained(lab: Image, costs: Image, rgb: Picture, seen: Bools, grid: Grid, palette: Palette) -> Bools:
    """Where something that is neither table nor paper is in the way: hands, sleeves, tools."""
    least = cv2.blur(costs.min(axis=-1).clip(0, 60), (3, 3))
    strange = np.minimum.reduce([look.strangeness(lab, grid) for look in palette.looks])
    odd = (least > UNEXPLAINED) & (strange > STRANGE)
    odd |= (least > SKIN_UNEXPLAINED) & (strange > SKIN_STRANGE) & skin(rgb)
    width = max(3, round(THINNEST_UNKNOWN * grid.pixels_per_unit)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    like_paper = costs.argmin(axis=-1) > 0
    plain = np.minimum.reduce([look.cost(lab, grid, shadows=False) for look in palette.looks[1:]])
    plain = cv2.blur(plain.clip(0, 60), (5, 5))
    doubtful = like_paper & (plain > DOUBTFUL)
    arms = cv2.morphologyEx((doubtful | odd).astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0
    odd |= doubtful & touching_edge(np.asarray(arms), seen)
    solid = cv2.morphologyEx(odd.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    closed = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, kernel)
    _, numbered, stats, _ = cv2.connectedComponentsWithStats(closed)
    large = stats[:, cv2.CC_STAT_AREA] >= SMALLEST_UNKNOWN * grid.pixels_per_unit**2
    large[0] = False
    return np.asarray(cv2.dilate(large[numbered].astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)


def _sleeves(paper: Bools, unknown: Bools, seen: Bools, grid: Grid) -> Bools:
    """Sleeves of the paper's colour, which reach in from the edge of the photo, and thin shadows beside arms.

    None if there would be no sheet left.
    """
    width = max(3, round(THINNEST_SLEEVE * grid.pixels_per_unit)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    thick = cv2.morphologyEx(paper.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0
    reaching = touching_edge(thick, seen)
    if (thick & ~reaching).sum() < SMALLEST_SHEET * grid.pixels_per_unit**2:
        return np.zeros(paper.shape, bool)
    around = np.ones((2 * width + 1, 2 * width + 1), np.uint8)
    thin = paper & ~thick & (cv2.dilate((reaching | unknown).astype(np.uint8), around) > 0)
    return np.asarray(reaching | thin)


def _smooth(costs: Image) -> Image:
    """Mean field of a Potts model on the costs: the share of each class, (rows, cols, classes)."""
    pull = np.asarray(-0.4 * np.minimum(costs, 25.0), np.float32)
    shares = _softmax(pull)
    for _ in range(3):
        shares = _softmax(pull + SMOOTHING * np.asarray(cv2.blur(shares, (5, 5)), np.float32))
    return shares


def _softmax(energies: Image) -> Image:
    raised = np.exp(energies - energies.max(axis=-1, keepdims=True))
    return np.asarray(raised / raised.sum(axis=-1, keepdims=True), np.float32)


def _without_specks(labels: Labels, unknown: Bools, grid: Grid) -> Labels:
    """Regions too small to believe take the class that surrounds them."""
    smallest = SMALLEST_REGION * grid.pixels_per_unit**2
    specks = np.zeros(labels.shape, bool)
    for value in CLASSES:
        own = ((labels == value) & ~unknown).astype(np.uint8)
        count, numbered, stats, _ = cv2.connectedComponentsWithStats(own, connectivity=4)
        small = np.flatnonzero(stats[:, cv2.CC_STAT_AREA] < smallest)
        if count > 1 and len(small):
            specks |= np.isin(numbered, small[small > 0])
    return _fill(labels, specks)


def _fill(labels: Labels, holes: Bools) -> Labels:
    """Pixels in holes take the class of the nearest pixel outside."""
    if not holes.any() or holes.all():
        return labels
    _, nearest = cv2.distanceTransformWithLabels(
        holes.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    values = np.zeros(int(nearest.max()) + 1, np.uint8)
    values[nearest[~holes]] = labels[~holes]
    return np.where(holes, values[nearest], labels)


def _one_sheet(labels: Labels, unknown: Bools, grid: Grid) -> tuple[Labels, Bools]:
    """Paper colour that is not joined to the largest piece, even under what hides it, is no sheet."""
    paper = is_paper(labels) & ~unknown
    reach = max(3, round(0.06 * grid.pixels_per_unit)) | 1
    joined = cv2.dilate((paper | unknown).astype(np.uint8), np.ones((reach, reach), np.uint8))
    _, numbered = cv2.connectedComponents(joined, connectivity=4)
    if not paper.any():
        return labels, np.zeros(labels.shape, bool)
    sizes = np.bincount(numbered[paper])
    return labels, paper & (numbered != int(sizes.argmax()))


def _sharpen(labels: Labels, unknown: Bools, rgb: Picture) -> Image:
    """Shares of the classes; border pixels are split by where their light lies between both sides'."""
    shares = np.stack([labels == value for value in CLASSES], axis=-1).astype(np.float32)
    light = to_linear(rgb)
    known = (~unknown).astype(np.float32)[..., None]
    spread = cv2.dilate(shares * known, np.ones((5, 5), np.uint8))
    band = (spread.sum(axis=-1) > 1.5) & ~unknown
    means = [_local_mean(light, (labels == value) & ~unknown) for value in CLASSES]
    rows, cols = np.nonzero(band)
    pixel, near = light[rows, cols], spread[rows, cols] > 0
    distances = np.stack([np.linalg.norm(pixel - mean[rows, cols], axis=-1) for mean in means], axis=-1)
    inner = ~near[:, 0]
    distances[inner] = _shaded_distances(pixel[inner], [mean[rows, cols][inner] for mean in means])
    distances = np.where(near, distances, np.inf)
    order = np.argsort(distances, axis=-1)[:, :2]
    best, second = (np.take_along_axis(distances, order[:, k : k + 1], -1)[:, 0] for k in (0, 1))
    lead = best / np.maximum(best + second, 1e-6)
    split = np.zeros((len(rows), 3), np.float32)
    split[np.arange(len(rows)), order[:, 0]] = 1 - lead
    split[np.arange(len(rows)), order[:, 1]] = lead
    shares[rows, cols] = split
    return shares


def _shaded_distances(pixel: Image, means: list[Image]) -> Image:
    """Distance (N, classes) of pixels (N, 3) to each class's light, or what a shadow leaves of it."""
    distances = []
    for mean in means:
        share = np.einsum("ij,ij->i", pixel, mean) / np.maximum(np.einsum("ij,ij->i", mean, mean), 1e-9)
        distances.append(np.linalg.norm(pixel - mean * np.clip(share, 0.3, 1.0)[:, None], axis=-1))
    return np.stack(distances, axis=-1)


def _local_mean(light: Image, own: Bools) -> Image:
    """Mean light of a class's own pixels, away from its borders, in the neighbourhood of each pixel."""
    core = cv2.erode(own.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(np.float32)
    weighted = np.dstack([light * core[..., None], core])
    total = np.asarray(cv2.blur(weighted, (15, 15)), np.float32)
    wide = cv2.blur(cv2.resize(weighted, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA), (25, 25))
    total += 1e-3 * np.asarray(cv2.resize(wide, (light.shape[1], light.shape[0])), np.float32)
    return np.asarray(total[..., :3] / np.maximum(total[..., 3:], 1e-7), np.float32)
