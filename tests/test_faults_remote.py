"""What callers over HTTP are told when the server's own disk or database fails: a sentence without a path of the machine."""

import logging
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from folding_server.errors import RunError
from folding_server.mcp.context import ServerSettings
from folding_server.store.database import DATABASE_NAME
from folding_server.store.run_store import RunStore
from hosts import in_memory
from mcp import MCPError
from test_adding_faults import limited_files
from token_hosts import called_by, served_to

pytestmark = pytest.mark.anyio

NOTES = "n" * 9000


@contextmanager
def served_beside(folder: Path) -> Iterator[str]:
    """A server over HTTP whose data lies in a folder; yields its URL."""
    with served_to(ServerSettings(folder / "data", shared=True), folder, "ada") as url:
        yield url


async def test_a_full_disk_is_told_without_a_path_and_the_path_is_in_the_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    with served_beside(tmp_path) as url:
        async with called_by("ada", url) as host:
            run_id = (await host.call("open_run"))["run_id"]
            with limited_files(0):
                refused = await host.refusal("save_checkpoint", frame=2, run_id=run_id, notes=NOTES)
            await host.call("save_checkpoint", frame=2, run_id=run_id, notes=NOTES)
    assert refused.startswith("The run database could not be written (")
    assert str(tmp_path) not in refused
    assert str(tmp_path / "data" / DATABASE_NAME) in caplog.text


async def test_a_damaged_database_is_told_without_a_path_for_tools_resources_and_completions(
    tmp_path: Path,
) -> None:
    with served_beside(tmp_path) as url:
        async with called_by("ada", url) as host:
            run_id = (await host.call("open_run"))["run_id"]
            with closing(sqlite3.connect(tmp_path / "data" / DATABASE_NAME)) as other, other:
                other.execute("ALTER TABLE folding_events RENAME TO lost")
            refused = await host.refusal("get_run", run_id=run_id)
            with pytest.raises(MCPError) as resource:
                await host.client.read_resource(f"folding://runs/{run_id}")
    for told in (refused, str(resource.value)):
        assert "The run database cannot be used" in told
        assert str(tmp_path) not in told


async def test_in_a_process_of_ones_own_the_path_is_told(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        await host.call("open_run")
        with limited_files(0):
            refused = await host.refusal("save_checkpoint", frame=2, notes=NOTES)
    assert str(tmp_path / DATABASE_NAME) in refused


def test_a_file_that_is_no_database_is_refused_with_and_without_its_path(tmp_path: Path) -> None:
    (tmp_path / DATABASE_NAME).write_bytes(b"no database " * 1000)
    with pytest.raises(RunError) as refusal:
        RunStore.in_folder(tmp_path)
    assert str(tmp_path) in str(refusal.value)
    assert str(tmp_path) not in refusal.value.elsewhere
    assert "file is not a database" in refusal.value.elsewhere
