"""A sequence that was added is removed by whoever added it, unless a run needs its photos."""

from pathlib import Path

import pytest
from folding_server.frames.added_sequences import added_folder
from folding_server.mcp.context import ServerSettings
from hosts import in_memory, text_of
from photographed import photos
from pictures import noise, write_image
from test_adding_faults import names
from token_hosts import called_by, served_to

pytestmark = pytest.mark.anyio


@pytest.fixture
def films(tmp_path: Path) -> Path:
    """A folder that may be read, with photos of a hat."""
    for number in (1, 2):
        write_image(tmp_path / "films" / "hat" / f"{number}.png", noise(64, 48, number))
    return tmp_path / "films"


async def test_one_that_was_added_goes_and_its_photos_stay(tmp_path: Path, films: Path) -> None:
    async with in_memory(tmp_path / "data", allowed=films) as host:
        await host.call("add_sequence", paths="hat")
        told = await host.answer("remove_sequence", name="hat")
        assert await names(host) == []
        assert "'hat' was removed" in text_of(told)
        assert "only one that add_sequence made" in await host.refusal("remove_sequence", name="hat")
        assert (await host.call("add_sequence", paths="hat"))["outcome"] == "added"
    assert len(list((films / "hat").iterdir())) == 2


async def test_one_that_a_run_was_opened_on_is_kept(tmp_path: Path, films: Path) -> None:
    async with in_memory(tmp_path / "data", allowed=films) as host:
        await host.call("add_sequence", paths="hat")
        run_id = (await host.call("open_run", sequence="hat"))["run_id"]
        refused = await host.refusal("remove_sequence", name="hat")
        assert f"'hat' is kept, since run {run_id} was opened on it" in refused
        assert (await host.call("open_run", run_id=run_id))["frames"] == 2


async def test_a_damaged_one_can_be_removed(tmp_path: Path, films: Path) -> None:
    async with in_memory(tmp_path / "data", allowed=films) as host:
        await host.call("add_sequence", paths="hat")
        (folder,) = added_folder(tmp_path / "data", None).iterdir()
        (folder / "keyframes.json").write_text("{")
        await host.call("remove_sequence", name="hat")
        assert (await host.call("list_sequences"))["problems"] == []


@pytest.mark.parametrize("name", ["sailboat", "../added", "gone"])
async def test_no_other_can_be_removed(tmp_path: Path, films: Path, name: str) -> None:
    async with in_memory(tmp_path / "data", photos(), allowed=films) as host:
        await host.refusal("remove_sequence", name=name)
        assert await names(host) == ["sailboat"]


async def test_what_another_owner_added_is_not_there_to_be_removed(tmp_path: Path, films: Path) -> None:
    settings = ServerSettings(tmp_path / "data", allowed=(films,), shared=True)
    with served_to(settings, tmp_path, "ada", "bob") as url:
        async with called_by("ada", url) as ada, called_by("bob", url) as bob:
            await ada.call("add_sequence", paths="hat")
            assert "cannot be removed" in await bob.refusal("remove_sequence", name="hat")
            assert await names(ada) == ["hat"]


async def test_without_allowed_folders_it_is_not_offered(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        assert "remove_sequence" not in {tool.name for tool in (await host.client.list_tools()).tools}
