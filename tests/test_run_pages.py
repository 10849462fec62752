"""The list of runs page by page through the tool, and whose runs it and updates show over HTTP."""

from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest
from folding_server.mcp.context import ServerSettings
from folding_server.mcp.subscriptions import LONGEST_WATCHED, MOST_WATCHED
from folding_server.store.database import DATABASE_NAME
from folding_server.store.run_store import RunStore
from hosts import Host, in_memory, text_of
from mcp import MCPError
from store import fill
from token_hosts import called_by, served_to

pytestmark = pytest.mark.anyio

RUNS = 10_000
ADA, BOB = "owner0", "owner1"
"""Two of the four owners of the runs."""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with ten thousand runs of four owners."""
    folder = tmp_path_factory.mktemp("runs")
    with RunStore.in_folder(folder) as store:
        run_id = store.create(owner=ADA).run_id
    fill(folder / DATABASE_NAME, run_id, RUNS - 1)
    return folder


@pytest.fixture
def url(data: Path, tmp_path: Path) -> Iterator[str]:
    """A server of these runs over HTTP, with a token for each of the two owners."""
    with served_to(ServerSettings(data, shared=True), tmp_path, ADA, BOB) as address:
        yield address


async def pages(host: Host, count: int) -> list[str]:
    """The ids of all runs that a host is shown, in the order of the pages."""
    found: list[str] = []
    while True:
        page = await host.call("list_runs", count=count, **({"before": found[-1]} if found else {}))
        found += [each["run_id"] for each in page["runs"]]
        if not page["more"]:
            return found


async def test_the_tool_pages_through_ten_thousand_runs_and_misses_none(data: Path) -> None:
    with RunStore.in_folder(data) as store:
        stored = [run.run_id for run in store.list_runs()]
    async with in_memory(data) as host:
        found = await pages(host, 100)
        first = text_of(await host.answer("list_runs", count=3))
        after_the_last = text_of(await host.answer("list_runs", before=found[-1]))
        assert "There is no run 'nonsense'" in await host.refusal("list_runs", before="nonsense")
    assert found == stored
    assert len(set(found)) == RUNS
    assert f"There are older ones: list_runs with before={found[2]}." in first
    assert f"No run was opened before {found[-1]}." in after_the_last


async def test_over_http_each_owner_pages_through_their_own_runs_alone(data: Path, url: str) -> None:
    with RunStore.in_folder(data) as store:
        stored = {owner: [run.run_id for run in store.list_runs(owner)] for owner in (ADA, BOB)}
    async with called_by(ADA, url) as ada, called_by(BOB, url) as bob:
        assert await pages(ada, 100) == stored[ADA]
        assert await pages(bob, 100) == stored[BOB]
        assert "There is no run" in await bob.refusal("list_runs", before=stored[ADA][5])
    assert not set(stored[ADA]) & set(stored[BOB])


@pytest.mark.filterwarnings("ignore::mcp.shared.exceptions.MCPDeprecationWarning")
async def test_nobody_watches_the_run_of_another_owner(url: str) -> None:
    async with called_by(ADA, url, "legacy") as ada, called_by(BOB, url, "legacy") as bob:
        run_id = (await ada.call("open_run"))["run_id"]
        address = f"folding://runs/{run_id}/state"
        await ada.client.session.subscribe_resource(address)
        with pytest.raises(MCPError, match=f"There is no run '{run_id}'"):
            await bob.client.session.subscribe_resource(address)
        await bob.client.session.subscribe_resource("folding://runs")


async def test_a_host_of_today_does_not_listen_to_the_run_of_another_owner(url: str) -> None:
    async with called_by(ADA, url) as ada, called_by(BOB, url) as bob:
        run_id = (await ada.call("open_run"))["run_id"]
        addresses = ["folding://runs", f"folding://runs/{run_id}"]
        async with ada.client.listen(resource_subscriptions=addresses) as told:
            await ada.call("fold", edge=[1, 3], direction=1, run_id=run_id)
            with anyio.fail_after(10):
                assert str((await anext(aiter(told))).uri) in addresses
        with pytest.raises(MCPError, match=f"There is no run '{run_id}'"):
            async with bob.client.listen(resource_subscriptions=addresses):
                pytest.fail("another owner listens to it")


@pytest.mark.filterwarnings("ignore::mcp.shared.exceptions.MCPDeprecationWarning")
async def test_a_connection_watches_so_many_addresses_and_no_more(tmp_path: Path) -> None:
    async with in_memory(tmp_path, mode="legacy") as host:
        run_id = (await host.call("open_run"))["run_id"]
        watched = [f"folding://runs/{run_id}/vertices/{number}" for number in range(MOST_WATCHED)]
        for address in (*watched, watched[0]):
            await host.client.session.subscribe_resource(address)
        with pytest.raises(MCPError, match=f"At most {MOST_WATCHED} addresses can be watched"):
            await host.client.session.subscribe_resource("folding://runs")
        await host.client.session.unsubscribe_resource(watched[0])
        await host.client.session.subscribe_resource("folding://runs")
        with pytest.raises(MCPError, match="There is no resource"):
            await host.client.session.subscribe_resource("folding://runs/" + "x" * LONGEST_WATCHED)


async def test_a_host_of_today_listens_to_so_many_addresses_and_no_more(tmp_path: Path) -> None:
    addresses = [f"folding://runs/{number}" for number in range(MOST_WATCHED + 1)]
    async with in_memory(tmp_path) as host:
        async with host.client.listen(resource_subscriptions=addresses[1:]):
            pass
        with pytest.raises(MCPError, match=f"At most {MOST_WATCHED} addresses"):
            async with host.client.listen(resource_subscriptions=addresses):
                pytest.fail("it listens to more")
