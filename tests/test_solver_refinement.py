"""Creases fitted to all photos at once: found where they are if they are a little off, left alone if they are not."""

from collections.abc import Sequence
from math import dist
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from folding_schemas.actions import AddVertex, Fold
from folding_server.simulator import Paper, apply, replay
from folding_server.simulator.counterpart import Counterpart, NoCounterpart
from folding_server.vision.seeing import SequenceObserver, see_sequence
from folding_server.vision.solver.refinement import MovableVertices, Steps, refined, revised
from framed_anew import Standpoint, photo
from hosts import Host, in_memory
from hypothesis import given, settings
from hypothesis import strategies as st
from pictures import write_image, write_manifest
from vision_scenes import PhotoList

pytestmark = pytest.mark.anyio

CAMERAS = (
    Standpoint(),
    Standpoint(distance=2.3, roll=14, tilt=11, towards=40, aside=(20, -30)),
    Standpoint(distance=2.9, roll=-8, tilt=16, towards=200, aside=(-15, 25)),
    Standpoint(distance=2.1, roll=25, tilt=9, towards=120),
)
NEAR = 0.005
"""Sheet units within which two folded states tell four vertices, under two cameras of which nothing is known."""


def strips(first: float, second: float, third: float, fourth: float) -> Steps:
    """A side folded over along a line between two marks, then what is below folded up along another."""
    return (
        (
            AddVertex(edge=(1, 2), position=first),
            AddVertex(edge=(4, 3), position=second),
            Fold(edge=(5, 6), direction=-1),
        ),
        (
            AddVertex(edge=(2, 3), position=third),
            AddVertex(edge=(5, 6), position=fourth),
            Fold(edge=(7, 8), direction=-1),
        ),
    )


MEANT = strips(0.3, 0.3, 0.4, 0.4)
DONE: Steps = tuple(
    actions for _, actions in MovableVertices(MEANT).carried_out(np.array([0.009, -0.008, 0.008, -0.005]))
)
"""What was meant, and what hands made of it."""


def papers(steps: Steps) -> list[Paper]:
    """The sheet, and the paper after each step."""
    return [replay([action for step in steps[:count] for action in step]) for count in range(len(steps) + 1)]


def observed(steps: Steps) -> SequenceObserver:
    """Photos of a program, each framed anew."""
    shown = zip(papers(steps), CAMERAS, strict=False)
    return see_sequence(PhotoList([photo(paper, at, seed=i) for i, (paper, at) in enumerate(shown)]))


def farthest(one: Paper, other: Paper) -> float:
    """The largest distance between vertices of one name on two sheets."""
    return max(dist(place, other.vertices_coords[v]) for v, place in one.vertices_coords.items())


@pytest.mark.slow
def test_creases_a_little_beside_their_landmarks_are_found_where_they_are() -> None:
    observer, done = observed(DONE), papers(DONE)[-1]
    found = refined(MEANT, observer)
    assert farthest(done, papers(MEANT)[-1]) > 0.008
    assert farthest(done, found.paper) < NEAR
    assert found.told
    assert found.paper == papers(found.steps)[-1]
    assert revised(MEANT, observer) == found.steps


@pytest.mark.slow
def test_creases_that_are_where_they_are_meant_to_be_are_left_alone() -> None:
    observer = observed(MEANT)
    found = refined(MEANT, observer)
    assert not found.told
    assert farthest(papers(MEANT)[-1], found.paper) < NEAR
    assert revised(MEANT, observer) == MEANT


@pytest.mark.slow
def test_what_was_refined_before_does_not_matter() -> None:
    observer = observed(DONE)
    step_by_step = [refined(MEANT[:count], observer) for count in (1, 2)][-1]
    assert refined(MEANT, observed(DONE)) == step_by_step


def test_steps_that_cannot_be_followed_a_little_beside_are_left_as_they_are() -> None:
    """A fold of a corner so small that its vertices cannot be moved."""
    tiny: Steps = (
        (
            AddVertex(edge=(1, 2), position=0.004),
            AddVertex(edge=(1, 4), position=0.004),
            Fold(edge=(5, 6), direction=1),
        ),
        (Fold(edge=(2, 4), direction=1),),
    )
    found = refined(tiny, observed(tiny))
    assert not found.told
    assert revised(tiny, observed(tiny)) == tiny
    assert refined((), observed(())).steps == ()


@given(st.lists(st.floats(-0.012, 0.012), min_size=4, max_size=4))
@settings(max_examples=25, deadline=None)
def test_moved_vertices_make_the_same_model_a_little_beside(offsets: list[float]) -> None:
    last, actions = MovableVertices(MEANT).carried_out(np.array(offsets))[-1]
    assert last.exact == papers(MEANT)[-1]
    assert last.same_model()
    assert len(last.real.faces) == len(last.exact.faces)
    for vertex, offset in zip((5, 6, 7, 8), offsets, strict=True):
        assert dist(last.exact.vertices_coords[vertex], last.real.vertices_coords[last.twin[vertex]]) < (
            abs(offset) + 0.012
        )
    assert actions[-1].action == "fold"


def test_a_model_that_cannot_be_folded_so_has_no_stacks() -> None:
    assert MovableVertices(MEANT).stacks(np.array([0.3, 0.0, 0.0, 0.0])) is None


def test_an_action_on_refined_paper_is_carried_back_by_the_places_of_its_vertices() -> None:
    meant, done = papers(MEANT)[-1], papers(DONE)[-1]
    papers_so = Counterpart(done, meant, {v: v for v in done.vertices_coords})
    action = AddVertex(edge=(1, 9), position=0.25)
    carried = papers_so.copy()
    assert carried.carry_out(action, 0.0) == action
    assert carried.real == apply(meant, action)
    with pytest.raises(NoCounterpart):
        papers_so.carry_out(Fold(edge=(5, 99), direction=1), 0.0)


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The photos as a sequence of files."""
    root = tmp_path_factory.mktemp("sequences")
    for number, (paper, at) in enumerate(zip(papers(DONE), CAMERAS, strict=False), 1):
        write_image(root / "strips" / "frames" / f"{number}.png", photo(paper, at, seed=number))
    write_manifest(root / "strips", name="strips", frames="frames", keyframes=[1, 2, 3])
    return root


async def carry_out(host: Host, steps: Sequence[Sequence[dict[str, Any]]]) -> None:
    """Carry out and save the steps that lead to frame 2 and on."""
    for frame, step in enumerate(steps, 2):
        for action in step:
            await host.call(action["action"], **{name: x for name, x in action.items() if name != "action"})
        await host.call("save_checkpoint", frame=frame)


@pytest.mark.slow
async def test_a_run_is_told_where_its_creases_are_and_can_be_folded_so(tmp_path: Path, shown: Path) -> None:
    async with in_memory(tmp_path, shown) as host:
        await host.call("open_run", sequence="strips")
        await host.call("save_checkpoint", frame=1)
        await carry_out(host, [[action.model_dump() for action in step] for step in MEANT])
        found = await host.call("refine_creases", frame=3)
        assert (found["told"], found["frame"]) == (True, 3)
        await host.call("restore_checkpoint", frame=1)
        assert "does not lead to frame 3" in await host.refusal("refine_creases", frame=3)
        await carry_out(host, found["steps"])
        assert (await host.call("get_run"))["program"]["steps"] == found["steps"]
        assert not (await host.call("refine_creases", frame=3))["told"]


async def test_creases_are_refined_only_up_to_the_frame_that_the_state_shows(
    tmp_path: Path, shown: Path
) -> None:
    async with in_memory(tmp_path, shown) as host:
        await host.call("open_run", sequence="strips")
        await host.call("save_checkpoint", frame=1)
        assert "frame 2 saved first" in await host.refusal("refine_creases", frame=3)
        assert "Frame 9" in await host.refusal("refine_creases", frame=9)
        await host.call("open_run")
        assert "without photos" in await host.refusal("refine_creases", frame=2)
