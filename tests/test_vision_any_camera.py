"""Photos that are framed anew each time: the paper tells the camera, and what was folded."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from folding_schemas.actions import AddVertex, Flip, Fold
from folding_server.frames.sequences import load_sequence
from folding_server.simulator import Paper, apply, new_paper
from folding_server.vision.any_camera import compare_with_photo
from folding_server.vision.labels import BACK, FRONT
from folding_server.vision.pose_estimation.estimate import camera_evidence, estimates
from folding_server.vision.pose_estimation.pinhole import PinholeCamera, projected
from folding_server.vision.registration.scene import face_stack
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import propose
from framed_anew import SIDE, Standpoint, photo
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from reference_data import REFERENCE
from vision_scenes import Look, PhotoList

STANDPOINTS = st.builds(
    Standpoint,
    distance=st.floats(2.5, 3.4),
    roll=st.floats(-180, 180),
    tilt=st.floats(0, 20),
    towards=st.floats(0, 360),
    aside=st.tuples(st.floats(-40, 40), st.floats(-40, 40)),
)
FIRST = Standpoint(roll=3.0, tilt=4.0)
KITE = (Fold(edge=(1, 3), direction=1), AddVertex(edge=(4, 1), position=0.4), Fold(edge=(3, 5), direction=1))


def folded(*actions: AddVertex | Fold) -> Paper:
    paper = new_paper()
    for action in actions:
        paper = apply(paper, action)
    return paper


def test_that_a_camera_is_nearer_says_nothing_where_photos_are_cropped_to_the_model() -> None:
    before = PinholeCamera((0.5, 0.5), 0.0, 0.0, 0.0, 0.2)
    nearer = replace(before, size=0.7)
    assert camera_evidence(nearer, before, grown=0.0).nearness == 0.0
    assert camera_evidence(before, before, grown=0.5).nearness == 0.0
    assert (
        camera_evidence(nearer, before, grown=0.4).nearness
        > camera_evidence(nearer, before, grown=0.1).nearness
        > 0
    )


@given(STANDPOINTS)
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_the_folded_paper_tells_where_the_camera_stood(standpoint: Standpoint) -> None:
    paper = folded(*KITE)
    observer = see_sequence(PhotoList([photo(new_paper(), FIRST), photo(paper, standpoint, seed=1)]))
    (view,) = observer.pictures(2)
    camera = estimates([face_stack(paper)], view)[0].camera
    corners = np.array(list(paper.folded_vertices_coords.values()))
    found, true = camera.pose(view.frame).to_photo(corners), standpoint.pixels(corners)
    per_unit = float(np.linalg.norm(np.diff(standpoint.pixels([(0.0, 0.5), (1.0, 0.5)]), axis=0)))
    # The paper is a triangle by now, three corners for the six numbers of a camera: its tilt is told to a few degrees only.
    errors = np.linalg.norm(found - true, axis=1) / per_unit
    assert np.sqrt((errors**2).mean()) < 0.03
    assert errors.max() < 0.05


@given(
    st.tuples(*[st.floats(-1, 1)] * 2),
    st.floats(-3, 3),
    st.floats(-1, 0.5),
    st.tuples(*[st.floats(-0.4, 0.4)] * 2),
)
def test_a_camera_shows_its_pivot_where_it_says(
    place: tuple[float, float], roll: float, size: float, tilt: tuple[float, float]
) -> None:
    camera = PinholeCamera((0.3, 0.7), *place, roll, size, *tilt)
    shown = projected(camera.homography, np.array([camera.pivot]))[0]
    assert shown == pytest.approx((place[0] + 0.5, place[1] + 0.5), abs=1e-9)


def test_a_fold_is_found_although_the_camera_was_turned_moved_and_tilted() -> None:
    half = folded(KITE[0])
    moved = Standpoint(3.1, 70.0, 14.0, 40.0, (60.0, -50.0))
    observer = see_sequence(PhotoList([photo(new_paper(), FIRST), photo(half, moved, seed=1)]))
    plan = propose(new_paper(), observer, 2)[0]
    assert plan.action_class == "fold"
    (crease,) = plan.paper.creases
    ends = np.array([plan.paper.vertices_coords[v] for v in crease])
    assert sorted(np.abs(ends[0] - ends[1]).tolist()) == pytest.approx([1.0, 1.0], abs=1e-6)
    compared = compare_with_photo(plan.paper, observer, 2)
    assert compared.match.verdict == "MATCH"
    assert compared.estimate is not None


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_axis_of_a_flip_is_told_by_how_the_camera_is_turned(axis: Literal["x", "y"]) -> None:
    flap = folded(
        AddVertex(edge=(1, 2), position=0.2),
        AddVertex(edge=(1, 4), position=0.35),
        Fold(edge=(5, 6), direction=-1),
    )
    flipped = apply(flap, Flip(axis=axis))
    cameras = Standpoint(2.8, 10.0, 9.0, 70.0), Standpoint(2.5, -8.0, 12.0, 200.0)
    shown = [
        photo(paper, replace(at, look_at=face_stack(paper).center), seed=i)
        for i, (paper, at) in enumerate(zip((flap, flipped), cameras, strict=True))
    ]
    observer = see_sequence(PhotoList([photo(new_paper(), FIRST, seed=9), *shown]))
    assert propose(flap, observer, 3)[0].actions == (Flip(axis=axis),)


def test_both_sides_of_a_sheet_are_one_piece_though_their_border_looks_like_neither() -> None:
    green = Look(front=(245, 240, 235), back=(40, 130, 80), table=(40, 70, 110))
    book = folded(
        AddVertex(edge=(1, 2), position=0.6),
        AddVertex(edge=(3, 4), position=0.4),
        Fold(edge=(6, 5), direction=1),
    )
    observer = see_sequence(
        PhotoList([photo(new_paper(), FIRST, green), photo(book, Standpoint(2.6, 70.0, 10.0), green, seed=1)])
    )
    (view,) = observer.pictures(2)
    front, back = (int((view.scene.labels == side).sum()) for side in (FRONT, BACK))
    assert front / back == pytest.approx(0.2 / 0.4, abs=0.05)
    assert compare_with_photo(book, observer, 2).match.verdict == "MATCH"


def test_a_state_is_told_from_another_under_a_new_camera() -> None:
    observer = see_sequence(
        PhotoList([photo(new_paper(), FIRST), photo(folded(*KITE), Standpoint(3.0, 50.0, 12.0), seed=1)])
    )
    right, wrong = (
        folded(*KITE),
        folded(KITE[0], AddVertex(edge=(4, 1), position=0.55), Fold(edge=(3, 5), direction=1)),
    )
    assert compare_with_photo(right, observer, 2).match.verdict == "MATCH"
    assert compare_with_photo(wrong, observer, 2).match.verdict != "MATCH"


def test_a_photo_that_cuts_the_sheet_matches_nothing_and_says_why() -> None:
    near = Standpoint(distance=1.5, aside=(0.45 * SIDE, 0.0))
    observer = see_sequence(PhotoList([photo(new_paper(), FIRST), photo(new_paper(), near, seed=1)]))
    match = compare_with_photo(new_paper(), observer, 2).match
    assert match.verdict != "MATCH"
    assert "the paper reaches beyond the edge of the photo" in match.words[0]


@pytest.mark.slow
@pytest.mark.reference("cases/photos")
def test_a_sheet_turned_and_folded_between_two_photos_is_followed() -> None:
    sequence = load_sequence(REFERENCE / "cases" / "photos" / "turn_and_fold")
    observer, paper = see_sequence(sequence), new_paper()
    for frame in (2, 3):
        paper = propose(paper, observer, frame)[0].paper
        assert compare_with_photo(paper, observer, frame).match.verdict == "MATCH"
    (first, *_) = [
        action for action in propose(new_paper(), observer, 2)[0].actions if action.action == "fold"
    ]
    assert set(first.edge) in ({1, 3}, {2, 4})


@pytest.mark.slow
@pytest.mark.reference("cases/photos")
def test_a_photo_zoomed_until_the_sheet_leaves_it_is_no_match() -> None:
    sequence = load_sequence(REFERENCE / "cases" / "photos" / "false_match_cut_photo")
    observer, paper = see_sequence(sequence), new_paper()
    for frame in (2, 3):
        paper = propose(paper, observer, frame)[0].paper
    match = compare_with_photo(paper, observer, 3).match
    assert match.verdict != "MATCH"
    assert "the paper reaches beyond the edge of the photo" in match.words[0]


@pytest.mark.reference("cases/photos")
@pytest.mark.parametrize("name", ["heic_frames", "img_names"])
def test_photos_as_phones_deliver_them_are_a_sequence(name: str) -> None:
    sequence = load_sequence(REFERENCE / "cases" / "photos" / name)
    assert sequence.frame_count == 4
    assert see_sequence(sequence).two_coloured
