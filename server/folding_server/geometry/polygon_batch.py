"""Many convex polygons at once: which contain each other, and which overlap. Lengths in sheet units."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from folding_server.arrays import Bools, Floats, Indices
from folding_server.geometry.convex import area
from folding_server.geometry.line import Point


@dataclass(frozen=True)
class ConvexPolygons:
    """n polygons with up to k corners; shorter ones are padded with their first corner.

    ``corners`` (n, k, 2); ``normals`` (n, k, 2) unit vectors out of each side; ``offsets`` (n, k);
    ``boxes`` (n, 4) as left, bottom, right, top.
    """

    corners: Floats
    normals: Floats
    offsets: Floats
    boxes: Floats

    def contains(self, outer: Indices, inner: Indices, tolerance: float) -> Bools:
        """For each pair, whether ``inner`` reaches out of ``outer`` by no more than the tolerance."""
        inside: Bools = self._heights(outer, inner).max(axis=(1, 2)) <= tolerance
        return inside

    def overlaps(self, first: Indices, second: Indices, tolerance: float) -> Bools:
        """For each pair, whether no side of either separates the two to within the tolerance."""
        meet = ~self._separates(first, second, tolerance)
        meet[meet] = ~self._separates(second[meet], first[meet], tolerance)
        return meet

    def _separates(self, by: Indices, other: Indices, tolerance: float) -> Bools:
        apart: Bools = (self._heights(by, other).min(axis=2) >= -tolerance).any(axis=1)
        return apart

    def _heights(self, sides: Indices, corners: Indices) -> Floats:
        """Signed distance of each corner from each side, positive outside: (pairs, sides, corners)."""
        heights: Floats = self.normals[sides] @ self.corners[corners].transpose(0, 2, 1)
        heights -= self.offsets[sides][:, :, None]
        return heights


def convex_polygons(outlines: Sequence[Sequence[Point]]) -> ConvexPolygons:
    """The polygons of outlines that may run either way round. Sides without length count for nothing."""
    longest = max(len(outline) for outline in outlines)
    corners = np.array(
        [[*outline, *([outline[0]] * (longest - len(outline)))] for outline in outlines], dtype=float
    )
    turns = np.array([1.0 if area(outline) > 0 else -1.0 for outline in outlines])
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.hypot(sides[..., 0], sides[..., 1])
    real = lengths > 0
    scale = turns[:, None] / np.where(real, lengths, 1.0)
    normals = np.stack([sides[..., 1] * scale, -sides[..., 0] * scale], axis=-1)
    offsets = np.where(real, (normals * corners).sum(axis=-1), np.inf)
    boxes = np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1)
    return ConvexPolygons(corners, normals, offsets, boxes)
