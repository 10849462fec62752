"""Bad input through the protocol: each mistake gets one plain sentence, and the paper stays as it was."""

from pathlib import Path
from typing import Any

import pytest
from hosts import Host, in_memory
from mcp import MCPError
from photographed import photos
from pictures import quadrants, write_image, write_manifest, write_sequence_folder

pytestmark = pytest.mark.anyio


async def refused(host: Host, tool: str, **arguments: Any) -> str:
    """The sentence that refuses a call, after which the state is what it was."""
    before = await host.call("get_current_state")
    sentence = await host.refusal(tool, **arguments)
    assert await host.call("get_current_state") == before
    return sentence


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tool", "arguments", "named"),
    [
        ("fold", {"edge": [1, 77], "direction": 1}, ["77", "1 to 4"]),
        ("fold", {"edge": [1, 3], "direction": 0}, ["direction 0", "1", "-1"]),
        ("fold", {"edge": [2, 2], "direction": 1}, ["2 and 2", "different"]),
        ("fold", {"edge": [1], "direction": 1}, ["edge [1]", "two vertex ids"]),
        ("fold", {"edge": [1, 2, 3], "direction": 1}, ["edge [1, 2, 3]", "two vertex ids"]),
        ("fold", {"edge": "the diagonal", "direction": 1}, ["the diagonal", "two vertex ids"]),
        ("fold", {"edge": [1, 3]}, ["fold needs direction", "-1"]),
        ("fold", {"edge": None, "direction": 1}, ["edge null", "two vertex ids"]),
        ("add_vertex", {"edge": [1, 2], "position": 1.5}, ["position 1.5", "between 0 and 1"]),
        ("add_vertex", {"edge": [1, 2], "position": 0}, ["0", "vertex 1"]),
        ("add_vertex", {"edge": [1, 3], "position": 0.5}, ["1 and 3"]),
        ("add_vertex", {"edge": [1, 2], "position": "half"}, ['position "half"', "fraction"]),
        ("rotate", {"angle": "a bit"}, ['angle "a bit"', "degrees"]),
        ("rotate", {"angle": "inf"}, ["inf", "degrees"]),
        ("flip", {"axis": "z"}, ['axis "z"', "y=-x"]),
        ("unfold", {}, ["fold"]),
        ("undo", {}, ["undo"]),
        ("fold", {"edge": [1, 3], "angle": 90}, ["'angle'", "edge, direction, run_id"]),
        ("rotate", {"angle": 1e308}, ["angle 1e+308", "-360 to 360"]),
        ("crumple", {}, ["'crumple'", "list_sequences"]),
        ("view_frame", {"frame": 99}, ["99", "4"]),
        ("view_frame", {"frame": 0}, ["frame 0", "from 1"]),
        ("view_frame", {"frame": "last"}, ['frame "last"', "from 1"]),
        ("observe_movement", {"frame": 1}, ["frame 1", "2"]),
        ("save_checkpoint", {"frame": 99}, ["99", "1 to 4"]),
        ("save_checkpoint", {"frame": 2, "notes": "n" * 20_000}, ["20000", "10000"]),
        ("restore_checkpoint", {"frame": 3}, ["3", "saved frames: 1"]),
        ("get_checkpoint_state", {"frame": 3}, ["3", "saved frames: 1"]),
        ("list_attempts", {"frame": 99}, ["99", "4"]),
        ("commit_attempt", {"frame": 2, "attempt": 1}, ["no attempt at frame 2"]),
        ("critic_grid", {"frame": 4}, ["Frame 3 has no checkpoint"]),
        ("compare_to_frame", {"frame": 99}, ["99", "4"]),
        ("compare_to_frame", {"frame": 2, "attempt": 7}, ["no attempt at frame 2"]),
        ("compare_to_frame", {"frame": 2, "attempt": 0}, ["attempt 0", "from 1"]),
        ("propose_actions", {"frame": 4}, ["frame 4", "frame 3 saved first"]),
        ("propose_actions", {"frame": 2, "count": 0}, ["count 0", "1 to 10"]),
        ("export_state", {"format": "zip"}, ['format "zip"', "obj"]),
        ("open_run", {"sequence": "../secrets"}, ["../secrets", "path"]),
        ("open_run", {"sequence": "nothing like it"}, ["nothing like it", "sailboat"]),
        ("open_run", {"run_id": "20260101-000000-aaaaaaaaaa"}, ["20260101-000000-aaaaaaaaaa", "data folder"]),
        ("get_run", {"run_id": "../../etc/passwd"}, ["../../etc/passwd", "open_run"]),
        ("list_runs", {"before": "x\udfffy"}, ["udfff", "open_run"]),
        ("open_run", {"run_id": "x\udfffy"}, ["udfff", "open_run"]),
    ],
)
async def test_a_mistake_is_answered_by_one_sentence_that_helps(
    tmp_path: Path, tool: str, arguments: dict[str, Any], named: list[str]
) -> None:
    async with in_memory(tmp_path, photos()) as host:
        await host.call("open_run", sequence="sailboat")
        await host.call("save_checkpoint", frame=1)
        sentence = await refused(host, tool, **arguments)
    assert all(part in sentence for part in named), sentence
    assert sentence[0].isupper(), sentence
    assert sentence.endswith((".", "?", "!")), sentence


async def test_a_run_of_another_data_folder_is_unknown(tmp_path: Path) -> None:
    async with in_memory(tmp_path / "mine") as host:
        run_id = (await host.call("open_run"))["run_id"]
    async with in_memory(tmp_path / "yours") as host:
        sentence = await host.refusal("open_run", run_id=run_id)
    assert run_id in sentence


async def test_without_an_open_run_a_call_says_to_open_one(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        sentence = await host.refusal("fold", edge=[1, 3], direction=1)
    assert "open_run" in sentence


async def test_a_shared_server_wants_every_call_to_name_its_run(tmp_path: Path) -> None:
    async with in_memory(tmp_path, shared=True) as host:
        await host.call("open_run")
        sentence = await host.refusal("fold", edge=[1, 3], direction=1)
    assert "run_id" in sentence


async def test_a_run_is_not_resumed_as_another_sequence(tmp_path: Path) -> None:
    async with in_memory(tmp_path, photos()) as host:
        run_id = (await host.call("open_run", sequence="sailboat"))["run_id"]
        sentence = await host.refusal("open_run", run_id=run_id, sequence="cat")
    assert "'sailboat'" in sentence
    assert "'cat'" in sentence


async def test_a_run_whose_photos_have_changed_is_not_resumed(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "photos" / "clip", [1, 2])
    async with in_memory(tmp_path / "data", folder.parent) as host:
        run_id = (await host.call("open_run", sequence="clip"))["run_id"]
    write_image(folder / "frames" / "000002.png")
    async with in_memory(tmp_path / "data", folder.parent) as host:
        sentence = await host.refusal("open_run", run_id=run_id)
    assert "changed" in sentence


async def test_photos_are_refused_to_a_free_fold(tmp_path: Path) -> None:
    async with in_memory(tmp_path, photos()) as host:
        await host.call("open_run")
        sentences = [
            await host.refusal(tool, **arguments)
            for tool, arguments in {
                "view_frame": {"frame": 1},
                "compare_to_frame": {"frame": 1},
                "generate_checkpoint_overview": {},
                "list_attempts": {"frame": 2},
            }.items()
        ]
    assert all("free fold" in sentence for sentence in sentences)


class TestBrokenSequences:
    """Folders with something wrong, opened by name."""

    async def opening(self, folder: Path, data: Path) -> str:
        """What opening a run on the folder's sequence is answered with."""
        async with in_memory(data, folder.parent) as host:
            return await host.refusal("open_run", sequence=folder.name)

    async def test_manifest_that_is_not_json(self, tmp_path: Path) -> None:
        folder = write_sequence_folder(tmp_path / "photos" / "clip", [1, 2])
        (folder / "keyframes.json").write_text("keyframes: 1, 2")
        assert "not JSON" in await self.opening(folder, tmp_path / "data")

    async def test_missing_image(self, tmp_path: Path) -> None:
        folder = write_sequence_folder(tmp_path / "photos" / "clip", [1, 2])
        (folder / "frames" / "000002.png").unlink()
        assert "2" in await self.opening(folder, tmp_path / "data")

    @pytest.mark.parametrize(
        ("content", "named"), [("text", "text"), ("tiny", "1x1"), ("cut", "cut off"), ("empty", "empty")]
    )
    async def test_image_that_is_no_usable_photo(self, tmp_path: Path, content: str, named: str) -> None:
        folder = tmp_path / "photos" / "clip"
        write_manifest(folder, keyframes=[1, 2])
        first = write_image(folder / "frames" / "000001.jpg")
        second = folder / "frames" / "000002.jpg"
        match content:
            case "text":
                second.write_text("this is no picture")
            case "tiny":
                write_image(second, first_pixel())
            case "cut":
                second.write_bytes(first.read_bytes()[:400])
            case "empty":
                second.write_bytes(b"")
        async with in_memory(tmp_path / "data", folder.parent) as host:
            await host.call("open_run", sequence="clip")
            await host.call("view_frame", frame=1)
            sentence = await host.refusal("view_frame", frame=2)
        assert named in sentence

    async def test_photos_without_a_sheet_cannot_be_compared_or_explained(self, tmp_path: Path) -> None:
        folder = write_sequence_folder(tmp_path / "photos" / "grey", [1, 2])
        async with in_memory(tmp_path / "data", folder.parent) as host:
            await host.call("open_run", sequence="grey")
            await host.call("save_checkpoint", frame=1)
            for tool in ("compare_to_frame", "propose_actions"):
                assert "rame 1" in await host.refusal(tool, frame=2)


def first_pixel() -> Any:
    """A picture of one pixel."""
    return quadrants()[:1, :1]


class TestResources:
    """Refusals of resource reads, which are protocol errors."""

    @pytest.mark.parametrize(
        ("uri", "named"),
        [
            ("folding://runs/20260101-000000-aaaaaaaaaa", "no run"),
            ("folding://sequences/sailboat/frames/99", "99"),
            ("folding://sequences/nothing/frames/1", "nothing"),
            ("folding://sequences/sailboat/frames/last", 'frame "last"'),
            ("folding://elsewhere", "elsewhere"),
        ],
    )
    async def test_what_is_not_there_is_invalid_params_with_the_reason(
        self, tmp_path: Path, uri: str, named: str
    ) -> None:
        async with in_memory(tmp_path, photos()) as host:
            with pytest.raises(MCPError) as error:
                await host.client.read_resource(uri)
        assert error.value.code == -32602
        assert named in error.value.message
        assert "\n" not in error.value.message


class TestPrompts:
    """Refusals of prompts, which are protocol errors."""

    async def test_an_unknown_prompt_and_an_unknown_argument_are_named(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            with pytest.raises(MCPError, match="'crumple'; the prompts are reconstruct"):
                await host.client.get_prompt("crumple")
            with pytest.raises(MCPError, match="'colour'; it takes sequence"):
                await host.client.get_prompt("reconstruct", {"colour": "red"})
