"""Films of folding: the end of each movement is the state, no paper goes through paper, and the files can be played."""

import re
from itertools import pairwise
from math import dist
from pathlib import Path

import numpy as np
import pytest
from browsers import chromium, opened
from commands_here import run_here
from folding_server.animation.film import FilmForm, FilmMoment, LessonFilm, eased, film_moments
from folding_server.animation.film_camera import FilmCamera
from folding_server.animation.film_files import write_film
from folding_server.animation.scenes import LAYER_GAP, faces_in_space, film_scenes, middle_of
from folding_server.geometry.convex import overlap
from folding_server.instructions.moves import Lesson, lesson_of
from folding_server.interchange.programs import load_published
from paths import EXAMPLES
from PIL import Image
from playwright.sync_api import Browser, Page

NAMES = ("cat", "cup", "heart")


def lesson_named(name: str) -> Lesson:
    return lesson_of(load_published((EXAMPLES / "programs" / f"{name}.json").read_text()).program)


def words_of(lesson: Lesson) -> list[str]:
    return [f"Words {i}." for i in range(len(lesson.moves) + 1)]


@pytest.mark.parametrize("name", NAMES)
def test_the_end_of_each_movement_is_the_state_that_is_drawn(name: str) -> None:
    for scene in film_scenes(lesson_named(name)):
        for part, paper in ((1.0, scene.after), (0.0, scene.before)):
            x, y = middle_of(paper)
            for each in faces_in_space(scene, part):
                if part == 1.0 and scene.swing is not None:
                    assert len(each.corners) == len(paper.faces[each.face])
                    for corner, at in zip(each.corners, paper.polygon(each.face), strict=True):
                        assert dist(corner[:2], (at[0] - x, at[1] - y)) < 1e-9
            drawn = {
                tuple(np.round(corner[:2], 4) + 0.0)
                for each in faces_in_space(scene, part)
                for corner in each.corners
            }
            there = {
                (round(a - x, 4) + 0.0, round(b - y, 4) + 0.0)
                for a, b in paper.folded_vertices_coords.values()
            }
            assert there <= drawn


@pytest.mark.parametrize("name", NAMES)
def test_no_paper_goes_through_paper(name: str) -> None:
    """On the way, what moves is over what stays wherever one covers the other, or under it throughout."""
    for scene in film_scenes(lesson_named(name)):
        for part in (0.1, 0.35, 0.5, 0.8, 0.95):
            faces = faces_in_space(scene, part)
            moving, resting = ([f for f in faces if f.moves is moves] for moves in (True, False))
            sign = 1 if scene.swing and scene.swing.over else -1
            for flap in moving:
                lowest = min(sign * flap.corners[:, 2])
                for below in resting:
                    if overlap(
                        [tuple(c[:2]) for c in flap.corners], [tuple(c[:2]) for c in below.corners], 0.02
                    ):
                        assert lowest >= min(sign * below.corners[:, 2]) - 2 * LAYER_GAP


def test_movements_start_and_end_slowly() -> None:
    steps = np.diff([eased(i / 10) for i in range(11)])
    assert eased(0) == 0 and eased(1) == 1
    assert steps[0] < steps[4] > steps[-1]


def test_a_flap_half_way_shows_what_the_eye_sees() -> None:
    """Seen from above, a flap that is lifted less than upright still shows its first side, then its other."""
    lesson = lesson_named("cup")
    film = LessonFilm(lesson, words_of(lesson), FilmForm(320, 240, view="straight"))
    (number,) = [i for i, scene in enumerate(film.scenes) if scene.move == 1]
    before, after = (
        {face.face: face.back_seen for face in film.seen(FilmMoment(number, part, 1))[1]}
        for part in (0.3, 0.7)
    )
    moved = set(film.scenes[number].swing.starts)  # type: ignore[union-attr]
    assert {face for face in before if before[face] != after[face]} == moved


def test_paint_is_where_the_paper_is() -> None:
    lesson = lesson_named("cat")
    film = LessonFilm(lesson, words_of(lesson), FilmForm(320, 240, view="straight"))
    picture = film.picture(FilmMoment(None, 1.0, None))
    assert picture.shape == (240, 320, 3)
    paper, faces = film.seen(FilmMoment(None, 1.0, None))
    inside = faces[-1].outline.mean(axis=0).astype(int)
    assert tuple(picture[inside[1], inside[0]]) != (255, 255, 255)
    assert tuple(picture[2, 2]) == (255, 255, 255)
    assert len(faces) == len(paper.faces)


def test_an_eye_straight_above_sees_the_table_as_it_is() -> None:
    camera = FilmCamera(100.0, (160.0, 120.0), 0.0)
    assert camera.pixels(np.array([[0.5, 0.25, 0.0]])).tolist() == [[210.0, 95.0]]


def test_a_film_begins_and_ends_with_the_finished_model() -> None:
    scenes = film_scenes(lesson_named("cat"))
    moments = list(film_moments(scenes, 10))
    assert moments[0].scene is None and moments[-1].scene is None
    for number in range(len(scenes)):
        assert [m.part for m in moments if m.scene == number][-1] == 1.0


def short(name: str) -> Lesson:
    """The first steps of an example."""
    program = load_published((EXAMPLES / "programs" / f"{name}.json").read_text()).program
    return lesson_of(program.model_copy(update={"steps": program.steps[:2]}))


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".mp4", ".webm"])
def test_a_video_can_be_played(ending: str, tmp_path: Path) -> None:
    import av

    write_film(short("cat"), words_of(short("cat")), tmp_path / f"film{ending}", "tilted")
    with av.open(str(tmp_path / f"film{ending}")) as film:
        pictures = list(film.decode(video=0))
    assert (pictures[0].width, pictures[0].height) == (1280, 720)
    moments = list(film_moments(film_scenes(short("cat")), FilmForm().rate))
    assert len(pictures) == 2 + sum(first != second for first, second in pairwise(moments))
    assert float(pictures[-1].time) == pytest.approx((len(moments) - 1) / FilmForm().rate, abs=0.01)


@pytest.mark.slow
def test_a_gif_can_be_played(tmp_path: Path) -> None:
    write_film(short("cat"), words_of(short("cat")), tmp_path / "film.gif", "straight")
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames > 20


def test_the_command_refuses_other_files_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done = run_here(capsys, "animate", EXAMPLES / "programs" / "cat.json", "-o", tmp_path / "cat.avi")
    assert (done.code, "'.avi'" in done.err, ".mp4" in done.err) == (1, True, True)


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("film") / "cat.html"
    write_film(lesson_named("cat"), words_of(lesson_named("cat")), file, "straight")
    return file


def outlines(page: Page) -> list[list[tuple[float, float]]]:
    found = page.evaluate("[...document.querySelectorAll('polygon')].map(e => e.getAttribute('points'))")
    return [[tuple(map(float, pair.split(","))) for pair in text.split()] for text in found]


class TestPage:
    def test_it_steps_without_motion_for_who_wants_none(self, browser: Browser, page_file: Path) -> None:
        with opened(browser, reduced_motion="reduce") as page:
            page.goto(page_file.as_uri())
            seen = [page.inner_text("#words")]
            for _ in range(9):
                page.get_by_role("button", name="Next").click()
                seen.append(page.inner_text("#words"))
        assert seen[0] == "1. Words 0." and seen[-1] == "8. Words 7."
        assert seen[2] == seen[3] == "3. Words 2."  # folded, and unfolded again

    def test_its_states_are_those_of_the_film(self, browser: Browser, page_file: Path) -> None:
        lesson = lesson_named("cat")
        with opened(browser, reduced_motion="reduce") as page:
            page.goto(page_file.as_uri())
            page.get_by_role("button", name="Last").click()
            drawn = outlines(page)
        x, y = middle_of(lesson.final)
        wanted = [[(a - x, y - b) for a, b in lesson.final.polygon(face)] for face in lesson.final.order]
        scale = max(abs(a) for outline in drawn for a, _ in outline) / max(
            abs(a) for outline in wanted for a, _ in outline
        )
        flat = sorted((round(a, 1), round(b, 1)) for outline in wanted for a, b in outline)
        seen = sorted((round(a / scale, 1), round(b / scale, 1)) for outline in drawn for a, b in outline)
        assert np.abs(np.array(flat) - np.array(seen)).max() < 0.15

    def test_it_says_in_words_what_it_shows_and_loads_nothing(
        self, browser: Browser, page_file: Path
    ) -> None:
        with opened(browser) as page:
            page.goto(page_file.as_uri())
            assert page.evaluate("picture.getAttribute('aria-labelledby')") == "words"
            assert page.evaluate("words.getAttribute('aria-live')") == "polite"
        addresses = set(re.findall(r"https?://[^\s\"'<)]+", page_file.read_text()))
        assert addresses == {"http://www.w3.org/2000/svg"}
