"""Adding sequences where disks are full and servers die, for owners of tokens, and over real stdio."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from folding_server.frames.added_sequences import STALE_SECONDS, added_folder
from folding_server.frames.sequences import Library
from folding_server.mcp.context import ServerSettings
from folding_server.store.limits import OwnerLimits
from hosts import Host, images_of, in_memory, server, stdio, text_of
from mcp import Client, MCPError
from photographed import photos
from pictures import noise, write_image
from token_hosts import called_by, served_to
from videos import SQUARE, TRIANGLE, Rest, Work, write_clip

pytestmark = pytest.mark.anyio
resource = pytest.importorskip("resource", reason="limits of processes are POSIX's")

ADDING = """
import sys
from pathlib import Path
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.services.sequence_adding import SequenceWish, add_to_library
from folding_server.mcp.services.sequence_jobs import make_sequence
import anyio

data, films = Path(sys.argv[1]), Path(sys.argv[2])

def announce(doing, part):
    print(part, flush=True)
    if part > 0.5:
        input()

async def add():
    async def make(work, folder):
        return make_sequence(announce, work, folder)
    await add_to_library(app, SequenceWish(("hat",), keyframes=(2, 3)), make, shown=False)

with AppContext(ServerSettings(data, allowed=(films,))) as app:
    anyio.run(add)
"""
"""Adds the photos of a folder, and waits for good once half of them are written."""


@pytest.fixture
def films(tmp_path: Path) -> Path:
    """A folder that may be read, with photos of a hat."""
    folder = tmp_path / "films"
    for number in range(1, 5):
        write_image(folder / "hat" / f"{number}.png", noise(120, 90, number))
    return folder


def images_below(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.jpg"))


def kept(data: Path) -> Library:
    """The sequences added to a data folder, as another server finds them."""
    return Library([], added_folder(data, None))


@contextmanager
def limited_files(size: int) -> Iterator[None]:
    """No file that this process writes may be larger, which it is told as by a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def killed_in_the_middle(data: Path, films: Path) -> None:
    """Have a process add the hat and kill it while it writes."""
    command = [sys.executable, "-c", ADDING, str(data), str(films)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        while float(process.stdout.readline()) <= 0.5:
            pass
        process.send_signal(signal.SIGKILL)


@pytest.mark.skipif(os.name != "posix", reason="limits of processes are POSIX's")
class TestFaults:
    @pytest.mark.slow
    async def test_a_kill_while_it_is_written_leaves_no_half_sequence(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        killed_in_the_middle(data, films)
        (left,) = (data / "added" / ".making").iterdir()
        assert images_below(left)
        assert kept(data).sequences() == kept(data).problems() == []
        async with in_memory(data, allowed=films) as host:
            assert (await host.call("list_sequences"))["sequences"] == []
            assert (await host.call("add_sequence", paths="hat"))["frames"] == 4
            assert left.exists()
            old = time.time() - STALE_SECONDS - 60
            os.utime(left, (old, old))
            await host.call("add_sequence", paths="hat", keyframes=[1, 2])
        assert not left.exists()

    async def test_a_kill_while_a_correction_is_written_leaves_the_sequence_as_it_was(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        async with in_memory(data, allowed=films) as host:
            await host.call("add_sequence", paths="hat")
        before = kept(data).open("hat").fingerprint()
        killed_in_the_middle(data, films)
        assert kept(data).open("hat").fingerprint() == before

    async def test_a_correction_whose_images_came_but_not_its_manifest_changes_nothing_and_goes_with_the_next(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        async with in_memory(data, allowed=films) as host:
            await host.call("add_sequence", paths="hat")
            before = kept(data).open("hat")
            (images,) = (path for path in before.folder.iterdir() if path.is_dir())
            shutil.copytree(images, before.folder / "frames-of-a-dead-server")
            assert kept(data).open("hat").fingerprint() == before.fingerprint()
            await host.call("add_sequence", paths="hat", keyframes=[1, 4])
        after = kept(data).open("hat")
        assert after.keyframes == (1, 4)
        assert len([path for path in after.folder.iterdir() if path.is_dir()]) == 1

    async def test_a_full_disk_leaves_everything_as_it_was_and_says_so(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        async with in_memory(data, allowed=films) as host:
            await host.call("add_sequence", paths="hat")
            before = kept(data).open("hat").fingerprint()
            with limited_files(20_000):
                refused = await host.refusal("add_sequence", paths="hat", keyframes=[1, 2])
                other = await host.refusal("add_sequence", paths="hat", name="another")
            assert [each["name"] for each in (await host.call("list_sequences"))["sequences"]] == ["hat"]
        assert refused == other
        assert "could not be kept (File too large), and nothing was changed: make room" in refused
        assert str(tmp_path) not in refused
        assert kept(data).open("hat").fingerprint() == before
        assert list((data / "added" / ".making").iterdir()) == []


class TestOwners:
    @pytest.mark.slow
    async def test_a_sequence_is_there_for_the_owner_who_added_it_alone(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        settings = ServerSettings(data, sequences=(photos(),), allowed=(films,), shared=True)
        address = "folding://sequences/hat/frames/1"
        with served_to(settings, tmp_path, "ada", "Ada", "bob") as url:
            async with called_by("ada", url) as ada, called_by("bob", url) as bob:
                added = await ada.answer("add_sequence", paths="hat")
                assert "'hat' was added" in text_of(added)
                assert str(tmp_path) not in text_of(added)
                assert await names(ada) == ["hat", "sailboat"]
                assert await names(bob) == ["sailboat"]
                assert (await ada.client.read_resource(address)).contents
                with pytest.raises(MCPError, match="There is no sequence 'hat': there are sailboat"):
                    await bob.client.read_resource(address)
                assert "there is no sequence 'hat'" in (await bob.refusal("open_run", sequence="hat")).lower()
                await ada.call("open_run", sequence="hat")
                his = await bob.call("add_sequence", paths="hat", keyframes=[1, 2])
                assert (his["name"], his["outcome"]) == ("hat", "added")
                assert (await ada.call("open_run", sequence="hat"))["frames"] == 4
                refused = await bob.refusal("add_sequence", paths=f"{data}/added")
                assert "only files in 'films' may; ask whoever runs the server" in refused
            async with called_by("Ada", url) as other:
                assert await names(other) == ["sailboat"]
        async with in_memory(data, photos()) as host:
            assert await names(host) == ["sailboat"]

    async def test_what_owners_added_is_not_read_again_as_files(self, tmp_path: Path, films: Path) -> None:
        data = films / "data"
        settings = ServerSettings(data, allowed=(films,), shared=True)
        with served_to(settings, tmp_path, "ada", "bob") as url:
            async with called_by("ada", url) as ada, called_by("bob", url) as bob:
                await ada.call("add_sequence", paths="hat")
                (photo, *_) = images_below(added_folder(data, "ada"))
                for path in (photo, photo.parent, photo.relative_to(films)):
                    assert "may not be read" in await bob.refusal("add_sequence", paths=str(path))

    async def test_an_owner_may_not_keep_more_than_is_allowed(self, tmp_path: Path, films: Path) -> None:
        limits = OwnerLimits(bytes=30_000, vision_seconds=60)
        settings = ServerSettings(tmp_path / "data", allowed=(films,), shared=True, limits=limits)
        with served_to(settings, tmp_path, "ada", "bob") as url:
            async with called_by("ada", url) as ada, called_by("bob", url) as bob:
                await ada.call("add_sequence", paths="hat")
                refused = await ada.refusal("add_sequence", paths="hat", name="another")
                await bob.call("add_sequence", paths="hat")
        assert "the sequences that ada added take up" in refused.lower()
        assert "at most 0.03 MB" in refused

    async def test_whoever_reaches_a_run_without_a_token_sees_the_photos_that_its_owner_added(
        self, tmp_path: Path, films: Path
    ) -> None:
        data = tmp_path / "data"
        with served_to(ServerSettings(data, allowed=(films,), shared=True), tmp_path, "ada") as url:
            async with called_by("ada", url) as ada:
                await ada.call("add_sequence", paths="hat")
                run_id = (await ada.call("open_run", sequence="hat"))["run_id"]
        async with in_memory(data) as host:
            assert (await host.call("open_run", run_id=run_id))["frames"] == 4
            assert len(images_of(await host.answer("view_frame", frame=1))) == 1
            assert await names(host) == []


async def names(host: Host) -> list[str]:
    """The sequences that a host is shown."""
    found = await host.call("list_sequences")
    return [each["name"] for each in found["sequences"]]


@pytest.mark.slow
async def test_over_stdio_a_film_below_an_allowed_folder_becomes_a_sequence(
    tmp_path: Path, films: Path
) -> None:
    clip = write_clip(films / "letter.mp4", [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE)])
    command = stdio(tmp_path / "data")
    command.args += ["--allow", str(films)]
    async with Client(command) as client:
        host = Host(client)
        answer = await host.answer("add_sequence", paths=[str(clip.path)])
        assert len(images_of(answer)) == 1
        assert "'letter' was added: 2 keyframes" in text_of(answer)
        assert "may not be read" in await host.refusal("add_sequence", paths="/etc/hostname")
        assert (await host.call("open_run", sequence="letter"))["frames"] == 2


WITHOUT_PYAV = """
import sys
sys.modules["av"] = None
from pathlib import Path
from folding_server.errors import FoldingError
from folding_server.mcp.context import AppContext, ServerSettings
from folding_server.mcp.services.sequence_adding import SequenceWish, add_to_library
from folding_server.mcp.services.sequence_jobs import make_sequence
import anyio

async def make(work, folder):
    return make_sequence(lambda doing, part: None, work, folder)

async def add(path):
    return await add_to_library(app, SequenceWish((path,)), make, shown=True)

with AppContext(ServerSettings(Path(sys.argv[1]), allowed=(Path(sys.argv[2]),))) as app:
    print(anyio.run(add, "hat").name)
    try:
        anyio.run(add, "film.mp4")
    except FoldingError as refusal:
        print(refusal)
"""


@pytest.mark.slow
def test_photos_need_no_pyav_and_a_film_is_refused_with_what_to_install(tmp_path: Path, films: Path) -> None:
    (films / "film.mp4").write_bytes(b"film")
    command = [sys.executable, "-c", WITHOUT_PYAV, str(tmp_path / "data"), str(films)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    added, refused = done.stdout.splitlines()
    assert added == "hat"
    assert "pip install 'foldingagent-mcp[video]'" in refused


@pytest.mark.slow
async def test_the_view_shows_a_run_of_an_added_sequence_with_its_photos(tmp_path: Path, films: Path) -> None:
    async with in_memory(tmp_path / "data", allowed=films) as host:
        await host.call("add_sequence", paths="hat")
        run_id = (await host.call("open_run", sequence="hat"))["run_id"]
        await host.call("save_checkpoint", frame=1)
    page = tmp_path / "run.html"
    written = server("view", run_id, "--data", tmp_path / "data", "-o", page)
    assert (written.returncode, written.stderr) == (0, "")
    assert page.read_text(encoding="utf-8").count("data:image/jpeg;base64,") == 1
