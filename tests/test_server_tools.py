"""The tools as a host uses them, through the protocol in memory."""

import base64
import json
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import pytest
from hosts import Host, data_of, images_of, in_memory, text_of
from mcp.types import CallToolResult
from photographed import photos
from pictures import noise, write_image, write_manifest, write_sequence_folder
from reference_data import REFERENCE
from shapely import Polygon, box

pytestmark = pytest.mark.anyio

BASE64_LIMIT = 800_000


@pytest.fixture(
    params=["photographed", pytest.param("taken", marks=pytest.mark.reference("photos/sailboat"))]
)
def boats(request: pytest.FixtureRequest) -> Path:
    """A folder with photos of a sailboat: painted ones, and real ones."""
    return photos() if request.param == "photographed" else REFERENCE / "photos"


async def a_saved_fold(host: Host) -> None:
    """A run on the sailboat with frame 1 saved and one fold done."""
    await host.call("open_run", sequence="sailboat")
    await host.call("save_checkpoint", frame=1)
    await host.call("fold", edge=[1, 3], direction=1)


def shown_in(result: CallToolResult) -> list[tuple[str, int | None, str]]:
    """What the images of an answer say that they show."""
    metas = [image.meta or {} for image in images_of(result)]
    return [
        (meta["foldingagent/subject"], meta.get("foldingagent/frame"), meta["foldingagent/role"])
        for meta in metas
    ]


async def test_every_picture_says_what_it_shows(tmp_path: Path) -> None:
    async with in_memory(tmp_path, photos()) as host:
        await a_saved_fold(host)
        calls: dict[str, dict[str, Any]] = {
            "view_frame": {"frame": 2},
            "render_current": {},
            "list_attempts": {"frame": 2},
            "generate_checkpoint_overview": {},
            "export_state": {"format": "png"},
        }
        shown = {tool: shown_in(await host.answer(tool, **given)) for tool, given in calls.items()}
        overlay = shown_in(await host.answer("compare_to_frame", frame=2, attempt=1))
    assert shown == {
        "view_frame": [("photo of frame 2", 2, "photo")],
        "render_current": [("diagram of the current state", None, "diagram")],
        "list_attempts": [("diagram of attempt 1", 2, "diagram")],
        "generate_checkpoint_overview": [("overview of the checkpoints", None, "overview")],
        "export_state": [("exported diagram of the current state", None, "diagram")],
    }
    assert overlay == [("overlay of attempt 1 on the photo of frame 2", 2, "overlay")]


class TestRuns:
    async def test_sequences_are_listed_with_frames_and_colours(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            listed = await host.call("list_sequences")
        manifest = json.loads((photos() / "sailboat" / "keyframes.json").read_text())
        colours = {key: manifest[key] for key in ("front_color", "back_color")}
        assert {"name": "sailboat", "frames": 4, **colours} in listed["sequences"]

    async def test_a_broken_sequence_is_named_beside_the_good_ones(self, tmp_path: Path) -> None:
        write_sequence_folder(tmp_path / "photos" / "good", [1, 2])
        broken = tmp_path / "photos" / "broken"
        broken.mkdir()
        (broken / "keyframes.json").write_text("not json")
        async with in_memory(tmp_path / "data", tmp_path / "photos") as host:
            listed = await host.call("list_sequences")
        assert [each["name"] for each in listed["sequences"]] == ["good"]
        assert len(listed["problems"]) == 1
        assert "broken" in listed["problems"][0]

    async def test_a_new_run_waits_for_frame_1(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            opened = await host.call("open_run", sequence="sailboat")
            assert await host.call("get_run", run_id=opened["run_id"]) == opened
        assert opened["frames"] == 4
        assert opened["saved"] == []
        assert opened["next_frame"] == 1
        assert opened["budget"] == 5
        assert not opened["complete"]

    async def test_a_free_fold_needs_no_photos_and_has_no_attempts(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            opened = await host.call("open_run")
            folded = await host.call("fold", edge=[1, 3], direction=1)
        assert opened["sequence"] is None
        assert opened["frames"] == 0
        assert folded["frame"] is None
        assert folded["attempt"] is None

    async def test_a_run_is_taken_up_again_by_another_process(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            left = await host.call("get_run")
            state = await host.call("get_current_state")
        async with in_memory(tmp_path, photos()) as host:
            assert await host.call("open_run", run_id=left["run_id"]) == left
            assert await host.call("get_current_state") == state

    async def test_calls_without_run_id_mean_the_run_opened_last(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            first = await host.call("open_run")
            second = await host.call("open_run")
            await host.call("flip", axis="x")
            assert (await host.call("get_run"))["run_id"] == second["run_id"]
            assert (await host.call("get_run", run_id=first["run_id"]))["pending"] == []

    async def test_two_runs_do_not_touch_each_other(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, shared=True) as host:
            runs = [(await host.call("open_run"))["run_id"] for _ in range(2)]
            await host.call("fold", edge=[1, 3], direction=1, run_id=runs[0])
            await host.call("fold", edge=[2, 4], direction=-1, run_id=runs[1])
            states = [(await host.call("get_current_state", run_id=run))["state"] for run in runs]
        assert states[0] != states[1]


class TestActions:
    async def test_a_fold_answers_what_is_new_what_moved_and_the_state(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            vertex = await host.call("add_vertex", edge=[3, 1], position=0.25)
            folded = await host.call("fold", edge=[5, 4], direction=-1)
        assert vertex["new_vertices"] == [5]
        assert vertex["moved_faces"] == []
        assert vertex["state"]["vertices"]["5"] == [0.75, 0.25]
        assert folded["frame"] == 2
        assert folded["attempt"] == 1
        assert folded["new_faces"]
        assert set(folded["moved_faces"]) < {int(face) for face in folded["state"]["faces"]}

    async def test_every_primitive_can_be_called_and_undone(self, tmp_path: Path) -> None:
        calls: list[tuple[str, dict[str, Any]]] = [
            ("add_vertex", {"edge": [1, 2], "position": 0.5}),
            ("fold", {"edge": [5, 4], "direction": 1}),
            ("rotate", {"angle": 45}),
            ("flip", {"axis": "y=-x"}),
            ("unfold", {}),
        ]
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            states = [(await host.call("get_current_state"))["state"]]
            for tool, arguments in calls:
                states.append((await host.call(tool, **arguments))["state"])
            for expected in reversed(states[:-1]):
                assert (await host.call("undo"))["state"] == expected

    async def test_calls_that_come_at_once_take_turns_and_none_is_lost(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            async with anyio.create_task_group() as group:
                for angle in range(1, 13):
                    group.start_soon(partial(host.call, "rotate", angle=angle))
            pending = (await host.call("get_run"))["pending"]
        assert sorted(action["angle"] for action in pending) == list(range(1, 13))

    async def test_numbers_that_models_send_as_text_are_understood(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            folded = await host.call("fold", edge=["1", "3"], direction="-1")
        assert folded["moved_faces"] != []

    async def test_the_text_of_an_answer_holds_its_data_for_hosts_that_read_text_alone(
        self, tmp_path: Path
    ) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            result = await host.answer("fold", edge=[1, 3], direction=1)
        sentence, data = text_of(result).split("\n")
        assert sentence.startswith("Done: fold([1, 3], 1).")
        assert sentence == data_of(result)["summary"]
        assert '"faces_orientations"' in data


class TestViewing:
    async def test_a_photo_comes_as_an_image_of_the_stated_size(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await host.call("open_run", sequence="sailboat")
            result = await host.answer("view_frame", frame=2)
        (image,) = images_of(result)
        assert image.mime_type == "image/jpeg"
        assert max(data_of(result)["width"], data_of(result)["height"]) <= 1024

    async def test_movement_names_the_images_it_shows(self, tmp_path: Path) -> None:
        folder = write_sequence_folder(tmp_path / "photos" / "clip", [10, 20], tuple(range(11, 20)))
        async with in_memory(tmp_path / "data", folder.parent) as host:
            await host.call("open_run", sequence="clip")
            result = await host.answer("observe_movement", frame=2)
        assert len(data_of(result)["images"]) == 5
        assert len(images_of(result)) == 1

    async def test_the_diagram_is_a_png_with_labels_on_request(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            plain, labelled = [await host.answer("render_current", labels=labels) for labels in (False, True)]
        pictures = [base64.b64decode(images_of(result)[0].data) for result in (plain, labelled)]
        assert all(picture.startswith(b"\x89PNG") for picture in pictures)
        assert pictures[0] != pictures[1]


class TestCheckpoints:
    async def test_saving_and_restoring_go_through_the_protocol(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            saved = await host.call("save_checkpoint", frame=2, notes="unsure of the corner")
            await host.call("flip", axis="x")
            back = await host.call("restore_checkpoint", frame=1)
            kept = await host.call("get_checkpoint_state", frame=2)
        assert saved["next_frame"] == 3
        assert saved["remaining"] == 2
        assert saved["actions"] == [{"action": "fold", "edge": [1, 3], "direction": 1}]
        assert back["restore_count"] == 1
        assert back["next_attempt"] == 2
        assert len(back["state"]["faces"]) == 1
        assert kept["notes"] == "unsure of the corner"
        assert len(kept["state"]["faces"]) == 2

    async def test_the_overview_has_a_column_for_each_frame_and_tells_its_progress(
        self, tmp_path: Path
    ) -> None:
        told: list[tuple[float, float | None]] = []

        async def progress(progress: float, total: float | None, message: str | None) -> None:
            assert message
            told.append((progress, total))

        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            result = await host.client.call_tool(
                "generate_checkpoint_overview", {}, progress_callback=progress
            )
        assert [each["saved"] for each in data_of(result)["frames"]] == [True, False, False, False]
        assert len(images_of(result)) == 1
        assert told == [(0, 4), (1, 4), (2, 4), (3, 4)]

    async def test_a_used_up_budget_is_settled_by_a_commitment(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            for angle in range(5):
                await host.call("rotate", angle=10 + angle)
                await host.call("restore_checkpoint", frame=1)
            refused = await host.refusal("flip", axis="x")
            result = await host.answer("list_attempts", frame=2)
            committed = await host.call("commit_attempt", frame=2, attempt=3)
        assert "commit_attempt" in refused
        assert [each["label"] for each in data_of(result)["attempts"]] == [
            "B1",
            "B2",
            "B3",
            "B4",
            "B5",
        ]
        assert len(images_of(result)) == 5
        assert committed["locked_to"] == 2
        assert committed["next_frame"] == 3


class TestVerification:
    async def test_the_critics_grid_shows_photos_then_diagrams(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path, photos()) as host:
            await a_saved_fold(host)
            result = await host.answer("critic_grid", frame=2)
        grid = data_of(result)
        assert grid is not None
        kinds = [image.mime_type for image in images_of(result)]
        assert kinds == ["image/jpeg", "image/jpeg", "image/png", "image/png"]
        assert shown_in(result) == [
            ("photo of frame 1", 1, "photo"),
            ("photo of frame 2", 2, "photo"),
            ("diagram of frame 1", 1, "diagram"),
            ("diagram of the candidate for frame 2", 2, "diagram"),
        ]
        assert len(grid["source_state"]["faces"]) == 1
        assert len(grid["candidate_state"]["faces"]) == 2
        assert [action["action"] for action in grid["candidate_actions"]] == ["fold"]

    async def test_the_right_state_matches_its_photo_and_a_wrong_one_does_not(
        self, tmp_path: Path, boats: Path
    ) -> None:
        async with in_memory(tmp_path, boats) as host:
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            same = await host.answer("compare_to_frame", frame=1)
            other = await host.call("compare_to_frame", frame=2)
        assert data_of(same)["verdict"] == "MATCH"
        assert len(images_of(same)) == 1
        assert other["verdict"] != "MATCH"
        assert other["discrepancies"]
        assert other["agreement"] < data_of(same)["agreement"]

    async def test_a_comparison_tells_how_the_photo_was_seen(self, tmp_path: Path, boats: Path) -> None:
        async with in_memory(tmp_path, boats) as host:
            await host.call("open_run", sequence="sailboat")
            flat = await host.call("compare_to_frame", frame=1)
            folded = await host.call("compare_to_frame", frame=2)
        (sheet,) = flat["outlines"]
        found, true = Polygon(sheet["corners"]), box(0, 0, 1, 1)
        assert len(sheet["corners"]) == 4
        assert sheet["hidden"] == []
        assert found.symmetric_difference(true).area < 0.01
        assert len(folded["outlines"][0]["corners"]) == 3
        assert 0.8 < flat["confidence"] <= 1

    @pytest.mark.slow
    async def test_an_attempt_is_compared_as_it_was_with_all_that_led_to_it(
        self, tmp_path: Path, boats: Path
    ) -> None:
        async with in_memory(tmp_path, boats) as host:
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            proposed = await host.call("propose_actions", frame=2, count=1)
            for action in proposed["proposals"][0]["actions"]:
                await host.call(action.pop("action"), **action)
            now = await host.call("compare_to_frame", frame=2)
            await host.call("restore_checkpoint", frame=1)
            left = await host.call("compare_to_frame", frame=2)
            attempt = await host.call("compare_to_frame", frame=2, attempt=1)
        assert attempt == now
        assert left != now

    @pytest.mark.slow
    async def test_a_proposal_can_be_applied_and_then_matches(self, tmp_path: Path, boats: Path) -> None:
        async with in_memory(tmp_path, boats) as host:
            await host.call("open_run", sequence="sailboat")
            await host.call("save_checkpoint", frame=1)
            proposed = await host.call("propose_actions", frame=2, count=2)
            assert len(proposed["proposals"]) == 2
            for action in proposed["proposals"][0]["actions"]:
                await host.call(action.pop("action"), **action)
            compared = await host.call("compare_to_frame", frame=2)
        assert proposed["confident"]
        assert compared["verdict"] == "MATCH"

    async def test_states_made_by_folding_are_foldable(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            await host.call("fold", edge=[1, 3], direction=1)
            found = await host.call("check_foldability")
        assert found["foldable"]
        assert found["states"] == 1

    async def test_a_pattern_is_checked_without_a_run_and_its_faults_have_places(
        self, tmp_path: Path
    ) -> None:
        corners = "1 0 0 9 0\n1 9 0 9 9\n1 9 9 0 9\n1 0 9 0 0\n"
        async with in_memory(tmp_path) as host:
            book = await host.call("check_foldability", pattern=corners + "2 0 0 9 9\n")
            loose = await host.call("check_foldability", pattern=corners + "2 0 0 5 5\n")
            refused = await host.answer("check_foldability", pattern="{")
        assert (book["foldable"], book["exact"]) == (True, "1")
        assert (loose["faults"][0]["kind"], loose["faults"][0]["places"]) == ("loose end", [[5.0, 5.0]])
        assert refused.is_error
        assert "The FOLD file is not JSON" in text_of(refused)


class TestExports:
    @pytest.mark.parametrize(
        ("format_", "start"),
        [
            ("fold", "{"),
            ("crease-pattern", "{"),
            ("cp", "1 "),
            ("svg", "<svg"),
            ("obj", "#"),
            ("program", "{"),
        ],
    )
    async def test_text_formats_come_as_text(self, tmp_path: Path, format_: str, start: str) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            await host.call("fold", edge=[1, 3], direction=1)
            exported = await host.call("export_state", format=format_)
        assert exported["text"].lstrip().startswith(start)
        assert exported["filename"]

    async def test_a_png_comes_as_image_content(self, tmp_path: Path) -> None:
        async with in_memory(tmp_path) as host:
            await host.call("open_run")
            result = await host.answer("export_state", format="png")
        assert data_of(result)["text"] is None
        assert images_of(result)[0].mime_type == "image/png"


@pytest.mark.slow
async def test_no_answer_carries_more_than_800_kb_of_images(tmp_path: Path) -> None:
    folder = tmp_path / "photos" / "noise"
    write_manifest(folder, name="noise", keyframes=[1, 2])
    for index in (1, 2):
        write_image(folder / "frames" / f"{index:06d}.png", noise(1600, 1200, index))
    async with in_memory(tmp_path / "data", folder.parent) as host:
        await host.call("open_run", sequence="noise")
        await host.call("save_checkpoint", frame=1)
        await host.call("fold", edge=[1, 3], direction=1)
        calls: dict[str, dict[str, Any]] = {
            "view_frame": {"frame": 2},
            "observe_movement": {"frame": 2},
            "critic_grid": {"frame": 2},
            "generate_checkpoint_overview": {},
            "render_current": {"labels": True},
            "list_attempts": {"frame": 2},
        }
        shown = {tool: await host.answer(tool, **arguments) for tool, arguments in calls.items()}
    sizes = {tool: sum(len(image.data) for image in images_of(result)) for tool, result in shown.items()}
    assert all(0 < size <= BASE64_LIMIT for size in sizes.values()), sizes
