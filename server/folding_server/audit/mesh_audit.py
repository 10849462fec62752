"""Whether a mesh is one folded square sheet, in figures and sentences."""

from dataclasses import dataclass, replace
from typing import Literal

import networkx as nx
import numpy as np

from folding_server.arrays import Floats
from folding_server.audit.mesh_crossings import is_flat, layers_above, order_crossings, piercings
from folding_server.audit.mesh_record import Mesh
from folding_server.audit.mesh_unfolding import UnfoldedMesh, square_misfits, unfolded_mesh
from folding_server.geometry.convex import area
from folding_server.simulator.foldability import Assignment, CreasePattern
from folding_server.simulator.foldability.constraints import conditions
from folding_server.simulator.foldability.equations import rows_of
from folding_server.simulator.foldability.flat_faces import lay_flat
from folding_server.simulator.foldability.local import local_violations
from folding_server.simulator.validity.contacts import covering_faces

RIGID = 5e-3
"""Share of the sheet's side by which distances may change and faces disagree: thickness, and files with few digits."""
COPLANAR = 1.0
"""Degrees up to which faces that share an edge are one panel."""
ONE_PLANE = 1e-6
"""Share of the extent up to which two layers lie in one plane."""


@dataclass(frozen=True)
class MeshAudit:
    """What is found of a mesh.

    ``faces`` as the file has them, ``panels`` those left when flat neighbours are one; ``layers`` the most that lie over one
    point. ``stretch`` and ``apart`` in shares of the sheet's side: how much distances change, and how far faces disagree. ``kawasaki``
    vertices that cannot lie flat, None for a model that does not lie flat itself; ``crossings`` None where the order of layers is
    not told. ``problems`` is empty if the mesh passes.
    """

    components: int
    faces: int
    panels: int
    layers: int
    shape: Literal["flat", "in space"]
    unfolds_to_square: bool
    stretch: float
    apart: float
    kawasaki: int | None
    crossings: int | None
    problems: tuple[str, ...]

    @property
    def passes(self) -> bool:
        """Whether it is one folded square sheet, as far as can be told."""
        return not self.problems


def audit_mesh(mesh: Mesh) -> MeshAudit:
    """What is found of a mesh. Texture coordinates may be places on the sheet, or anything else: if it does not pass by them, it
    is looked at without them too, and the kinder finding counts.
    """
    found = _audited(mesh)
    if found.passes or mesh.sheet is None:
        return found
    bare = _audited(replace(mesh, sheet=None))
    return bare if len(bare.problems) < len(found.problems) else found


def _audited(mesh: Mesh) -> MeshAudit:
    """Count pieces, faces, panels and layers; unfold the largest piece; look for what paper cannot do."""
    problems: list[str] = []
    if len(mesh.components) != 1:
        problems.append(f"It is {len(mesh.components)} pieces that share no edge, not one sheet.")
    crowded = sum(len(faces) > 2 for faces in mesh.beside.values())
    if crowded:
        problems.append(f"At {crowded} edges more than two faces meet.")
    flat, normal = is_flat(mesh)
    piece = mesh.part(mesh.components[0])
    unfolded = unfolded_mesh(piece)
    misfits = list(square_misfits(unfolded, piece))
    problems += misfits
    for error, said in (
        (unfolded.stretch, "Faces are stretched or bent"),
        (unfolded.apart, "Unfolded, faces disagree"),
    ):
        if error > RIGID:
            problems.append(f"{said} by {error:.2%} of the sheet's side (allowed {RIGID:.2%}).")
    kawasaki, crossings = (
        _flat_faults(piece, unfolded, normal) if flat else (None, sum(1 for _ in piercings(mesh)))
    )
    if kawasaki:
        problems.append(f"At {kawasaki} vertices inside the sheet the angles do not let it lie flat.")
    if crossings:
        problems.append(f"Paper passes through paper at {crossings} places.")
    return MeshAudit(
        len(mesh.components),
        len(mesh.faces),
        _panels(mesh),
        _layers(mesh, normal),
        "flat" if flat else "in space",
        not misfits and len(mesh.components) == 1,
        round(unfolded.stretch, 6),
        round(unfolded.apart, 6),
        kawasaki,
        crossings,
        tuple(problems),
    )


def _panels(mesh: Mesh) -> int:
    """The faces, those that share an edge and lie in one plane side by side taken as one."""
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(mesh.faces)))
    for a, b in mesh.neighbours():
        if mesh.normals[a] @ mesh.normals[b] > np.cos(np.radians(COPLANAR)):
            graph.add_edge(a, b)
    return int(nx.number_connected_components(graph))


def _layers(mesh: Mesh, normal: Floats) -> int:
    """The most faces over one point, seen along a normal."""
    import shapely  # noqa: PLC0415  (slow to load)

    seen = _projected(mesh.points, normal) / mesh.extent
    outlines = np.array([shapely.Polygon(seen[list(face)]) for face in mesh.faces])
    outlines = outlines[shapely.is_valid(outlines) & (shapely.area(outlines) > ONE_PLANE)]
    return max(map(len, covering_faces(outlines, RIGID)), default=1) if len(outlines) else 0


def _projected(points: Floats, normal: Floats) -> Floats:
    """(n, 2): points seen along a normal."""
    across = np.eye(3)[int(np.abs(normal).argmin())]
    first = np.cross(normal, across)
    first = first / np.linalg.norm(first)
    return np.stack([points @ first, points @ np.cross(normal, first)], axis=1)


def _flat_faults(mesh: Mesh, unfolded: UnfoldedMesh, normal: Floats) -> tuple[int, int | None]:
    """Vertices that cannot lie flat, and conditions on the layers that their order breaks, None without an order."""
    pattern = _pattern(mesh, unfolded)
    vertices = {
        each.vertex
        for each in local_violations(pattern)
        if each.condition == "Kawasaki" or "odd" in each.detail
    }
    flat = lay_flat(pattern)
    if flat.loose or flat.odd is not None or flat.spread > RIGID:
        return len(vertices), None
    found = conditions(flat, RIGID)
    pairs = [(i, j) for i, j in rows_of(found.pairs, 2).tolist()]
    if mesh.over is not None:
        listed = {(i, j): (i, j) in mesh.over for i, j in pairs}
        known = all((i, j) in mesh.over or (j, i) in mesh.over for i, j in pairs)
        above = listed if known else None
    else:
        heights = np.array([(mesh.points[list(face)] @ normal).mean() for face in mesh.faces])
        above = layers_above(heights, pairs, ONE_PLANE * mesh.extent)
    return len(vertices), None if above is None else order_crossings(found, above)


def _pattern(mesh: Mesh, unfolded: UnfoldedMesh) -> CreasePattern:
    """The crease pattern: folded creases are those between faces that show other sides; which way is not asked."""
    edges = sorted(mesh.beside)
    places = [(float(x), float(y)) for x, y in unfolded.places]
    front = [np.sign(area([places[v] for v in cycle])) for cycle in mesh.cycles]

    def letter(faces: list[int]) -> Assignment:
        if len(faces) != 2:
            return "B"
        a, b = faces
        return "U" if (mesh.normals[a] @ mesh.normals[b]) * front[a] * front[b] < 0 else "F"

    return CreasePattern(
        tuple(places), tuple(edges), tuple(letter(mesh.beside[edge]) for edge in edges), mesh.cycles
    )
