"""What a server process loads before a tool needs it."""

import subprocess
import sys
from pathlib import Path

import pytest
from photographed import photos

HEAVY = ("litellm", "cv2", "scipy", "ortools", "av", "cairosvg", "folding_client")

SERVE_AND_FOLD = """
import asyncio, sys
from pathlib import Path
from mcp import Client
from folding_server.mcp.server import FoldingServer
from folding_server.mcp.context import AppContext, ServerSettings

async def main(data, calls, sequences):
    settings = ServerSettings(Path(data), sequences=tuple(map(Path, sequences)), vision_workers=1)
    with AppContext(settings) as desk:
        async with Client(FoldingServer(desk)) as client:
            await client.list_tools()
            for tool, arguments in calls:
                result = await client.call_tool(tool, arguments)
                assert not result.is_error, result.content

calls = [
    ("open_run", {}), ("add_vertex", {"edge": [1, 2], "position": 0.5}),
    ("fold", {"edge": [5, 4], "direction": 1}), ("rotate", {"angle": 45}), ("flip", {"axis": "x"}),
    ("unfold", {}),
    ("undo", {}), ("get_current_state", {}), ("save_checkpoint", {"frame": 2}),
    ("restore_checkpoint", {"frame": 1}), ("get_run", {}),
]
seeing = [
    ("open_run", {"sequence": "sailboat"}), ("save_checkpoint", {"frame": 1}),
    ("propose_actions", {"frame": 2}), ("compare_to_frame", {"frame": 1}),
]
asyncio.run(main(sys.argv[1], {"list": [], "fold": calls, "see": seeing}[sys.argv[2]], sys.argv[3:]))
print(*sorted({name.partition(".")[0] for name in sys.modules}))
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """The top-level modules of fresh processes, by what they have done."""
    return {doing: _modules_after(doing, tmp_path_factory.mktemp(doing)) for doing in ("list", "fold", "see")}


def _modules_after(doing: str, data: Path) -> set[str]:
    command = [
        sys.executable,
        "-c",
        SERVE_AND_FOLD,
        str(data),
        doing,
        *([str(photos())] if doing == "see" else []),
    ]
    finished = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return set(finished.stdout.split())


@pytest.mark.slow
def test_listing_tools_loads_no_heavy_library_and_no_database(loaded: dict[str, set[str]]) -> None:
    assert not loaded["list"] & {*HEAVY, "sqlalchemy", "numpy", "shapely", "networkx"}


@pytest.mark.slow
def test_folding_loads_the_database_and_nothing_heavy(loaded: dict[str, set[str]]) -> None:
    assert not loaded["fold"] & set(HEAVY)
    assert "sqlalchemy" in loaded["fold"]


@pytest.mark.slow
def test_seeing_loads_opencv_in_a_worker_process_alone(loaded: dict[str, set[str]]) -> None:
    assert not loaded["see"] & {"cv2", "scipy"}
    assert "numpy" in loaded["see"]
