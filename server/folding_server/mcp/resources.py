"""Resources: sequences, photos and runs at addresses of their own, for hosts that attach them to a chat."""

from typing import TYPE_CHECKING

from folding_server.mcp.context import AppContext
from folding_server.mcp.services.images import diagram, diagram_svg
from folding_server.mcp.services.run_status import run_info
from folding_server.mcp.tools.runs import sequence_list
from folding_server.simulator import folded_state

if TYPE_CHECKING:
    from mcp.server.mcpserver import MCPServer

JSON = "application/json"


def register(server: "MCPServer[AppContext]", app: AppContext) -> None:
    """Give the server its resources, all read from one desk."""
    _register_sequences(server, app)
    _register_runs(server, app)


def _register_sequences(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource("folding://sequences", mime_type=JSON)
    def sequences() -> str:
        """The photo sequences that can be opened."""
        return sequence_list(app).model_dump_json()

    @server.resource("folding://sequences/{name}/frames/{frame}", mime_type="image/jpeg")
    def photo(name: str, frame: int) -> bytes:
        """The photo of a keyframe; frames count from 1."""
        return app.library.open(name).photo_for_model(frame).data


def _register_runs(server: "MCPServer[AppContext]", app: AppContext) -> None:
    @server.resource("folding://runs/{run_id}", mime_type=JSON)
    def run(run_id: str) -> str:
        """Where a run stands."""
        return run_info(app.run(run_id)).model_dump_json()

    @server.resource("folding://runs/{run_id}/state", mime_type=JSON)
    def state(run_id: str) -> str:
        """The current state of a run as numbers."""
        return folded_state(app.paper(app.run(run_id))).model_dump_json()

    @server.resource("folding://runs/{run_id}/program", mime_type=JSON)
    def program(run_id: str) -> str:
        """The folding program of a run's current state."""
        return app.run(run_id).current_program().model_dump_json(exclude_none=True)

    @server.resource("folding://runs/{run_id}/diagram.svg", mime_type="image/svg+xml")
    def drawing(run_id: str) -> str:
        """The current state of a run as vector graphics."""
        found = app.run(run_id)
        return diagram_svg(found, app.paper(found))

    @server.resource("folding://runs/{run_id}/diagram.png", mime_type="image/png")
    def picture(run_id: str) -> bytes:
        """The current state of a run as an image."""
        found = app.run(run_id)
        return diagram(found, app.paper(found)).data
