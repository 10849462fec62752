"""Keyframes proposed from films whose resting moments are known, and the folders written from them."""

import json
from pathlib import Path

import numpy as np
import pytest
from folding_server.errors import PhotoError
from folding_server.frames.image_differences import changed_pixels, soften, solid_area
from folding_server.frames.keyframes import propose_keyframes
from folding_server.frames.sequence_folder import DeclaredSheet
from folding_server.frames.sequence_writer import keyframes_command, write_sequence
from folding_server.frames.sequences import Library, load_sequence
from paths import EXAMPLES
from PIL import Image
from reference import reference_files
from videos import (
    HOUSE,
    KITE,
    SQUARE,
    TAB,
    TRIANGLE,
    Camera,
    Clip,
    Hold,
    Rest,
    Sway,
    Work,
    encode,
    write_clip,
)

FOLDS = (
    Rest(SQUARE),
    Work(SQUARE, TRIANGLE),
    Rest(TRIANGLE),
    Work(TRIANGLE, KITE),
    Rest(KITE),
    Work(KITE, HOUSE),
    Rest(HOUSE),
    Work(HOUSE, TAB),
    Rest(TAB),
)
TULIP = reference_files("photos/rendered", "how_to_make_an_easy_origami_tulip_stem")


def shots_of(clip: Clip, keyframes: list[int]) -> list[int]:
    """The shot in which each keyframe lies."""
    return [next(number for number, shot in enumerate(clip.shots) if index in shot) for index in keyframes]


@pytest.mark.slow
@pytest.mark.parametrize(
    "camera",
    [
        Camera(),
        Camera(grain=6.0, flicker=0.06),
        Camera(turned=90),
        Camera(steps=(20, 33, 70, 41)),
        Camera(steps=(120, 200)),
    ],
    ids=["plain", "grainy and flickering", "turned", "variable rate", "five a second"],
)
def test_each_resting_state_is_a_keyframe(tmp_path: Path, camera: Camera) -> None:
    shots = FOLDS if camera == Camera() else FOLDS[:5]
    clip = write_clip(tmp_path / "clip.mp4", shots, camera)
    assert shots_of(clip, propose_keyframes(clip.path)) == list(range(0, len(shots), 2))


@pytest.mark.slow
def test_hands_that_change_nothing_make_no_keyframe(tmp_path: Path) -> None:
    shots = [
        Rest(SQUARE), Work(SQUARE, SQUARE), Rest(SQUARE),
        Work(SQUARE, TRIANGLE), Rest(TRIANGLE), Work(TRIANGLE, TRIANGLE), Rest(TRIANGLE),
    ]  # fmt: skip
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 4]


def test_a_state_is_shown_without_the_hand_where_the_film_ever_does(tmp_path: Path) -> None:
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Hold(TRIANGLE, seconds=1.5), Rest(TRIANGLE)]
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 3]


@pytest.mark.slow
def test_a_hand_that_rests_before_it_leaves_makes_no_keyframe_of_its_own(tmp_path: Path) -> None:
    shots = [
        Rest(SQUARE, 2.0), Work(SQUARE, TRIANGLE), Hold(TRIANGLE, seconds=1.5), Rest(TRIANGLE, 2.0),
        Work(TRIANGLE, HOUSE), Hold(HOUSE, at=(0.6, 0.6), seconds=1.5), Rest(HOUSE, 2.0), Hold(HOUSE),
    ]  # fmt: skip
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 3, 6]


@pytest.mark.slow
def test_of_states_seen_under_hands_the_least_covered_rest_is_taken(tmp_path: Path) -> None:
    shots = [
        Rest(SQUARE, 2.0), Work(SQUARE, HOUSE), Hold(HOUSE, at=(0.6, 0.6), seconds=1.5),
        Hold(HOUSE, at=(0.8, 0.7), seconds=1.5), Work(HOUSE, TRIANGLE), Rest(TRIANGLE, 2.0),
    ]  # fmt: skip
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 3, 5]


def test_where_hands_never_leave_no_state_is_lost(tmp_path: Path) -> None:
    states = (SQUARE, TRIANGLE, KITE, HOUSE)
    places = ((0.8, 0.7), (0.75, 0.65), (0.8, 0.6), (0.82, 0.75))
    shots = [Hold(state, at, 1.5) for state, at in zip(states, places, strict=True)]
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 1, 2, 3]


def test_where_nothing_ever_rests_the_stillest_moments_are_taken_and_marked(tmp_path: Path) -> None:
    states = (SQUARE, TRIANGLE, HOUSE)
    clip = write_clip(tmp_path / "clip.mp4", [Sway(state) for state in states], Camera(rate=15))
    report = keyframes_command(clip.path, tmp_path / "out")
    assert shots_of(clip, list(report.keyframes)) == [0, 1, 2]
    middles = [(shot.start + shot.stop) / 2 for shot in clip.shots]
    assert np.abs(np.subtract(report.keyframes, middles)).max() <= 8
    assert report.moving == report.keyframes
    told = json.loads((tmp_path / "out" / "keyframes.json").read_text())
    assert told["moving"] == list(report.keyframes)


def test_a_film_that_rests_has_no_moving_keyframes(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE)])
    assert keyframes_command(clip.path, tmp_path / "out").moving == ()
    assert "moving" not in json.loads((tmp_path / "out" / "keyframes.json").read_text())


@pytest.mark.parametrize("seconds", [0.0, -1.0, 60.0, float("nan")])
def test_a_shortest_rest_that_cannot_be_looked_for_is_refused(tmp_path: Path, seconds: float) -> None:
    with pytest.raises(PhotoError, match=r"cannot be looked for: give 0\.1 to 10"):
        propose_keyframes(tmp_path / "clip.mp4", seconds)


def test_a_manifest_whose_moving_image_is_no_keyframe_is_refused(tmp_path: Path) -> None:
    (tmp_path / "keyframes.json").write_text('{"keyframes": [1, 2], "moving": [3]}')
    with pytest.raises(PhotoError, match="'moving' lists 3, which is no keyframe"):
        load_sequence(tmp_path)


@pytest.mark.slow
def test_a_camera_that_is_nudged_makes_no_keyframe(tmp_path: Path) -> None:
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE, 3.0), Work(TRIANGLE, HOUSE), Rest(HOUSE)]
    clip = write_clip(tmp_path / "clip.mp4", shots, Camera(nudged=4.1))
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 2, 4]


@pytest.mark.slow
def test_a_state_seen_only_under_a_resting_hand_counts(tmp_path: Path) -> None:
    shots = [
        Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE),
        Work(TRIANGLE, HOUSE), Hold(HOUSE, seconds=2.0), Work(HOUSE, SQUARE), Rest(SQUARE),
    ]  # fmt: skip
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 2, 4, 6]


def test_a_state_that_returns_is_a_keyframe_again(tmp_path: Path) -> None:
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE), Work(TRIANGLE, SQUARE), Rest(SQUARE)]
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 2, 4]


@pytest.mark.slow
def test_rests_shorter_than_asked_for_are_passed_over(tmp_path: Path) -> None:
    shots = [Rest(SQUARE), Work(SQUARE, TRIANGLE), Rest(TRIANGLE, 0.5), Work(TRIANGLE, HOUSE), Rest(HOUSE)]
    clip = write_clip(tmp_path / "clip.mp4", shots)
    assert shots_of(clip, propose_keyframes(clip.path)) == [0, 2, 4]
    assert shots_of(clip, propose_keyframes(clip.path, still_seconds=0.9)) == [0, 4]


def test_a_film_that_never_rests_says_so(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    path = tmp_path / "snow.mp4"
    blocks = (random.integers(0, 255, (6, 8, 3), np.uint8).repeat(16, 0).repeat(16, 1) for _ in range(45))
    encode(path, blocks, [n / 30 for n in range(45)])
    with pytest.raises(PhotoError, match=r"nothing in snow\.mp4 lies still for 0\.4 seconds"):
        propose_keyframes(path)


def test_progress_is_told_and_ends_at_the_end(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE, 2.0)])
    told: list[float] = []
    assert len(propose_keyframes(clip.path, progress=told.append)) == 1
    assert told == sorted(told)
    assert 0.9 < told[-1] <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("folder", [pytest.param(EXAMPLES / "cup", id="cup"), *TULIP])
def test_photos_of_paper_are_told_apart_frame_by_frame(tmp_path: Path, folder: Path) -> None:
    sequence = load_sequence(folder)
    photos = [sequence.source.read(index, 320) for index in sequence.keyframes]
    frames = [
        photo if beat < 12 else np.roll(photo, 30 * beat, axis=1) for photo in photos for beat in range(18)
    ]
    encode(tmp_path / "paper.mp4", iter(frames), [n / 15 for n in range(len(frames))])
    found = propose_keyframes(tmp_path / "paper.mp4")
    assert [(index // 18, index % 18 < 12) for index in found] == [
        (frame, True) for frame in range(len(photos))
    ]


def test_a_change_of_light_or_grain_is_no_difference() -> None:
    random = np.random.default_rng(1)
    scene = np.repeat(np.linspace(60, 200, 160)[None, :, None], 120, axis=0).repeat(3, axis=2)
    first = soften((scene + random.normal(0, 3, scene.shape)).astype(np.uint8))
    second = soften((scene * 0.85 + random.normal(0, 3, scene.shape)).astype(np.uint8))
    assert solid_area(changed_pixels(first, second), 10) == 0
    second[40:60, 40:60] += 60
    assert solid_area(changed_pixels(first, second), 10) == 20 * 20


@pytest.mark.slow
def test_the_written_folder_is_a_sequence_with_images_in_between(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "boat.mp4", FOLDS[:5])
    told = DeclaredSheet(front_color="white", back_color="blue")
    report = keyframes_command(clip.path, tmp_path / "sequences" / "boat", paper=told)
    sequence = Library([tmp_path / "sequences"]).open("boat")
    assert sequence.keyframes == report.keyframes
    assert shots_of(clip, list(report.keyframes)) == [0, 2, 4]
    assert (sequence.front_color, sequence.back_color) == ("white", "blue")
    assert len(sequence.between(2)) == len(sequence.between(3)) == 5
    assert sequence.filmstrip(2).caption.startswith("5 of the images")
    assert sequence.photo(1)[120, 160].min() > 200
    assert report.seconds == pytest.approx([index / 20 for index in report.keyframes], abs=0.01)
    sheet = np.asarray(Image.open(report.contact_sheet))
    assert max(sheet.shape) <= 2000
    assert (sheet == (176, 42, 32)).all(axis=2).sum() > 3000


def test_chosen_images_are_written_as_they_are(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE, 2.0)])
    report = keyframes_command(clip.path, tmp_path / "out", indices=[3, 5, 30])
    assert report.keyframes == (3, 5, 30)
    manifest = json.loads((tmp_path / "out/keyframes.json").read_text())
    assert manifest == {"name": "clip", "frames": "frames", "keyframes": [3, 5, 30]}
    names = sorted(path.name for path in (tmp_path / "out/frames").iterdir())
    assert names[:3] == ["000003.jpg", "000004.jpg", "000005.jpg"]
    assert len(names) == 9


@pytest.mark.parametrize(
    ("indices", "paper", "sentence"),
    [
        ([], DeclaredSheet(), "no keyframes are named"),
        ([5, 5], DeclaredSheet(), "keyframes must increase, but 5 comes after 5"),
        ([5, 900], DeclaredSheet(), r"image 900 is not in clip\.mp4"),
        ([5], DeclaredSheet(front_color="reddish"), "the colour 'reddish' is not known"),
        ([5], DeclaredSheet(name="../x"), "is a path"),
    ],
)
def test_a_refused_sequence_leaves_nothing_behind(
    tmp_path: Path, indices: list[int], paper: DeclaredSheet, sentence: str
) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE)])
    with pytest.raises(PhotoError, match=sentence):
        write_sequence(clip.path, tmp_path / "out", indices, paper=paper)
    assert [path.name for path in tmp_path.iterdir()] == ["clip.mp4"]


@pytest.mark.parametrize("place", ["clip.mp4/out", "/proc/none/out"])
def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path, place: str) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE)])
    with pytest.raises(PhotoError, match="cannot be written"):
        keyframes_command(clip.path, tmp_path / place)
    assert [path.name for path in tmp_path.iterdir()] == ["clip.mp4"]


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mp4", [Rest(SQUARE)])
    with pytest.raises(PhotoError, match="already holds something: name a new or empty folder"):
        keyframes_command(clip.path, tmp_path, indices=[1])
    (tmp_path / "empty").mkdir()
    assert keyframes_command(clip.path, tmp_path / "empty", indices=[1]).keyframes == (1,)
