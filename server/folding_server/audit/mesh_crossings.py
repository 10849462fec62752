"""Faces of a mesh that pass through each other: in space, or by the order of the layers of a flat model."""

from collections.abc import Iterator, Sequence

import numpy as np

from folding_server.arrays import Bools, Floats, Ints
from folding_server.audit.mesh_record import Mesh
from folding_server.simulator.foldability.constraints import Conditions
from folding_server.simulator.foldability.equations import rows_of

REACH = 1e-4
"""How far, in units of the model's extent, an edge has to reach through a face to cross it."""
Above = dict[tuple[int, int], bool]
"""(i, j), i < j -> whether face i lies above face j."""


def piercings(mesh: Mesh) -> Iterator[tuple[int, int]]:
    """The pairs of faces that pierce each other and share no point."""
    triangles, owners = _triangles(mesh)
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    reach = REACH * mesh.extent
    seen: set[tuple[int, int]] = set()
    for index in range(len(triangles)):
        meets = ((low[index + 1 :] <= high[index]) & (high[index + 1 :] >= low[index])).all(axis=1)
        for other in np.flatnonzero(meets) + index + 1:
            pair = int(owners[index]), int(owners[other])
            if pair in seen or pair[0] == pair[1] or set(mesh.cycles[pair[0]]) & set(mesh.cycles[pair[1]]):
                continue
            if _pierces(triangles[index], triangles[other], reach) or _pierces(
                triangles[other], triangles[index], reach
            ):
                seen.add(pair)
                yield pair


def _triangles(mesh: Mesh) -> tuple[Floats, Ints]:
    """(t, 3, 3) triangles that the faces are cut into, and the face of each."""
    fans = [
        (face, (cycle[0], cycle[i], cycle[i + 1]))
        for face, cycle in enumerate(mesh.faces)
        for i in range(1, len(cycle) - 1)
    ]
    return mesh.points[[corners for _, corners in fans]], np.array([face for face, _ in fans])


def _pierces(first: Floats, second: Floats, reach: float) -> bool:
    """Whether a side of the first triangle goes through the inside of the second (Moeller and Trumbore 1997)."""
    a, b, c = second
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal)
    if area <= reach**2:
        return False
    heights = (first - a) @ (normal / area)
    for i in range(3):
        p, q, h, k = first[i - 1], first[i], heights[i - 1], heights[i]
        if min(h, k) < -reach and max(h, k) > reach:
            point = p + (q - p) * h / (h - k)
            inner = [float(np.cross(y - x, point - x) @ normal) / area for x, y in ((a, b), (b, c), (c, a))]
            if min(inner) > reach * np.sqrt(area):
                return True
    return False


def layers_above(heights: Floats, pairs: Sequence[tuple[int, int]], apart: float) -> Above | None:
    """Which face of each pair lies above by height (f,); None if layers of a pair lie in one plane."""
    if any(abs(heights[i] - heights[j]) <= apart for i, j in pairs):
        return None
    return {(i, j): bool(heights[i] > heights[j]) for i, j in pairs}


def order_crossings(found: Conditions, above: Above) -> int:
    """How many conditions on the order of layers an order breaks."""

    def higher(pair: tuple[int, int]) -> bool:
        i, j = pair
        return above[i, j] if i < j else not above[j, i]

    equal, even = (
        set(map(tuple, rows_of(found.equal, 4).tolist())),
        set(map(tuple, rows_of(found.even, 8).tolist())),
    )
    broken = sum(higher((a, b)) != higher((c, d)) for a, b, c, d in equal)
    return broken + sum(sum(higher(row[k : k + 2]) for k in range(0, 8, 2)) % 2 for row in even)


def is_flat(mesh: Mesh) -> tuple[bool, Floats]:
    """Whether all faces are parallel to one plane to within about two degrees, and the unit normal of that plane."""
    weights = mesh.normals
    _, _, axes = np.linalg.svd(weights, full_matrices=True)
    normal: Floats = axes[0]
    known: Bools = np.linalg.norm(weights, axis=1) > 0
    return bool((np.abs(weights[known] @ normal) > np.cos(np.radians(2))).all()), normal
