"""Photographing programs: what is written is a sequence, the truth agrees with the pixels, mistakes get one
sentence.
"""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from folding_schemas.actions import AddVertex, Flip, Fold, Program, Rotate, Unfold
from folding_server.errors import FoldingError, PhotoError, ProgramError
from folding_server.frames.sequences import load_sequence
from folding_server.photographer import photograph
from folding_server.photographer.color_spaces import linear_color, to_linear
from folding_server.photographer.imprecision import imprecise
from folding_server.photographer.levels import LEVELS
from folding_server.photographer.replaying import keyframe_papers
from paths import ROOT
from PIL import Image

SIZE = (240, 240)
HALF = Program(
    name="half",
    front_color="#f4f2ec",
    back_color="#2f6fb4",
    steps=(
        (Rotate(angle=45),),
        (Fold(edge=(4, 2), direction=-1),),
        (Unfold(),),
        (
            AddVertex(edge=(4, 1), position=0.3),
            AddVertex(edge=(1, 2), position=0.7),
            Fold(edge=(5, 6), direction=1),
        ),
        (Flip(axis="x"),),
    ),
)


Photographed = Callable[..., Path]
"""Seed, and level and size where they are not the usual ones, to the folder with the photos."""


@pytest.fixture(scope="session")
def photographed(tmp_path_factory: pytest.TempPathFactory) -> Photographed:
    """The program photographed once for all tests that look at the same photos of it; they change none."""

    @cache
    def take(seed: int, level: int = 1, size: tuple[int, int] = SIZE) -> Path:
        return photograph(HALF, tmp_path_factory.mktemp("half"), seed, level, size).folder

    return take


def truth_of(folder: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((folder / "truth.json").read_text())
    return loaded


def outlines(frame: dict[str, Any]) -> list[tuple[int, np.ndarray[Any, Any]]]:
    """(orientation, pixel outline) of the faces, bottom to top, from the truth alone."""
    return [
        (
            frame["orientations"][str(f)],
            np.array([frame["vertex_pixels"][str(v)] for v in frame["faces"][str(f)]]),
        )
        for f in frame["order"]
    ]


def sides(frame: dict[str, Any], size: tuple[int, int]) -> np.ndarray[Any, Any]:
    """Labels 0 table, 1 front, 2 back painted from the truth alone."""
    labels = np.zeros(size[::-1], np.uint8)
    for back, outline in outlines(frame):
        cv2.fillConvexPoly(labels, np.rint((outline - 0.5) * 16).astype(np.int32), 1 + back, cv2.LINE_8, 4)
    return labels


def looks(picture: np.ndarray[Any, Any], scene: dict[str, Any]) -> np.ndarray[Any, Any]:
    """Labels 0 table, 1 front, 2 back by the nearest of the scene's colours."""
    colors = np.array([linear_color(scene[key]) for key in ("table_color", "front", "back")])
    distance = np.linalg.norm(np.cbrt(to_linear(picture))[:, :, None] - np.cbrt(colors), axis=-1)
    return np.asarray(np.argmin(distance, axis=-1), np.uint8)


def picture_of(folder: Path, frame: dict[str, Any]) -> np.ndarray[Any, Any]:
    with Image.open(folder / frame["image"]) as image:
        return np.asarray(image)


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_photographed_program_is_a_sequence(tmp_path: Path) -> None:
    result = photograph(HALF, tmp_path / "half", seed=1, size=SIZE)
    sequence = load_sequence(tmp_path / "half")
    assert (result.frames, sequence.frame_count, sequence.name) == (6, 6, "half")
    assert sequence.photo(6).shape == (240, 240, 3)


@pytest.mark.slow
@pytest.mark.parametrize("level", sorted(LEVELS))
def test_the_same_seed_gives_the_same_files_and_another_seed_others(tmp_path: Path, level: int) -> None:
    short = HALF.model_copy(update={"steps": HALF.steps[:2]})
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        photograph(short, tmp_path / name, seed, level, SIZE)
    first, again, other = (files(tmp_path / name) for name in "abc")
    assert first == again
    photos = [name for name in first if name.endswith(".jpg")]
    assert photos == [name for name in other if name.endswith(".jpg")]
    assert all(first[name] != other[name] for name in photos)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_every_pixel_of_level_1_shows_the_side_that_the_truth_says(
    photographed: Photographed, seed: int
) -> None:
    folder = photographed(seed)
    truth = truth_of(folder)
    for frame in truth["frames"]:
        agree = looks(picture_of(folder, frame), truth["scene"]) == sides(frame, SIZE)
        assert agree.mean() > 0.985, frame["frame"]


@pytest.mark.parametrize(("level", "seed"), [(2, 1), (2, 4), (3, 2)])
def test_faces_show_their_side_at_harder_levels(tmp_path: Path, level: int, seed: int) -> None:
    photograph(HALF, tmp_path, seed, level, (400, 400))
    truth = truth_of(tmp_path)
    front, back = (np.cbrt(linear_color(truth["scene"][key])) for key in ("front", "back"))
    for frame in truth["frames"]:
        if frame["hand"] is None:
            top = outlines(frame)[-1]
            x, y = top[1].mean(0).astype(int)
            patch = picture_of(tmp_path, frame)[y - 6 : y + 7, x - 6 : x + 7].reshape(-1, 3).mean(0)
            seen = np.cbrt(to_linear(patch))
            assert (np.linalg.norm(seen - back) < np.linalg.norm(seen - front)) == bool(top[0])


def test_the_homography_takes_folded_places_to_the_vertex_pixels(photographed: Photographed) -> None:
    for frame in truth_of(photographed(3, 2, (400, 400)))["frames"]:
        homography = np.array(frame["camera"]["folded_to_pixel"])
        for v, vertex in frame["vertices"].items():
            x, y, w = homography @ [*vertex["folded"], 1]
            assert np.hypot(x / w - frame["vertex_pixels"][v][0], y / w - frame["vertex_pixels"][v][1]) < 0.5


def test_the_camera_matrices_agree_with_each_other(photographed: Photographed) -> None:
    camera = truth_of(photographed(3, 2, (400, 400)))["frames"][2]["camera"]
    K, R, t = (np.array(camera[key]) for key in "KRt")
    table = K @ np.column_stack([R[:, 0], R[:, 1], t])
    assert np.allclose(table / table[2, 2], camera["table_to_pixel"], atol=1e-3)
    folded = np.array(camera["table_to_pixel"]) @ [*camera["folded_to_table"], [0, 0, 1]]
    assert np.allclose(folded / folded[2, 2], camera["folded_to_pixel"], atol=1e-3)


@pytest.mark.parametrize("size", [(320, 200), (200, 320)])
def test_pictures_have_the_size_asked_for_and_hold_the_whole_paper(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    photograph(HALF, tmp_path, 2, 2, size)
    for frame in truth_of(tmp_path)["frames"]:
        assert picture_of(tmp_path, frame).shape == (size[1], size[0], 3)
        pixels = np.array(list(frame["vertex_pixels"].values()))
        assert (pixels > 0).all()
        assert (pixels < size).all()


def test_a_flip_about_the_falling_diagonal_leaves_the_paper_on_its_place(tmp_path: Path) -> None:
    photograph(
        Program(name="over", steps=((Flip(axis="y=-x"),), (Rotate(angle=30),))), tmp_path, 1, size=SIZE
    )
    middles = [np.mean(list(f["vertex_pixels"].values()), axis=0) for f in truth_of(tmp_path)["frames"]]
    assert np.abs(np.diff(middles, axis=0)).max() < 10


def test_hands_hide_what_the_truth_says_and_nothing_of_the_first_frame(tmp_path: Path) -> None:
    photograph(HALF, tmp_path, 4, 3, (400, 400))
    truth = truth_of(tmp_path)
    hidden = [frame for frame in truth["frames"] if frame["hand"] is not None]
    assert truth["frames"][0]["hand"] is None
    assert len(hidden) >= 2
    for frame in hidden:
        paper = sides(frame, (400, 400)) > 0
        wrong = (looks(picture_of(tmp_path, frame), truth["scene"]) != sides(frame, (400, 400)))[paper]
        assert 0 < frame["hand"]["cover"] <= 0.2
        assert wrong.mean() > 0.3 * frame["hand"]["cover"]
        mask = cv2.imread(str(tmp_path / frame["hand"]["mask"]), cv2.IMREAD_GRAYSCALE)
        assert (mask[paper] == 255).mean() == pytest.approx(frame["hand"]["cover"], abs=0.02)


def test_level_3_writes_the_imprecise_program_that_was_folded(tmp_path: Path) -> None:
    photograph(HALF, tmp_path, 8, 3, SIZE)
    folded = Program.model_validate_json((tmp_path / "program.json").read_text())
    paper = keyframe_papers(folded)[-1]
    last = truth_of(tmp_path)["frames"][-1]
    assert folded.steps != HALF.steps
    assert folded.sheet != (1.0, 1.0)
    assert list(paper.order) == last["order"]
    for v, place in paper.folded_vertices_coords.items():
        assert last["vertices"][str(v)]["folded"] == pytest.approx(place, abs=2e-6)


@pytest.mark.parametrize("seed", range(8))
def test_imprecision_stays_within_its_bounds(seed: int) -> None:
    real = imprecise(HALF, seed, LEVELS[3])
    assert abs(real.sheet[1] - 1) <= 0.01
    for exact, off in zip(HALF.steps[3][:2], real.steps[3][:2], strict=True):
        assert isinstance(exact, AddVertex)
        assert isinstance(off, AddVertex)
        assert abs(exact.position - off.position) <= 0.0102


def test_truth_repeats_the_actions_with_their_places_on_the_sheet(photographed: Photographed) -> None:
    step = truth_of(photographed(1))["frames"][4]["step"]
    assert [a["action"] for a in step] == ["add_vertex", "add_vertex", "fold"]
    assert step[0]["at"] == [[0, 0], [0, 1]]
    assert step[2]["at"] == [[0, 0.3], [0.7, 1]]


def test_photographing_again_leaves_no_photos_of_the_longer_program(tmp_path: Path) -> None:
    photograph(HALF, tmp_path, 1, size=SIZE)
    photograph(HALF.model_copy(update={"steps": HALF.steps[:1]}), tmp_path, 1, size=SIZE)
    assert [p.name for p in sorted((tmp_path / "frames").iterdir())] == ["000001.jpg", "000002.jpg"]


def test_progress_is_told_after_each_frame(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    photograph(HALF, tmp_path, 1, size=SIZE, progress=lambda done, of: told.append((done, of)))
    assert told == [(k, 6) for k in range(1, 7)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"level": 5}, "no level 5; choose 1"),
        ({"level": 0}, "no level 0; choose 1"),
        ({"seed": -1}, "seed -1 is negative"),
        ({"size": (10, 240)}, "size 10x240 cannot be used; give a width and height from 64 to 4096"),
    ],
)
def test_settings_that_cannot_be_used_get_one_sentence(
    tmp_path: Path, arguments: dict[str, Any], words: str
) -> None:
    with pytest.raises(PhotoError, match=words) as refusal:
        photograph(HALF, tmp_path / "new", **{"seed": 1, "size": SIZE, **arguments})
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "new").exists()


def test_a_program_that_cannot_be_folded_names_step_action_and_reason(tmp_path: Path) -> None:
    bad = HALF.model_copy(update={"steps": (*HALF.steps, (Fold(edge=(2, 99), direction=1),))})
    with pytest.raises(
        ProgramError, match=r"Step 6 of half cannot be folded: fold\(\[2, 99\], 1\).*no vertex 99"
    ):
        photograph(bad, tmp_path / "new", 1, size=SIZE)
    assert not (tmp_path / "new").exists()


def test_a_colour_that_is_not_known_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FoldingError, match="plaid"):
        photograph(HALF.model_copy(update={"back_color": "plaid"}), tmp_path / "new", 1, size=SIZE)


def test_folders_that_are_not_ours_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "keyframes.json").write_text("{}")
    with pytest.raises(PhotoError, match="is a file; give a folder"):
        photograph(HALF, tmp_path / "file", 1, size=SIZE)
    with pytest.raises(PhotoError, match="was not made here"):
        photograph(HALF, tmp_path / "theirs", 1, size=SIZE)
    assert (tmp_path / "theirs" / "keyframes.json").read_text() == "{}"


@pytest.mark.parametrize("name", ["notes.txt", "frames/holiday.jpg"])
def test_a_folder_with_files_of_others_is_refused_and_stays_as_it_is(tmp_path: Path, name: str) -> None:
    photograph(HALF.model_copy(update={"steps": ()}), tmp_path, 1, size=SIZE)
    (tmp_path / name).write_text("mine")
    before = files(tmp_path)
    with pytest.raises(PhotoError, match=rf"holds {name}, .*give a new or empty folder"):
        photograph(HALF, tmp_path, 1, size=SIZE)
    assert files(tmp_path) == before


def test_a_folder_of_other_things_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    with pytest.raises(PhotoError, match="holds frames, .*give a new or empty folder"):
        photograph(HALF, tmp_path, 1, size=SIZE)
    assert not any((tmp_path / "frames").iterdir())


def test_imprecise_folds_move_the_same_side_where_an_upright_line_leans() -> None:
    upright = (AddVertex(edge=(1, 2), position=0.5), AddVertex(edge=(3, 4), position=0.5))
    book = Program(name="book", steps=((*upright, Fold(edge=(5, 6), direction=-1)),))
    for seed in range(6):
        real = imprecise(book, seed, LEVELS[3])
        moved = keyframe_papers(real)[-1].folded_vertices_coords
        assert real.steps != book.steps
        assert moved[1] == pytest.approx((1, 1), abs=0.05)


def test_imprecision_leaves_most_models_what_they_are() -> None:
    folder = ROOT / "benchmarks" / "reconstruction" / "programs"
    programs = [Program.model_validate_json(path.read_text()) for path in sorted(folder.glob("*.json"))]
    changed = 0
    for program in programs:
        real = imprecise(program, 3, LEVELS[3])
        exact, found = keyframe_papers(program)[-1], keyframe_papers(real)[-1]
        corners = [
            np.hypot(*np.subtract(exact.folded_vertices_coords[v], found.folded_vertices_coords[v]))
            for v in (1, 2, 3, 4)
        ]
        assert max(corners) < 0.13, program.name
        changed += real != program
    assert changed >= 0.9 * len(programs)
