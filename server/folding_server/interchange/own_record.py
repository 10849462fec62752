"""Our own FOLD files read back: exactly the paper that was written, checked against what the file shows."""

from math import hypot

from folding_server.errors import ProgramError
from folding_server.geometry.graph import edge_of
from folding_server.geometry.isometry import Isometry
from folding_server.interchange.crease_pattern import turned_round
from folding_server.interchange.flat_motions import ROUNDED
from folding_server.interchange.fold_frames import FoldFrame, FoldRecord
from folding_server.simulator.paper import FoldedCrease, Paper


def restored(folded: FoldFrame, pattern: FoldFrame) -> Paper:
    """The paper of a file with a ``folding:record``; ProgramError if the record and the geometry disagree."""
    record = folded.record
    assert record is not None
    _check_names(folded, pattern, record)
    vertices_coords = {
        v: (p[0], p[1]) for v, p in zip(folded.vertex_ids, pattern.vertices_coords, strict=True)
    }
    counterclockwise = set(record.counterclockwise)
    faces = {}
    for face, cycle in zip(folded.face_ids, folded.faces_vertices, strict=True):
        ids = tuple(folded.vertex_ids[v] for v in cycle)
        faces[face] = ids if face in counterclockwise else turned_round(ids)
    paper = Paper(
        sheet=record.sheet,
        vertices_coords=vertices_coords,
        faces=faces,
        isometries={f: Isometry(*t) for f, t in zip(folded.face_ids, record.isometries, strict=True)},
        order=tuple(record.order),
        creases={edge_of(*edge): _crease(chain) for edge, chain in record.creases},
        folds=record.folds,
        fold_edges={number: (u, v) for number, u, v in record.fold_edges},
    )
    _check_geometry(paper, folded)
    return paper


def _crease(chain: list[tuple[int, int]]) -> FoldedCrease:
    crease = None
    for fold, moved in reversed(chain):
        crease = FoldedCrease(fold, moved, crease)
    if crease is None:
        raise ProgramError("The FOLD file's folding:record has a crease without a fold; export it again.")
    return crease


def _check_names(folded: FoldFrame, pattern: FoldFrame, record: FoldRecord) -> None:
    """Everything the record names must be there."""
    faces, vertices = set(folded.face_ids), set(folded.vertex_ids)
    edges = (
        {(folded.vertex_ids[u], folded.vertex_ids[v]) for u, v in folded.edges_vertices}
        if vertices
        else set()
    )
    sound = (
        len(vertices) == len(folded.vertices_coords) == len(pattern.vertices_coords)
        and len(faces) == len(folded.faces_vertices) == len(record.isometries)
        and sorted(record.order) == sorted(faces)
        and {tuple(edge) for edge, _ in record.creases} <= edges
        and {moved for _, chain in record.creases for _, moved in chain} <= faces
    )
    if not sound:
        raise ProgramError(
            "The FOLD file's folding:record does not fit its vertices, edges and faces; another program "
            "has changed the "
            "file: remove folding:record from it to read it by its geometry alone."
        )


def _check_geometry(paper: Paper, folded: FoldFrame) -> None:
    """The isometries must put every vertex where the folded form has it."""
    for v, point in zip(folded.vertex_ids, folded.vertices_coords, strict=True):
        x, y = paper.folded_vertices_coords[v]
        if hypot(x - point[0], y - point[1]) > ROUNDED:
            raise ProgramError(
                f"In the FOLD file vertex {v} lies at ({point[0]:g}, {point[1]:g}), but its "
                "folding:record puts it at "
                f"({x:g}, {y:g}); another program has moved it: remove folding:record to read the "
                "geometry alone."
            )
