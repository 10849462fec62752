"""Resources: sequences, photos and runs at addresses of their own, for hosts that attach them to a chat."""

import json
from typing import TYPE_CHECKING

from mcp.types import Icon

from folding_server.errors import RunError
from folding_server.mcp import icons
from folding_server.mcp.context import AppContext
from folding_server.mcp.services import run_addresses as at
from folding_server.mcp.services.images import diagram, diagram_svg
from folding_server.mcp.services.run_list import MOST_LISTED, newest_runs
from folding_server.mcp.services.run_status import checkpoint_state, run_info
from folding_server.mcp.tools.runs import sequence_list
from folding_server.simulator import folded_state
from folding_server.simulator.vertices import id_ranges

if TYPE_CHECKING:
    from folding_schemas.results import ExportFormat
    from mcp.server.mcpserver import MCPServer

SVG = "image/svg+xml"
_PHOTO: list[Icon] = [icons.PHOTO_ICON]
_RUN: list[Icon] = [icons.RUN_ICON]
_FILE: list[Icon] = [icons.FILE_ICON]
_CHECKPOINT: list[Icon] = [icons.CHECKPOINT_ICON]


def register(server: "MCPServer[AppContext]", app: AppContext) -> None:
    """Give the server its resources, all read from one app context."""
    _register_sequences(server, app)
    _register_runs(server, app)
    _register_diagrams(server, app)
    _register_files(server, app)
    _register_parts(server, app)


def _register_sequences(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource(at.SEQUENCE_LIST, title="Photo sequences", mime_type=at.JSON, icons=_PHOTO)
    def sequences() -> str:
        """The photo sequences that can be opened."""
        return sequence_list(app).model_dump_json()

    @server.resource(
        "folding://sequences/{name}/frames/{frame}",
        title="Photo of a keyframe",
        mime_type="image/jpeg",
        icons=_PHOTO,
    )
    def photo(name: str, frame: int) -> bytes:
        """The photo of a keyframe; frames count from 1."""
        return app.library.open(name).photo_for_model(frame).data

    @server.resource(
        "folding://sequences/{name}/frames/{frame}/thumbnail",
        title="Thumbnail of a keyframe",
        mime_type="image/jpeg",
        icons=_PHOTO,
    )
    def thumbnail(name: str, frame: int) -> bytes:
        """The photo of a keyframe, a few kilobytes small, for lists."""
        return app.library.open(name).photo_thumbnail(frame).data


def _register_runs(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource(at.RUN_LIST, title="Runs", mime_type=at.JSON, icons=_RUN)
    def runs() -> str:
        """The newest runs that can be taken up again."""
        return newest_runs(app, MOST_LISTED).model_dump_json()

    @server.resource(at.RUN, title="Run", mime_type=at.JSON, icons=_RUN)
    def run(run_id: str) -> str:
        """Where a run stands."""
        return run_info(app.run(run_id)).model_dump_json()

    @server.resource(at.STATE, title="Current state", mime_type=at.JSON, icons=_RUN)
    def state(run_id: str) -> str:
        """The current state of a run as numbers."""
        return folded_state(app.paper(app.run(run_id))).model_dump_json()


def _register_diagrams(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource(at.DIAGRAM_SVG, title="Diagram (SVG)", mime_type=SVG, icons=_FILE)
    def drawing(run_id: str) -> str:
        """The current state of a run as vector graphics."""
        found = app.run(run_id)
        return diagram_svg(found, app.paper(found))

    @server.resource(at.DIAGRAM_PNG, title="Diagram (PNG)", mime_type="image/png", icons=_FILE)
    def picture(run_id: str) -> bytes:
        """The current state of a run as an image."""
        found = app.run(run_id)
        return diagram(found, app.paper(found)).data


def _register_files(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource(at.PROGRAM, title="Folding program", mime_type=at.JSON, icons=_FILE)
    def program(run_id: str) -> str:
        """The folding program of a run's current state."""
        return app.run(run_id).current_program().model_dump_json(exclude_none=True)

    @server.resource(at.MODEL, title="Folded model (FOLD)", mime_type=at.JSON, icons=_FILE)
    def model(run_id: str) -> str:
        """The current state of a run as a FOLD file: folded form and crease pattern."""
        return _exported(app, run_id, "fold")

    @server.resource(at.CREASE_PATTERN, title="Crease pattern (FOLD)", mime_type=at.JSON, icons=_FILE)
    def crease_pattern(run_id: str) -> str:
        """The crease pattern of a run's current state as a FOLD file."""
        return _exported(app, run_id, "crease-pattern")

    @server.resource(at.CREASE_PATTERN_SVG, title="Crease pattern (SVG)", mime_type=SVG, icons=_FILE)
    def crease_pattern_drawing(run_id: str) -> str:
        """The crease pattern of a run's current state as vector graphics."""
        return _exported(app, run_id, "crease-pattern-svg")


def _register_parts(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource(at.CHECKPOINT, title="Checkpoint", mime_type=at.JSON, icons=_CHECKPOINT)
    def checkpoint(run_id: str, frame: int) -> str:
        """The state saved for a frame, its actions and notes."""
        return checkpoint_state(app, app.run(run_id), frame).model_dump_json()

    @server.resource(at.VERTEX, title="Vertex", mime_type=at.JSON, icons=_RUN)
    def vertex(run_id: str, vertex: int) -> str:
        """Where a vertex of a run's current state lies, and the faces around it."""
        state = folded_state(app.paper(app.run(run_id)))
        if str(vertex) not in state.vertices:
            known = id_ranges(map(int, state.vertices))
            raise RunError(f"There is no vertex {vertex}; the vertices are {known}.")
        faces = [int(face) for face, around in state.faces.items() if vertex in around]
        return json.dumps({"vertex": vertex, "position": state.vertices[str(vertex)], "faces": faces})


def _exported(app: AppContext, run_id: str, file_format: "ExportFormat") -> str:
    """The current state of a run in a text format."""
    from folding_server.interchange.export import export  # noqa: PLC0415  (loads shapely)

    run = app.run(run_id)
    return str(export(app.paper(run), file_format, program=run.current_program()).content)
