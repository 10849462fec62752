"""A film, or photos, named by path become a sequence that can be opened, corrected and reconstructed."""

import base64
import io
import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from folding_server.arrays import RgbImage
from folding_server.frames.added_sequences import added_folder
from folding_server.frames.image_files import decode
from folding_server.frames.sequences import Library
from folding_server.mcp.services.sequence_jobs import MOST_TILES, SHEET_SIDE
from hosts import Host, images_of, in_memory, text_of
from paths import EXAMPLES
from photographed import photos
from pictures import noise, write_image
from PIL import Image
from videos import KITE, SQUARE, TRIANGLE, Clip, Rest, Work, encode, write_clip

pytestmark = pytest.mark.anyio

SECONDS, RATE = 1.0, 15
"""How long each photo of the sailboat lies still in its film, and images a second."""


@pytest.fixture
def films(tmp_path: Path) -> Path:
    """A folder that may be read."""
    folder = tmp_path / "films"
    folder.mkdir()
    return folder


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Clip:
    """A film of two folds with a hand that comes and goes."""
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE), Work(TRIANGLE, KITE), Rest(KITE)]
    return write_clip(tmp_path_factory.mktemp("filmed") / "letter.mp4", shots)


@pytest.fixture
def letter(films: Path, filmed: Clip) -> Clip:
    """That film where it may be read."""
    return replace(filmed, path=Path(shutil.copy(filmed.path, films)))


def photo(seed: int) -> RgbImage:
    """A small photo of nothing."""
    return noise(64, 48, seed)


def sailboat_film(path: Path) -> None:
    """The photographed sailboat, each of its four photos still for a while."""
    shown = [decode(file) for file in sorted((photos() / "sailboat" / "frames").iterdir())]
    count = round(SECONDS * RATE)
    images = (shown[number // count] for number in range(count * len(shown)))
    encode(path, images, [number / RATE for number in range(count * len(shown))])


def rests_of(clip: Clip, answer: dict[str, Any]) -> list[int]:
    """The shot in which each keyframe of an answer lies."""
    images = [each["image"] for each in answer["keyframes"]]
    return [next(number for number, shot in enumerate(clip.shots) if image in shot) for image in images]


async def listed(host: Host) -> dict[str, int]:
    """The sequences that can be opened, with their numbers of frames."""
    found = await host.call("list_sequences")
    assert found["problems"] == []
    return {each["name"]: each["frames"] for each in found["sequences"]}


class TestFilms:
    @pytest.mark.slow
    async def test_the_keyframes_of_a_film_are_proposed_and_served_at_once_and_after_a_restart(
        self, tmp_path: Path, films: Path, letter: Clip
    ) -> None:
        before = letter.path.read_bytes()
        told: list[float] = []

        async def progress(done: float, _total: float | None, _message: str | None) -> None:
            told.append(done)

        async with in_memory(tmp_path / "data", photos(), allowed=films) as host:
            result = await host.client.call_tool(
                "add_sequence", {"paths": [str(letter.path)]}, progress_callback=progress
            )
            again = await host.call("add_sequence", paths="letter.mp4")
            assert await listed(host) == {"sailboat": 4, "letter": 3}
            assert (await host.call("open_run", sequence="letter"))["frames"] == 3
        async with in_memory(tmp_path / "data", photos()) as host:
            assert await listed(host) == {"sailboat": 4, "letter": 3}
        assert rests_of(letter, again) == [0, 2, 4]
        assert [each["seconds"] for each in again["keyframes"]] == sorted(
            each["seconds"] for each in again["keyframes"]
        )
        assert (again["outcome"], again["images"]) == ("unchanged", letter.shots[-1][-1] + 1)
        assert "'letter' was added: 3 keyframes" in text_of(result)  # type: ignore[arg-type]
        assert told == sorted(told)
        assert told[-1] == 100
        assert letter.path.read_bytes() == before
        assert [file.name for file in films.iterdir()] == ["letter.mp4"]

    @pytest.mark.slow
    async def test_the_contact_sheet_has_the_keyframes_in_red_and_can_be_made_small_or_left_out(
        self, tmp_path: Path, films: Path, letter: Clip
    ) -> None:
        async with in_memory(tmp_path / "data", allowed=films) as host:
            answers = {
                size: await host.answer("add_sequence", paths=[letter.path.name], images=size)
                for size in ("full", "small", "none")
            }
        (sheet,) = images_of(answers["full"])
        (small,) = images_of(answers["small"])
        assert images_of(answers["none"]) == []
        assert sheet.meta == {
            "foldingagent/subject": "contact sheet of the sequence letter",
            "foldingagent/role": "overview",
        }
        pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(sheet.data))).convert("RGB"), np.int16)
        assert SHEET_SIDE - 100 < max(pixels.shape) <= SHEET_SIDE
        red = (pixels[..., 0] > 140) & (pixels[..., 1:].max(-1) < 90)
        framed = np.convolve(red.mean(0) > 0.05, [1, -1])
        assert red.mean() > 0.001
        assert framed.any()
        assert Image.open(io.BytesIO(base64.b64decode(small.data))).width <= pixels.shape[1] // 2

    @pytest.mark.slow
    async def test_a_film_is_corrected_in_a_second_call_and_then_reconstructed(
        self, tmp_path: Path, films: Path
    ) -> None:
        sailboat_film(films / "boat.mp4")
        async with in_memory(tmp_path / "data", allowed=films) as host:
            wrong = await host.call("add_sequence", paths="boat.mp4", keyframes=[7, 8], front_color="#cfc8bc")
            assert (await listed(host))["boat"] == 2
            right = await host.call("add_sequence", paths=["boat.mp4"], keyframes="7, 22, 37, 52")
            await host.call("open_run", sequence="boat")
            await host.call("save_checkpoint", frame=1)
            proposed = await host.call("propose_actions", frame=2)
            assert proposed["proposals"][0]["actions"] == [{"action": "fold", "edge": [2, 4], "direction": 1}]
            await host.call("fold", edge=[2, 4], direction=1)
            compared = await host.call("compare_to_frame", frame=2, images="none")
        assert (wrong["outcome"], right["outcome"]) == ("added", "replaced")
        assert [each["image"] for each in right["keyframes"]] == [7, 22, 37, 52]
        assert right["front_color"] == "#cfc8bc"
        assert compared["verdict"] == "MATCH"

    @pytest.mark.slow
    async def test_a_call_that_is_cancelled_stops_soon_and_leaves_nothing(
        self, tmp_path: Path, films: Path
    ) -> None:
        write_clip(films / "long.mp4", [Rest(SQUARE, 40.0)])
        begun = anyio.Event()

        async def progress(_done: float, _total: float | None, _message: str | None) -> None:
            begun.set()

        making = tmp_path / "data" / "added" / ".making"
        async with in_memory(tmp_path / "data", allowed=films) as host, anyio.create_task_group() as tasks:
            call = {"paths": ["long.mp4"]}
            tasks.start_soon(lambda: host.client.call_tool("add_sequence", call, progress_callback=progress))
            with anyio.fail_after(60):
                await begun.wait()
            assert len(list(making.iterdir())) == 1
            tasks.cancel_scope.cancel()
            with anyio.CancelScope(shield=True):
                for _ in range(100):
                    if any(making.iterdir()):
                        await anyio.sleep(0.05)
                assert list(making.iterdir()) == []
                assert await listed(host) == {}


class TestPhotos:
    @pytest.fixture
    def folder(self, films: Path) -> Iterator[Path]:
        """Photos named as cameras name them, with what else lies in such folders."""
        folder = films / "crane photos"
        for number in (9, 10, 11):
            write_image(folder / f"IMG_{number}.{'png' if number == 10 else 'JPG'}", photo(number))
        (folder / "._IMG_9.JPG").write_bytes(b"what macOS leaves")
        (folder / "notes.txt").write_text("crane")
        before = {file: (file.read_bytes(), file.stat().st_mtime_ns) for file in folder.iterdir()}
        yield folder
        assert {file: (file.read_bytes(), file.stat().st_mtime_ns) for file in folder.iterdir()} == before

    async def test_a_folder_of_photos_becomes_a_sequence_in_the_order_of_their_numbers(
        self, tmp_path: Path, films: Path, folder: Path
    ) -> None:
        async with in_memory(tmp_path / "data", allowed=films) as host:
            added = await host.call("add_sequence", paths=[str(folder)])
            assert await listed(host) == {"crane photos": 3}
        assert [(each["frame"], each["image"], each["seconds"]) for each in added["keyframes"]] == [
            (1, 1, None),
            (2, 2, None),
            (3, 3, None),
        ]
        served = Library([added_folder(tmp_path / "data", None)]).open("crane photos")
        for frame, name in enumerate(("IMG_9.JPG", "IMG_10.png", "IMG_11.JPG"), start=1):
            assert np.abs(served.photo(frame).astype(int) - decode(folder / name)).mean() < 6

    async def test_photos_one_by_one_keep_their_order_and_some_can_be_left_out(
        self, tmp_path: Path, films: Path, folder: Path
    ) -> None:
        paths = [str(folder / name) for name in ("IMG_11.JPG", "IMG_9.JPG", "IMG_10.png")]
        async with in_memory(tmp_path / "data", allowed=films) as host:
            await host.call("add_sequence", paths=paths, name="swan")
            fewer = await host.call("add_sequence", paths=paths, name="swan", keyframes=[1, 3])
            assert await listed(host) == {"swan": 2}
        assert [each["image"] for each in fewer["keyframes"]] == [1, 3]
        served = Library([added_folder(tmp_path / "data", None)]).open("swan")
        assert np.abs(served.photo(1).astype(int) - decode(folder / "IMG_11.JPG")).mean() < 6
        assert served.between(2) == [2]

    async def test_many_photos_make_a_sheet_that_fits(self, tmp_path: Path, films: Path) -> None:
        for number in range(MOST_TILES + 30):
            write_image(films / "many" / f"{number}.jpg", photo(number % 7))
        async with in_memory(tmp_path / "data", allowed=films) as host:
            answer = await host.answer("add_sequence", paths="many")
        assert len(images_of(answer)) == 1
        assert f"{MOST_TILES + 30} keyframes" in text_of(answer)


class TestNames:
    @pytest.mark.slow
    @pytest.mark.usefixtures("letter")
    async def test_runs_keep_the_sequence_that_they_were_opened_on(self, tmp_path: Path, films: Path) -> None:
        async with in_memory(tmp_path / "data", allowed=films) as host:
            await host.call("add_sequence", paths="letter.mp4")
            run_id = (await host.call("open_run", sequence="letter"))["run_id"]
            again = await host.call("add_sequence", paths="letter.mp4")
            corrected = await host.answer("add_sequence", paths="letter.mp4", keyframes=[3, 60])
            once_more = await host.call("add_sequence", paths="letter.mp4", keyframes=[3, 61])
            named = await host.call("add_sequence", paths="letter.mp4", name="letter", keyframes=[3, 62])
            assert await listed(host) == {"letter": 3, "letter 2": 2}
            assert (await host.call("open_run", run_id=run_id))["frames"] == 3
        assert again["outcome"] == "unchanged"
        assert "'letter 2' was added" in text_of(corrected)
        assert "There is a 'letter' already that is not to be changed" in text_of(corrected)
        assert [(each["name"], each["outcome"]) for each in (once_more, named)] == [
            ("letter 2", "replaced")
        ] * 2

    @pytest.mark.slow
    @pytest.mark.usefixtures("letter")
    async def test_a_name_that_is_taken_is_refused_where_it_was_chosen_and_numbered_where_not(
        self, tmp_path: Path, films: Path
    ) -> None:
        for folder in ("sailboat", "more/sailboat"):
            write_image(films / folder / "1.jpg", photo(len(folder)))
        async with in_memory(tmp_path / "data", photos(), allowed=films) as host:
            first = await host.call("add_sequence", paths="sailboat")
            second = await host.call("add_sequence", paths="more/sailboat")
            assert "There is a sequence 'sailboat' already" in (
                await host.refusal("add_sequence", paths="sailboat", name="sailboat")
            )
            assert "There is a sequence 'sailboat 2' already" in (
                await host.refusal("add_sequence", paths="letter.mp4", name="sailboat 2")
            )
            assert await listed(host) == {"sailboat": 4, "sailboat 2": 1, "sailboat 3": 1}
        assert [first["name"], second["name"]] == ["sailboat 2", "sailboat 3"]

    async def test_one_of_the_servers_own_folders_hides_an_added_one_of_its_name(
        self, tmp_path: Path, films: Path
    ) -> None:
        write_image(films / "sailboat" / "1.jpg", photo(1))
        async with in_memory(tmp_path / "data", allowed=films) as host:
            await host.call("add_sequence", paths="sailboat")
        async with in_memory(tmp_path / "data", photos(), allowed=films) as host:
            found = await host.call("list_sequences")
            assert (await host.call("open_run", sequence="sailboat"))["frames"] == 4
        assert [each["frames"] for each in found["sequences"]] == [4]
        assert "'sailboat' that was added is hidden" in found["problems"][0]
        assert str(tmp_path) not in found["problems"][0]

    @pytest.mark.parametrize("name", ["../escape", "..", "a/b", "a\\b", "x" * 201, "\0", "tab\there"])
    async def test_a_name_that_is_a_path_or_no_name_is_refused(
        self, tmp_path: Path, films: Path, name: str
    ) -> None:
        write_image(films / "1.jpg", photo(1))
        async with in_memory(tmp_path / "data", allowed=films) as host:
            assert "sequence name" in await host.refusal("add_sequence", paths="1.jpg", name=name)
        assert not (tmp_path / "data" / "added").exists()

    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["CON", "héron 折り紙", "...", "a.b", "UP", "up"])
    async def test_any_other_name_is_a_name(self, tmp_path: Path, films: Path, name: str) -> None:
        write_image(films / "1.jpg", photo(1))
        async with in_memory(tmp_path / "data", allowed=films) as host:
            await host.call("add_sequence", paths="1.jpg", name=name)
            assert await listed(host) == {name: 1}
        (folder,) = added_folder(tmp_path / "data", None).iterdir()
        assert folder.name.isascii()
        assert folder.name.replace("-", "").isalnum()


class TestRefusals:
    @pytest.mark.parametrize(
        ("arguments", "named"),
        [
            ({"paths": []}, "no path is given"),
            ({"paths": "/etc/passwd"}, "may not be read: only files in"),
            ({"paths": ["letter.mp4", "../data/runs.sqlite3"]}, "may not be read"),
            ({"paths": "gone.mp4"}, "there is no file or folder 'gone.mp4'"),
            ({"paths": "text.mp4"}, "text.mp4 cannot be read as a video"),
            ({"paths": "text.jpg"}, "text.jpg is a text file"),
            ({"paths": ["letter.mp4", "letter.mp4"]}, "'letter.mp4' is no photo"),
            ({"paths": ["empty", "text.jpg"]}, "'empty' is a folder among other paths"),
            ({"paths": "empty"}, "holds no photos as JPEG or PNG"),
            ({"paths": "cup"}, "is a sequence already"),
            ({"paths": "pipe"}, "'pipe' is no ordinary file"),
            ({"paths": "linked"}, "'out.jpg' leads out of"),
            ({"paths": "letter.mp4", "keyframes": [5, 5]}, "keyframes must increase"),
            ({"paths": "letter.mp4", "keyframes": [5, 9999]}, "image 9999 is not in letter.mp4"),
            ({"paths": "letter.mp4", "keyframes": list(range(0, 70000, 3))[:501]}, "more than the 500"),
            ({"paths": "letter.mp4", "front_color": "no colour"}, "no colour"),
            ({"paths": 7}, "must be the path of a film"),
        ],
    )
    @pytest.mark.usefixtures("letter")
    async def test_a_mistake_is_one_sentence_and_nothing_is_kept(
        self, tmp_path: Path, films: Path, arguments: dict[str, Any], named: str
    ) -> None:
        (films / "text.mp4").write_text("no film")
        (films / "text.jpg").write_text("no photo")
        (films / "empty").mkdir()
        (films / "linked").mkdir()
        (films / "linked" / "out.jpg").symlink_to(EXAMPLES / "cup" / "frames" / "000001.jpg")
        write_image(films / "cup" / "1.jpg", photo(1))
        (films / "cup" / "keyframes.json").write_text("{}")
        os.mkfifo(films / "pipe")
        async with in_memory(tmp_path / "data", allowed=films) as host:
            said = await host.refusal("add_sequence", **arguments)
            assert await listed(host) == {}
        assert named.lower() in said.lower()
        assert str(tmp_path) not in said.replace(str(films), "")

    async def test_without_allowed_folders_it_is_not_offered_and_hosts_are_told_how_to_have_it(
        self, tmp_path: Path, films: Path
    ) -> None:
        async with in_memory(tmp_path / "data") as host:
            offered = {tool.name for tool in (await host.client.list_tools()).tools}
            refused = await host.refusal("add_sequence", paths="letter.mp4")
            told = text_of(await host.answer("list_sequences"))
        assert "add_sequence" not in offered
        assert "start it with --allow" in refused
        assert "start it with --allow" in told
        async with in_memory(tmp_path / "data", allowed=films, read_only=True) as host:
            assert "There is no tool 'add_sequence'" in await host.refusal("add_sequence", paths="x")
        async with in_memory(tmp_path / "data", allowed=films) as host:
            assert "add_sequence" in {tool.name for tool in (await host.client.list_tools()).tools}
            assert "--allow" not in text_of(await host.answer("list_sequences"))
