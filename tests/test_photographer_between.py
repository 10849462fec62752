"""Images between two keyframes: a part of the paper stands up and turns over, held by a hand, and the truth says so."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Program, Rotate, Unfold
from folding_server.errors import PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.geometry.isometry import IDENTITY
from folding_server.photographer import photograph
from folding_server.photographer.color_spaces import linear_color, to_linear
from folding_server.photographer.flap_rotation import FlapRotationView
from folding_server.photographer.levels import LEVELS
from folding_server.photographer.moments import moments
from folding_server.photographer.movements import Swing, movements
from folding_server.photographer.photo_scene import Drift
from folding_server.photographer.pinhole_camera import looking_down
from folding_server.photographer.placement import place
from folding_server.simulator import Paper, apply, replay
from folding_server.vision.motion import movement
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver.motion_evidence import contradiction, watched_places
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

SIZE = (240, 240)
PART: tuple[Action, ...] = (
    AddVertex(edge=(1, 2), position=0.6),
    AddVertex(edge=(3, 4), position=0.4),
    Fold(edge=(5, 6), direction=1),
)
TURNS = Program(
    name="turns",
    front_color="#f4f2ec",
    back_color="#2f6fb4",
    steps=(PART, (Flip(axis="x"),), (Unfold(),), (Rotate(angle=-60),), (Fold(edge=(1, 3), direction=1),)),
)
"""A part folded over; turned over, so that it opens under the rest; turned; folded over again."""


def truth_of(folder: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((folder / "truth.json").read_text())
    return loaded


def picture_of(folder: Path, told: dict[str, Any]) -> np.ndarray[Any, Any]:
    with Image.open(folder / told["image"]) as image:
        return np.asarray(image)


def painted(told: dict[str, Any], size: tuple[int, int]) -> np.ndarray[Any, Any]:
    """Labels 0 table, 1 front, 2 back from the truth of one image alone."""
    labels = np.zeros(size[::-1], np.uint8)
    for face in told["faces"]:
        outline = np.rint((np.array(face["pixels"]) - 0.5) * 16).astype(np.int32)
        cv2.fillConvexPoly(labels, outline, 1 + face["back"], cv2.LINE_8, 4)
    return labels


def hues(picture: np.ndarray[Any, Any], scene: dict[str, Any]) -> np.ndarray[Any, Any]:
    """Labels 0 table, 1 front, 2 back by the nearest of the scene's hues, however bright: parts that stand are dim."""
    colors = np.cbrt(np.array([linear_color(scene[key]) for key in ("table_color", "front", "back")]))
    seen = cv2.GaussianBlur(np.cbrt(to_linear(picture)), (0, 0), 1.0)
    strengths = ((0.7, 0.85, 1.0), *((0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1),) * 2)
    closest = [
        np.min([np.linalg.norm(seen - s * color, axis=-1) for s in options], axis=0)
        for color, options in zip(colors, strengths, strict=True)
    ]
    return np.asarray(np.argmin(closest, axis=0), np.uint8)


@pytest.fixture(scope="module")
def turns(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program with three images in between at level 1."""
    return photograph(TURNS, tmp_path_factory.mktemp("turns"), 1, size=SIZE, between=3).folder


def test_images_in_between_lie_between_the_keyframes_of_the_sequence(turns: Path) -> None:
    sequence = load_sequence(turns)
    assert sequence.frame_count == 6
    assert sequence.keyframes == (1, 5, 9, 13, 17, 21)
    assert sequence.between(2) == [2, 3, 4]
    assert [told["image"] for told in truth_of(turns)["between"][:3]] == [
        f"frames/{index:06d}.jpg" for index in (2, 3, 4)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("level", sorted(LEVELS))
def test_the_keyframes_are_the_same_with_and_without_images_in_between(tmp_path: Path, level: int) -> None:
    short = TURNS.model_copy(update={"steps": TURNS.steps[:2]})
    for between in (0, 2):
        photograph(short, tmp_path / str(between), 5, level, SIZE, between=between)
    alone, among = (truth_of(tmp_path / name)["frames"] for name in "02")
    for one, other in zip(alone, among, strict=True):
        assert (tmp_path / "0" / one["image"]).read_bytes() == (tmp_path / "2" / other["image"]).read_bytes()
        assert one["vertex_pixels"] == other["vertex_pixels"]
    assert "between" not in truth_of(tmp_path / "0")
    assert len(list((tmp_path / "0" / "frames").iterdir())) == 3


def test_every_pixel_shows_the_side_that_the_truth_says(turns: Path) -> None:
    truth = truth_of(turns)
    for told in truth["between"]:
        agree = hues(picture_of(turns, told), truth["scene"]) == painted(told, SIZE)
        assert agree.mean() > 0.97, told["image"]


def test_the_truth_tells_what_moves_and_how_far_it_has_come(turns: Path) -> None:
    told = truth_of(turns)["between"]
    assert [image["action"]["action"] for image in told[::3]] == ["fold", "flip", "unfold", "rotate", "fold"]
    assert told[0]["action"]["at"] == [[0.6, 1], [0.6, 0]]
    for start in range(0, 15, 3):
        degrees = [abs(image["degrees"]) for image in told[start : start + 3]]
        assert 0 < degrees[0] < degrees[1] < degrees[2] < 180
    (stays, moves) = sorted(told[0]["faces"], key=lambda face: bool(face["moves"]))
    assert (stays["moves"], moves["moves"]) == (False, True)
    assert min(x for x, _ in moves["sheet"]) == pytest.approx(0.6)
    assert max(x for x, _ in stays["sheet"]) == pytest.approx(0.6)
    assert all(face["moves"] for image in told[3:6] for face in image["faces"])


def test_the_side_that_is_seen_of_a_flap_changes_halfway(tmp_path: Path) -> None:
    folded = TURNS.model_copy(update={"steps": TURNS.steps[:1]})
    photograph(folded, tmp_path, 1, size=SIZE, between=6)
    seen = set()
    for told in truth_of(tmp_path)["between"]:
        (flap,) = (face for face in told["faces"] if face["moves"])
        if abs(told["degrees"] - 90) > 15:
            assert flap["back"] == (told["degrees"] > 90)
            seen.add(bool(flap["back"]))
    assert seen == {False, True}


def test_what_stays_stays_and_the_flap_reaches_less_far_as_it_rises(turns: Path) -> None:
    truth = truth_of(turns)
    flat = np.array([truth["frames"][0]["vertex_pixels"][v] for v in "1234"])
    right = []
    for told in truth["between"][:3]:
        stays, flap = (np.array(face["pixels"]) for face in told["faces"])
        assert np.abs(stays[:, 0].min() - flat[:, 0].min()) < 6
        right.append(float(flap[:, 0].mean()))
    assert right == sorted(right, reverse=True)


CAMERA = looking_down(SIZE, focal=300, distance=2.5, tilt=9.0, azimuth=30.0, roll=1.0)
LIES = Drift(20.0, (0.0, 0.0)).folded_to_table((0.0, 0.0))


@given(st.integers(0, 4), st.floats(0.0, 180.0))
def test_nothing_goes_through_the_table(step: int, angle: float) -> None:
    (found,) = movements(TURNS)[step]
    if isinstance(found, Swing):
        view = FlapRotationView(found, angle, CAMERA, LIES)
        heights = np.vstack([view.in_space(face) for face in found.paper.faces])[:, 2]
        assert heights.min() >= -1e-9
        assert heights.max() <= 1.5


@pytest.mark.parametrize("step", [0, 1, 2, 4])
def test_a_swing_starts_and_ends_with_the_paper_that_lies_there(step: int) -> None:
    (found,) = movements(TURNS)[step]
    assert isinstance(found, Swing)
    for angle, paper in ((180.0, found.paper), (0.0, found.before)):
        swings, flat = FlapRotationView(found, angle, CAMERA, LIES), place(paper, CAMERA, LIES)
        for face in paper.faces.keys() & found.paper.faces.keys():
            if paper.faces[face] == found.paper.faces[face]:
                assert swings.outline(face) == pytest.approx(flat.outline(face), abs=0.6)
                assert swings.back_up(face) == flat.back_up(face)


@pytest.mark.slow
def test_hands_move_the_paper_where_the_level_has_hands(tmp_path: Path) -> None:
    short = TURNS.model_copy(update={"steps": TURNS.steps[:2]})
    for level, program in ((2, short), (3, TURNS)):
        photograph(program, tmp_path / str(level), 4, level, SIZE, between=2)
    assert all(told["hand"] is None for told in truth_of(tmp_path / "2")["between"])
    assert len(truth_of(tmp_path / "3")["between"]) == 10
    for told in truth_of(tmp_path / "3")["between"]:
        hand = told["hand"]
        assert hand["pose"] == "hold"
        with Image.open(tmp_path / "3" / hand["mask"]) as image:
            mask = np.asarray(image) > 127
        paper = painted(told, SIZE) > 0
        assert (mask & paper)[paper].mean() == pytest.approx(hand["cover"], abs=0.04)
        assert hand["cover"] > 0


def test_where_nothing_moves_nobody_holds_the_paper(tmp_path: Path) -> None:
    marked = Program(name="marked", steps=(PART[:1], PART[1:]))
    photograph(marked, tmp_path, 4, 3, SIZE, between=1)
    still, moving = truth_of(tmp_path)["between"]
    assert (still["action"], still["degrees"], still["hand"]) == (None, 0, None)
    assert not any(face["moves"] for face in still["faces"])
    assert moving["action"]["action"] == "fold"
    assert moving["hand"] is not None


def test_a_step_of_several_actions_shows_one_after_the_other(tmp_path: Path) -> None:
    both = Program(name="both", steps=((Rotate(angle=45), Fold(edge=(1, 3), direction=1)),))
    photograph(both, tmp_path, 1, size=SIZE, between=4)
    told = truth_of(tmp_path)["between"]
    assert [image["action"]["action"] for image in told] == ["rotate", "rotate", "fold", "fold"]


def test_images_come_early_or_late_but_in_order() -> None:
    taken = [moment for moment in moments(3, 4, 5) if moment.image]
    shares = [moment.share for moment in taken]
    assert len({round(share, 6) for share in shares}) == 15
    for start in range(0, 15, 5):
        assert 0 < shares[start] < shares[start + 4] < 1
        assert shares[start : start + 5] == sorted(shares[start : start + 5])


@pytest.mark.parametrize("between", [-1, 31])
def test_a_number_of_images_that_cannot_be_had_gets_one_sentence(tmp_path: Path, between: int) -> None:
    with pytest.raises(PhotoError, match=f"cannot be {between} images between two keyframes; give 0 to 30"):
        photograph(TURNS, tmp_path / "new", 1, size=SIZE, between=between)
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("level", "seed"), [(2, 1), (2, 2), (3, 4)])
def test_the_photographed_flap_tells_the_moving_side_to_the_solver(
    tmp_path: Path, level: int, seed: int
) -> None:
    folded = TURNS.model_copy(update={"steps": TURNS.steps[:1]})
    photograph(folded, tmp_path, seed, level, (500, 500), between=3)
    shown = movement(see_sequence(load_sequence(tmp_path)), 2)
    assert shown is not None
    found = Program.model_validate_json((tmp_path / "program.json").read_text())
    (before, right), left = _ways(found)
    seen = watched_places(shown, IDENTITY)
    assert contradiction(before, right, seen) < contradiction(before, left, seen) - 0.1


def _ways(program: Program) -> tuple[tuple[Paper, Paper], Paper]:
    """The marked sheet, it with the part folded over, and with the other part folded over."""
    *marks, turned = program.steps[0]
    sheet = replay(marks, program.sheet)
    assert isinstance(turned, Fold)
    other = turned.model_copy(update={"direction": -turned.direction})
    return (sheet, apply(sheet, turned)), apply(sheet, other)
