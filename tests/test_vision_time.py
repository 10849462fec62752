"""The vision time of an owner is counted where it is limited, and counting it never costs an answer."""

import logging
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import anyio
import pytest
from callers import calling_as
from folding_server.errors import RunError
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.server import FoldingServer
from folding_server.store.database import DATABASE_NAME
from folding_server.store.limits import NO_LIMITS, OwnerLimits
from hosts import Host, data_of, text_of
from mcp import Client
from mcp.types import CallToolResult
from photographed import photos


@pytest.fixture
def database(tmp_path: Path) -> Iterator[sqlite3.Connection]:
    """The database of the data folder, as another program opens it."""
    with AppContext(ServerSettings(tmp_path)) as app:
        app.prepare()
    with closing(sqlite3.connect(tmp_path / DATABASE_NAME)) as opened:
        yield opened


def observe(folder: Path, limits: OwnerLimits, meanwhile: Callable[[], object] = lambda: None) -> str:
    """Compare the sailboat with its first photo as Ada, whose run is opened before ``meanwhile``; what came of it."""

    async def compared(app: AppContext) -> CallToolResult:
        async with Client(FoldingServer(app)) as client:
            await Host(client).call("open_run", sequence="sailboat")
            meanwhile()
            return await Host(client).answer("compare_to_frame", frame=1, images="none")

    settings = ServerSettings(folder, sequences=(photos(),), limits=limits)
    with AppContext(settings) as app, calling_as("ada"):
        answer = anyio.run(compared, app)
    if answer.is_error:
        raise RunError(text_of(answer))
    return str(data_of(answer)["verdict"])


@pytest.mark.parametrize(("limits", "rows"), [(NO_LIMITS, 0), (OwnerLimits(vision_seconds=60), 1)])
def test_time_is_counted_only_where_it_is_limited(
    tmp_path: Path, database: sqlite3.Connection, limits: OwnerLimits, rows: int
) -> None:
    assert observe(tmp_path, limits) == "MATCH"
    counted = database.execute("SELECT owner, seconds > 0 FROM folding_vision").fetchall()
    assert counted == [("ada", 1)] * rows


def test_an_answer_is_not_lost_where_its_time_cannot_be_counted(
    tmp_path: Path,
    database: sqlite3.Connection,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("folding_server.store.database.BUSY_SECONDS", 0.2)
    with caplog.at_level(logging.WARNING, "folding_server.mcp.services.long_calls"):
        limits = OwnerLimits(vision_seconds=60)
        assert observe(tmp_path, limits, lambda: database.execute("BEGIN IMMEDIATE")) == "MATCH"
    assert "The vision time of ada was not counted" in caplog.text


def test_who_has_used_up_the_time_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="0 a day"):
        observe(tmp_path, OwnerLimits(vision_seconds=0))
