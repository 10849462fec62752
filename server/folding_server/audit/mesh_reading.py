"""Meshes from files: OBJ, FOLD, and PLY and GLB with trimesh."""

from pathlib import Path
from typing import Any

import numpy as np

from folding_server.arrays import Floats
from folding_server.audit.mesh_record import Mesh
from folding_server.errors import FoldingError, ProgramError
from folding_server.interchange.fold_frames import FoldFrame, frame_of, read_frames
from folding_server.measuring.stated_model import stated_model
from folding_server.typed_text import text_in

MESH_ADVICE = "give the path of an OBJ, PLY, GLB or FOLD file"
BY_TRIMESH = (".ply", ".glb")


def read_mesh(path: Path) -> Mesh:
    """The mesh in a file. FoldingError if it cannot be read or has no faces."""
    match path.suffix.lower():
        case ".obj":
            mesh = _obj_mesh(text_in(path, MESH_ADVICE))
        case ".fold":
            mesh = _fold_mesh(text_in(path, MESH_ADVICE))
        case ending if ending in BY_TRIMESH:
            mesh = _trimesh_mesh(path)
        case _:
            raise FoldingError(f"{path} is no mesh by its name; {MESH_ADVICE}.")
    if not mesh.faces or mesh.extent <= 0:
        raise FoldingError(f"{path} holds no faces with an area; {MESH_ADVICE}.")
    return mesh


def _obj_mesh(text: str) -> Mesh:
    """Positions, texture coordinates and faces of a Wavefront OBJ; a vertex for each corner that has both."""
    points: list[list[float]] = []
    textures: list[list[float]] = []
    faces: list[list[tuple[int, int | None]]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        try:
            match words[:1]:
                case ["v"]:
                    points.append([float(word) for word in words[1:4]])
                case ["vt"]:
                    textures.append([float(word) for word in words[1:3]])
                case ["f"]:
                    faces.append([_corner(word, len(points), len(textures)) for word in words[1:]])
        except (ValueError, IndexError) as error:
            raise ProgramError(
                f"Line {number} of the OBJ file cannot be read: {line.strip()[:60]!r}."
            ) from error
    return _cornered(points, textures, faces)


def _corner(word: str, points: int, textures: int) -> tuple[int, int | None]:
    """The indices from 0 of a corner such as 3/2/1; negative ones count from the end."""
    parts = word.split("/")
    point = _index(parts[0], points)
    texture = _index(parts[1], textures) if len(parts) > 1 and parts[1] else None
    return point, texture


def _index(word: str, count: int) -> int:
    index = int(word) - 1 if int(word) > 0 else count + int(word)
    if not 0 <= index < count:
        raise IndexError(word)
    return index


def _cornered(
    points: list[list[float]], textures: list[list[float]], faces: list[list[tuple[int, int | None]]]
) -> Mesh:
    corners = sorted({corner for face in faces for corner in face}, key=lambda c: (c[0], c[1] or 0))
    number = {corner: index for index, corner in enumerate(corners)}
    textured = bool(corners) and all(texture is not None for _, texture in corners)
    sheet = [textures[texture] for _, texture in corners if texture is not None] if textured else None
    return Mesh(
        np.array([points[point] for point, _ in corners], float).reshape(-1, 3),
        tuple(tuple(number[corner] for corner in face) for face in faces),
        None if sheet is None else np.array(sheet, float).reshape(-1, 2),
    )


def _fold_mesh(text: str) -> Mesh:
    """The folded form of a FOLD file, with the sheet if it has the crease pattern too."""
    frames = read_frames(text)
    frame = frame_of(frames, "foldedForm") or frames[0]
    points = _in_space(frame)
    faces = tuple(tuple(face) for face in frame.faces_vertices)
    flat = frame_of(frames, "creasePattern")
    if flat is None or flat is frame or len(flat.vertices_coords) != len(points):
        return Mesh(points, faces)
    sheet = np.array([point[:2] for point in flat.vertices_coords], float)
    planar = bool(np.ptp(points[:, 2]) == 0)
    return Mesh(points, faces, sheet, stated_model(text).over if planar else None)


def _in_space(frame: FoldFrame) -> Floats:
    return np.array([[*point, 0.0][:3] for point in frame.vertices_coords], float).reshape(-1, 3)


def _trimesh_mesh(path: Path) -> Mesh:
    try:
        import trimesh  # noqa: PLC0415  (an extra)
    except ImportError as error:
        raise FoldingError(
            f"{path.suffix} files are read with trimesh, which is not installed; pip install 'foldingagent-mcp[audit]' "
            "brings it."
        ) from error
    try:
        loaded: Any = trimesh.load_mesh(str(path), process=False)
    except OSError as error:
        raise FoldingError(f"{path} cannot be read ({error.strerror}); {MESH_ADVICE}.") from error
    except Exception as error:
        raise FoldingError(f"{path} cannot be read as a mesh; {MESH_ADVICE}.") from error
    texture = getattr(loaded.visual, "uv", None)
    return Mesh(
        np.array(loaded.vertices, float).reshape(-1, 3),
        tuple(tuple(int(v) for v in face) for face in loaded.faces),
        None if texture is None else np.array(texture, float).reshape(-1, 2),
    )
