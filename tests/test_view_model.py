"""What the view is given: every state of a program, photos that lie under them, words for hosts without a view."""

import base64
import json
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from folding_schemas.actions import Fold, Program, Rotate
from folding_schemas.model_view import ModelShown, ModelView
from folding_server.frames.image_files import decode_bytes, encode_jpeg
from folding_server.frames.sequences import load_sequence
from folding_server.interchange.programs import load_program
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.simulator import apply, folded_state, new_paper
from folding_server.view.local_model import LocalModel
from folding_server.view.page import page_html
from folding_server.view.photo_strip import ALL_PHOTO_BYTES, LEAST_PHOTO_BYTES, photos_of
from folding_server.view.stops import MOST_STATE_BYTES, model_view
from hosts import Host, in_memory, text_of
from mcp.types import CallToolResult, TextResourceContents
from paths import ROOT

PROGRAMS = sorted((ROOT / "examples" / "programs").glob("*.json"))
ANSWER_LIMIT = 800_000
"""The most bytes of an answer that every host takes."""


def program_of(path: Path) -> Program:
    return load_program(path.read_text(encoding="utf-8"))


def view_of(result: CallToolResult) -> ModelView:
    assert result.meta is not None
    return ModelView.model_validate(result.meta["foldingagent/view"])


async def folded_cat(host: Host, frames: int) -> None:
    """A run of the example cat, its first frames saved as its program has them."""
    await host.call("open_run", sequence="cat")
    steps = program_of(ROOT / "examples" / "programs" / "cat.json").steps
    await host.call("save_checkpoint", frame=1)
    for frame, step in enumerate(steps[: frames - 1], 2):
        for action in step:
            arguments: dict[str, Any] = action.model_dump(mode="json", exclude={"action"}, exclude_none=True)
            await host.call(action.action, **arguments)
        await host.call("save_checkpoint", frame=frame)


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_every_action_has_a_stop_with_its_state_inside_the_window(path: Path) -> None:
    program = program_of(path)
    view = model_view(program, ReplayCache())
    paper = new_paper(program.sheet)
    states = [folded_state(paper)]
    for action in (action for step in program.steps for action in step):
        paper = apply(paper, action)
        states.append(folded_state(paper))
    assert [stop.state for stop in view.stops] == states
    left, bottom, side = view.window
    for state in states:
        for vertex, (x, y) in state.vertices.items():
            assert left < x < left + side and bottom < y < bottom + side
            assert vertex in view.sheet_coords


def test_stops_say_their_step_and_the_frame_it_leads_to() -> None:
    fold, turn = Fold(edge=(1, 3), direction=1), Rotate(angle=90)
    view = model_view(Program(steps=((fold, turn), (turn,))), ReplayCache())
    assert [(stop.step, stop.frame) for stop in view.stops] == [(0, 1), (1, 2), (1, 2), (2, 3)]
    assert [stop.crease for stop in view.stops] == [None, (1, 3), None, None]
    assert view.stops[1].moved_faces == [2]


def test_of_a_long_program_the_early_states_are_left_out() -> None:
    steps = (*program_of(PROGRAMS[0]).steps, *(((Rotate(angle=90),),) * 700))
    view = model_view(Program(steps=steps), ReplayCache())
    actions = sum(map(len, steps))
    assert 0 < view.left_out < actions
    assert view.left_out + len(view.stops) == actions + 1
    assert view.stops[-1].step == len(steps)
    assert sum(len(stop.model_dump_json()) for stop in view.stops) <= MOST_STATE_BYTES


@pytest.mark.anyio
async def test_hosts_without_a_view_get_every_action_in_words_and_no_states(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        opened = await host.call("open_run")
        await host.call("fold", edge=[1, 3], direction=1)
        result = await host.answer("show_model")
    shown = ModelShown.model_validate(result.structured_content)
    assert shown.run_id == opened["run_id"]
    assert shown.stops == [
        "the flat sheet; 1 layer",
        "step 1: fold 1-3, + side; 1 of 2 faces moved; 2 layers",
    ]
    assert text_of(result) == "\n".join([shown.summary, *shown.stops])
    assert "state" not in json.dumps(result.structured_content)
    assert [stop.state.layers for stop in view_of(result).stops][-1] == [[[1]], [[2]]]


@pytest.mark.anyio
async def test_the_photos_of_the_frames_reached_lie_under_the_states(tmp_path: Path) -> None:
    async with in_memory(tmp_path, ROOT / "examples") as host:
        await folded_cat(host, 3)
        result = await host.answer("show_model")
    view = view_of(result)
    assert list(view.photos) == [1, 2, 3]
    assert len(result.model_dump_json()) < ANSWER_LIMIT
    left, bottom, side = view.window
    photo = decode_bytes(base64.b64decode(view.photos[3].partition(",")[2]), "the photo")
    rows, cols = np.nonzero(photo[..., 0].astype(int) > photo[..., 2].astype(int) + 60)  # orange on blue
    size = photo.shape[0]
    seen = np.array([cols.min(), cols.max(), size - rows.max(), size - rows.min()]) * side / size
    xs, ys = np.array(list(view.stops[-1].state.vertices.values())).T
    drawn = np.array([xs.min() - left, xs.max() - left, ys.min() - bottom, ys.max() - bottom])
    assert np.abs(seen - drawn).max() < 0.03


@pytest.mark.anyio
async def test_all_photos_of_a_run_together_fit_into_an_answer(tmp_path: Path) -> None:
    async with in_memory(tmp_path, ROOT / "examples") as host:
        await folded_cat(host, 9)
        result = await host.answer("show_model")
    assert list(view_of(result).photos) == list(range(1, 10))
    assert len(result.model_dump_json()) < ANSWER_LIMIT


def test_of_very_many_photos_the_last_are_shown(tmp_path: Path) -> None:
    frames = ALL_PHOTO_BYTES // LEAST_PHOTO_BYTES + 60
    (tmp_path / "frames").mkdir()
    grain = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    for frame in range(1, frames + 1):
        (tmp_path / "frames" / f"{frame:06}.jpg").write_bytes(encode_jpeg(grain, 90).data)
    about = {"name": "long", "frames": "frames", "keyframes": list(range(1, frames + 1))}
    (tmp_path / "keyframes.json").write_text(json.dumps(about))
    found = photos_of(load_sequence(tmp_path), range(1, frames + 1), (0, 0, 1))
    assert list(found) == list(range(61, frames + 1))


@pytest.mark.anyio
async def test_the_tool_names_its_page_and_the_page_is_an_app(tmp_path: Path) -> None:
    async with in_memory(tmp_path) as host:
        listed = {tool.name: tool for tool in (await host.client.list_tools()).tools}
        meta = listed["show_model"].meta
        assert meta is not None
        (page,) = (await host.client.read_resource(meta["ui"]["resourceUri"])).contents
        extensions = host.client.server_capabilities.extensions
    assert isinstance(page, TextResourceContents)
    assert page.mime_type == "text/html;profile=mcp-app"
    assert page.text.startswith("<!doctype html>")
    assert "io.modelcontextprotocol/ui" in (extensions or {})


def test_the_page_names_no_other_place() -> None:
    page = page_html()
    assert "default-src 'none'" in page
    for way in ("src=", "@import", "url(http", "https://"):
        assert way not in page, way
    assert page.count("http://") == page.count("http://www.w3.org/2000/svg")


def test_folds_tried_in_memory_come_after_the_program_and_can_be_taken_back() -> None:
    model = LocalModel(program_of(PROGRAMS[0]))
    before = model.view()
    done = model.call("fold", {"edge": [1, 2], "direction": 1})
    if done["isError"]:
        done = model.call("fold", {"edge": [2, 4], "direction": 1})
    assert not done["isError"]
    after = model.call("show_model", {})["_meta"]["foldingagent/view"]
    assert after["steps"] == before.steps + 1
    assert not model.call("undo", {})["isError"]
    assert model.view() == before


@pytest.mark.parametrize(
    ("tool", "arguments", "named"),
    [
        ("fold", {"edge": [1, 99], "direction": 1}, "99"),
        ("fold", {"edge": [1, 3], "direction": 5}, "direction"),
        ("fold", {"edge": "1-3", "direction": 1}, "edge"),
        ("unfold", {"edge": [1, 3]}, "1"),
        ("undo", {}, "Nothing was folded"),
        ("export_state", {}, "export_state"),
    ],
)
def test_what_is_refused_in_memory_is_one_sentence_and_changes_nothing(
    tool: str, arguments: dict[str, Any], named: str
) -> None:
    model = LocalModel(Program())
    refused = model.call(tool, arguments)
    (block,) = refused["content"]
    assert refused["isError"]
    assert named in block["text"] and "\n" not in block["text"]
    assert len(model.view().stops) == 1


def test_the_window_leaves_room_around_a_sheet_that_is_no_square() -> None:
    view = model_view(Program(sheet=(2.0, 0.5)), ReplayCache())
    left, bottom, side = view.window
    assert left < -0.1 and bottom < -0.1
    assert side > hypot(2.0, 0.5)
