"""The outline of the paper in a photo: polygons whose straight sides are fitted below the pixel."""

from dataclasses import dataclass

import cv2
import numpy as np

from folding_server.arrays import Floats, Image, Mask, RgbImage
from folding_server.vision.grid import Grid
from folding_server.vision.pose import Pose
from folding_server.vision.straight import refine_polygon

ROUGHNESS = 0.008
"""Sheet units by which a side may depart from straight before it becomes two."""
SHORTEST_SIDE = 0.02
"""Sheet units below which a side is put down to noise."""
STRAIGHT = 0.006
"""Sheet units from the line between its neighbours within which a corner is put down to noise."""
SMALLEST_PIECE = 0.004
"""Area, in sheet units squared, of the smallest piece that has an outline."""
EDGE_SEARCH = 0.012
"""Sheet units from the first estimate within which the picture's edge is looked for."""
_FINE = 3
"""Outlines are taken at so many times the resolution."""


@dataclass(frozen=True)
class Outline:
    """One visible piece of the paper.

    ``corners`` (N, 2) are in sheet units of the table plane, where the flat sheet of the first photo is the unit
    square, clockwise as seen. ``seen`` says of each side, from a corner to the next, whether the photo shows it
    against the table; a side where something hides the paper is only where the view ends.
    """

    corners: tuple[tuple[float, float], ...]
    seen: tuple[bool, ...]

    @property
    def hidden(self) -> list[int]:
        """The sides that something hides, each by the number of its first corner, from 0."""
        return [number for number, shown in enumerate(self.seen) if not shown]


def find_outlines(rgb: RgbImage, pose: Pose, shares: Image, unknown: Mask, grid: Grid) -> tuple[Outline, ...]:
    """The outlines of all pieces of paper in a photo, largest first.

    ``shares`` (rows, cols, 3) and ``unknown`` (rows, cols) are its classes on ``grid``; ``rgb`` is the whole photo.
    """
    paper = np.where(unknown, 0, shares[..., 1] + shares[..., 2]).astype(np.float32)
    pieces = [_outline(piece, rgb, pose, unknown, grid) for piece in _pieces(paper, grid)]
    return tuple(piece for piece in pieces if piece is not None)


def _pieces(paper: Image, grid: Grid) -> list[Floats]:
    """The contours (N, 2) in pixels of the grid at which half of a pixel is paper, largest first."""
    size = (paper.shape[1] * _FINE, paper.shape[0] * _FINE)
    fine = (cv2.resize(paper, size, interpolation=cv2.INTER_LINEAR) > 0.5).astype(np.uint8)
    contours, _ = cv2.findContours(fine, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    least = SMALLEST_PIECE * (grid.pixels_per_unit * _FINE) ** 2
    large = [c for c in contours if cv2.contourArea(c) >= least]
    ordered = sorted(large, key=cv2.contourArea, reverse=True)
    return [(c.reshape(-1, 2).astype(np.float64) + 0.5) / _FINE - 0.5 for c in ordered]


def _outline(contour: Floats, rgb: RgbImage, pose: Pose, unknown: Mask, grid: Grid) -> Outline | None:
    corners = _corners(contour, grid)
    if len(corners) < 3:
        return None
    seen = _seen_sides(corners, unknown, grid)
    refined = _refined(rgb, pose, pose.to_photo(grid.to_plane(corners)), seen)
    kept, shown = _without_straight_corners(pose.to_plane(refined), seen)
    if len(kept) < len(refined):
        refined = _refined(rgb, pose, pose.to_photo(kept), shown)
    return Outline(tuple((float(x), float(y)) for x, y in pose.to_plane(refined)), tuple(shown))


def _refined(rgb: RgbImage, pose: Pose, photo: Floats, seen: list[bool]) -> Floats:
    """Corners in the photo, the sides that are seen brought to its edges."""
    return refine_polygon(rgb, photo, max(2.5, EDGE_SEARCH * pose.pixels_per_unit), fixed=~np.array(seen))


def _corners(contour: Floats, grid: Grid) -> Floats:
    """The corners (N, 2) of the polygon that a contour approximates, clockwise on screen, in pixels of the grid."""
    start = contour.astype(np.float32).reshape(-1, 1, 2)
    simple = cv2.approxPolyDP(start, ROUGHNESS * grid.pixels_per_unit, closed=True).reshape(-1, 2)
    corners = _without_short_sides(simple.astype(np.float64), SHORTEST_SIDE * grid.pixels_per_unit)
    x, y = corners[:, 0], corners[:, 1]
    twice = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return corners if twice > 0 else corners[::-1].copy()


def _without_short_sides(corners: Floats, shortest: float) -> Floats:
    """A blunted tip becomes the point where its long sides meet; other short sides lose their first end."""
    while len(corners) > 3:
        lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        short = int(lengths.argmin())
        if lengths[short] >= shortest:
            break
        following = (short + 1) % len(corners)
        tip = _tip(corners, short, 4 * shortest)
        corners[following] = corners[following] if tip is None else tip
        corners = np.delete(corners, short, axis=0)
    return corners


def _tip(corners: Floats, index: int, reach: float) -> Floats | None:
    """Where the neighbours of a short side meet, if that is near."""
    count = len(corners)
    p, q = corners[index - 1], corners[index]
    r, s = corners[(index + 1) % count], corners[(index + 2) % count]
    matrix = np.column_stack([q - p, r - s])
    if abs(np.linalg.det(matrix)) < 1e-6:
        return None
    point = p + (q - p) * np.linalg.solve(matrix, r - p)[0]
    return np.asarray(point) if float(np.linalg.norm(point - q)) < reach else None


def _without_straight_corners(corners: Floats, seen: list[bool]) -> tuple[Floats, list[bool]]:
    """Corners that lie on the line between their neighbours are none, unless one side of them is hidden."""
    kept = np.asarray(corners)
    shown = np.array(seen)
    while len(kept) > 3:
        before, after = np.roll(kept, 1, axis=0), np.roll(kept, -1, axis=0)
        along = after - before
        beside = np.abs(along[:, 0] * (kept - before)[:, 1] - along[:, 1] * (kept - before)[:, 0])
        beside = beside / (np.linalg.norm(along, axis=1) + 1e-9)
        beside[shown != np.roll(shown, 1)] = np.inf
        flattest = int(beside.argmin())
        if beside[flattest] >= STRAIGHT:
            break
        kept, shown = np.delete(kept, flattest, axis=0), np.delete(shown, flattest)
    return kept, [bool(each) for each in shown]


def _seen_sides(corners: Floats, unknown: Mask, grid: Grid) -> list[bool]:
    """Whether less than half of each side lies at something unknown."""
    width = max(3, round(0.03 * grid.pixels_per_unit)) | 1
    near = cv2.dilate(unknown.astype(np.uint8), np.ones((width, width), np.uint8)) > 0
    return [not _hidden(near, corners[i], corners[(i + 1) % len(corners)]) for i in range(len(corners))]


def _hidden(near: Mask, start: Floats, end: Floats) -> bool:
    places = np.rint(start + np.linspace(0.05, 0.95, 40)[:, None] * (end - start)).astype(int)
    rows = places[:, 1].clip(0, near.shape[0] - 1)
    cols = places[:, 0].clip(0, near.shape[1] - 1)
    return bool(near[rows, cols].mean() >= 0.5)
