"""The user study: which pairs are shown, that the page tells nothing of the sides, how answers become figures."""

import json
import random
import re
import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browsers import chromium, opened
from client_runs import sequence
from folding_client.report.server_pictures import PicturedRun
from folding_client.study.rater_agreement import fleiss_kappa, krippendorff_alpha
from folding_client.study.study_questions import JointSequence, draw_questions
from folding_schemas.actions import Rotate
from playwright.sync_api import Browser, Page, expect
from report_runs import agent_run, edited, scripted_run
from test_client_commands import command

TURN_20 = [
    {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 1}}]},
    {"calls": [{"tool": "rotate", "arguments": {"angle": 20}}]},
    {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 2}}]},
    {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 3}}]},
]


def joint(name: str, frames: int) -> JointSequence:
    run = PicturedRun(Path(name), name, frames, ((Rotate(angle=1),),) * frames)
    return JointSequence(name, {"first": run, "second": run})


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two batches, ``eagle`` and ``heron``, the site of a study and its key."""
    place = tmp_path_factory.mktemp("study")
    for name in ("eagle", "heron", "truth"):
        (place / name).mkdir()
    agent_run(place / "eagle" / "plain3")
    scripted_run(place / "heron" / "plain3", TURN_20, 3)
    shutil.copytree(sequence(3), place / "truth" / "plain3")
    done = command(*made(place, place / "site"))
    assert done.returncode == 0, done.stderr
    assert "2 questions on 1 sequences" in done.stdout
    return place


def made(place: Path, out: Path, *more: object) -> tuple[object, ...]:
    return ("study", place / "eagle", place / "heron", "--truth", place / "truth", "-o", out, *more)


def key_of(place: Path) -> dict[str, Any]:
    told: dict[str, Any] = json.loads((place / "site.key.json").read_text())
    return told


@pytest.fixture(scope="module")
def browser(study: Path) -> Iterator[Browser]:
    assert study.is_dir()
    with chromium() as browser:
        yield browser


def test_questions_are_spread_over_the_sequences_and_sides_are_balanced() -> None:
    sequences = [joint("a", 3), joint("b", 21), joint("c", 9)]
    drawn = draw_questions(sequences, 20, seed=1)
    assert (
        Counter(each.sequence for each in drawn) == {"a": 2, "b": 10, "c": 8}
        or Counter(each.sequence for each in drawn)["a"] == 2
    )
    counts = Counter(each.sequence for each in drawn)
    assert abs(counts["b"] - counts["c"]) <= 2
    assert Counter(each.left for each in drawn) == {"first": 10, "second": 10}
    assert (
        len({(each.sequence, each.frame) for each in drawn}) == len({each.question for each in drawn}) == 20
    )
    assert min(each.frame for each in drawn) >= 2


def test_the_same_seed_gives_the_same_study_and_another_another() -> None:
    sequences = [joint("a", 9), joint("b", 9)]
    assert draw_questions(sequences, 9, 4) == draw_questions(sequences, 9, 4)
    assert draw_questions(sequences, 9, 4) != draw_questions(sequences, 9, 5)
    assert [each.frame for each in draw_questions(sequences, 9, 4, last_only=True)] == [9, 9]


def test_the_site_tells_nothing_of_which_side_is_whose(study: Path) -> None:
    told = "\n".join(
        file.read_text(encoding="utf-8", errors="replace")
        for file in (study / "site").rglob("*")
        if file.is_file()
    )
    key = key_of(study)
    for word in ("eagle", "heron", '"left"', "scripted", str(study)):
        assert word not in told
    assert "key" not in {file.name for file in (study / "site").iterdir()}
    assert {each["question"] for each in key["questions"]} == set(re.findall(r'data-question="(\w+)"', told))
    drawn = list((study / "site" / "media").glob("*.svg"))
    assert len(drawn) == 4
    names = [re.findall(r'src="media/(\w+)\.svg"', part) for part in told.split("data-question")[1:]]
    assert all(len(pair) == 2 for pair in names)


def test_the_key_says_truly_what_was_on_the_left(study: Path) -> None:
    page = (study / "site" / "index.html").read_text()
    (second,) = [each for each in key_of(study)["questions"] if each["frame"] == 2]
    part = page.partition(f'data-question="{second["question"]}"')[2]
    left, right = re.findall(r'src="(media/\w+\.svg)"', part)[:2]
    corners = {name: (study / "site" / name).read_text() for name in (left, right)}
    turned = (
        left if second["left"] == "first" else right
    )  # by 45 degrees: a corner of the square is above its middle
    assert corners[left] != corners[right]
    xs = [float(x) for x in re.findall(r"[ML ]([\d.]+)[ ,][\d.]+", corners[turned])]
    assert any(abs(x - 384) < 1 for x in xs), corners[turned][:400]


@pytest.mark.parametrize("more", [("--key", "site/key.json"), ()])
def test_what_cannot_be_a_study_is_refused_in_one_sentence(
    study: Path, tmp_path: Path, more: tuple[str, ...]
) -> None:
    if more:
        done = command(*made(study, tmp_path / "site", "--key", tmp_path / more[1]))
        named = "participants can read it"
    else:
        other = shutil.copytree(study / "eagle", tmp_path / "other")
        edited(other / "plain3", name="something else")
        done = command("study", other, study / "heron", "--truth", study / "truth", "-o", tmp_path / "site")
        named = "No sequence of"
    assert done.returncode == 2
    assert named in done.stderr
    assert done.stderr.count("\n") == 1


def test_two_runs_of_one_sequence_are_refused(study: Path, tmp_path: Path) -> None:
    twice = tmp_path / "twice"
    for name in "ab":
        shutil.copytree(study / "eagle" / "plain3", twice / name)
    done = command("study", twice, study / "heron", "--truth", study / "truth", "-o", tmp_path / "site")
    assert (done.returncode, "two completed runs of plain3" in done.stderr) == (2, True)


def answers(place: Path, name: str, *choices: str, **changes: Any) -> Path:
    key = key_of(place)
    given = [
        {"question": each["question"], "choice": choice, "seconds": 2.5}
        for each, choice in zip(key["questions"], choices, strict=False)
    ]
    file = place / f"{name}.json"
    file.write_text(
        json.dumps({"format": 1, "study": key["study"], "rater": name, "answers": given} | changes)
    )
    return file


def for_side(place: Path, side: str) -> list[str]:
    """The choices of somebody who always prefers one side."""
    return ["A" if each["left"] == side else "B" for each in key_of(place)["questions"]]


def test_answers_become_shares_by_the_key(study: Path) -> None:
    files = [
        answers(study, "one", *for_side(study, "first")),
        answers(study, "two", *for_side(study, "first")),
        answers(study, "three", for_side(study, "second")[0], "tie"),
    ]
    done = command("study-score", *files, "--key", study / "site.key.json", "--json")
    scores = json.loads(done.stdout)
    assert (scores["first"], scores["second"], scores["raters"], scores["judgements"]) == (
        "eagle",
        "heron",
        3,
        6,
    )
    shares = scores["shares"]
    assert [shares[name]["count"] for name in ("first", "second", "tie")] == [4, 1, 1]
    assert shares["first"]["low"] == pytest.approx(0.3000, abs=5e-4)  # Wilson's interval of 4 of 6
    assert shares["first"]["high"] == pytest.approx(0.9032, abs=5e-4)
    assert scores["by_sequence"]["plain3"]["first"]["count"] == 4
    assert scores["kappa"] is not None and scores["alpha"] is not None
    printed = command("study-score", *files, "--key", study / "site.key.json").stdout
    assert "eagle: 66.7% (4 of 6" in printed


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"study": "another"}, "not"),
        ({"format": 2}, "format"),
        ({"rater": ""}, "rater"),
        ({"answers": [{"question": "nothing", "choice": "A"}]}, "no question of this study"),
        ({"answers": [{"question": "nothing", "choice": "left"}]}, "answers.0.choice"),
        ({"answers": []}, "hold no answers"),
        ({"answers": "twice"}, "twice"),
    ],
    ids=lambda value: value if isinstance(value, str) else next(iter(value)),
)
def test_malformed_answers_are_refused_in_one_sentence(
    study: Path, changes: dict[str, Any], named: str
) -> None:
    if changes.get("answers") == "twice":
        question = key_of(study)["questions"][0]["question"]
        changes = {"answers": [{"question": question, "choice": "A"}] * 2}
    file = answers(study, "wrong", "A", "B", **changes)
    done = command("study-score", file, "--key", study / "site.key.json")
    assert done.returncode == 2
    assert named in done.stderr
    assert done.stderr.count("\n") == 1


def test_one_participant_counts_once_and_a_key_is_a_key(study: Path) -> None:
    one = answers(study, "same", "A", "B")
    again = shutil.copy(one, study / "again.json")
    for words, named in (
        ((one, again, "--key", study / "site.key.json"), "both of the participant 'same'"),
        ((one, "--key", one), "cannot be read"),
        ((study / "none.json", "--key", study / "site.key.json"), "Cannot read"),
    ):
        done = command("study-score", *words)
        assert (done.returncode, named in done.stderr, done.stderr.count("\n")) == (2, True, 1), done.stderr


FLEISS = """0 0 0 0 14
0 2 6 4 2
0 0 3 5 6
0 3 9 2 0
2 2 8 1 1
7 7 0 0 0
3 2 6 3 0
2 5 3 2 2
6 5 2 1 0
0 2 2 3 7"""
"""Counts of five categories by 14 raters for ten items: the example of Fleiss' kappa in reference works, 0.210."""
KRIPPENDORFF = (
    "1 2 3 3 2 1 4 1 2 . . .",
    "1 2 3 3 2 2 4 1 2 5 . 3",
    ". 3 3 3 2 3 4 2 2 5 1 .",
    "1 2 3 3 2 4 4 1 2 5 1 .",
)
"""Four observers and twelve units with missing values: example C of Krippendorff (2011), nominal alpha 0.743."""


def test_kappa_is_that_of_the_published_example() -> None:
    ratings = [
        [category for category, count in enumerate(map(int, line.split())) for _ in range(count)]
        for line in FLEISS.splitlines()
    ]
    assert fleiss_kappa(ratings) == pytest.approx(0.210, abs=5e-4)


def test_alpha_is_that_of_the_published_example() -> None:
    units = [
        [value for value in column if value != "."]
        for column in zip(*(line.split() for line in KRIPPENDORFF), strict=True)
    ]
    assert krippendorff_alpha(units) == pytest.approx(0.743, abs=5e-4)


def test_agreement_is_1_when_all_agree_near_0_by_chance_and_undefined_without_two_answers() -> None:
    agree = [["A"] * 3, ["B"] * 3, ["tie"] * 3]
    assert fleiss_kappa(agree) == pytest.approx(1)
    assert krippendorff_alpha(agree) == pytest.approx(1)
    chance = random.Random(3)
    drawn = [[chance.choice("ABt") for _ in range(5)] for _ in range(2000)]
    assert fleiss_kappa(drawn) == pytest.approx(0, abs=0.03)
    assert krippendorff_alpha(drawn) == pytest.approx(0, abs=0.03)
    for nothing in ([], [["A"], ["B"]], [["A", "A"], ["A", "A"]]):
        assert fleiss_kappa(nothing) is None
        assert krippendorff_alpha(nothing) is None
    assert fleiss_kappa([["A", "B"], ["A"]]) is None


def look(page: Page, study: Path) -> None:
    page.goto((study / "site" / "index.html").as_uri())


def faults(page: Page) -> list[str]:
    return [each["id"] for each in Axe().run(page, options={"preload": False}).response["violations"]]


def test_a_study_is_answered_by_keyboard_kept_and_saved(
    browser: Browser, study: Path, tmp_path: Path
) -> None:
    with opened(browser, viewport={"width": 390, "height": 844}, color_scheme="dark") as page:
        look(page, study)
        assert faults(page) == []
        page.get_by_role("button", name="Begin").click()
        expect(page.get_by_text("Question 1 of 2")).to_be_visible()
        assert faults(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.keyboard.down("ArrowLeft")
        page.keyboard.down("ArrowLeft")  # held down, it repeats itself, and answers one question nevertheless
        page.keyboard.up("ArrowLeft")
        expect(page.get_by_text("Question 2 of 2")).to_be_visible()
        page.keyboard.press("Backspace")
        expect(page.locator(".question:visible [aria-pressed=true]")).to_have_text("A is closer")
        page.keyboard.press("b")
        page.reload()
        page.get_by_role("button", name="Go on").click()
        expect(page.get_by_text("Question 2 of 2")).to_be_visible()
        page.keyboard.press("t")
        page.get_by_label("Your name or a code").fill("Ada <b>")
        with page.expect_download() as saving:
            page.get_by_role("button", name="Save answers").click()
        saving.value.save_as(tmp_path / "answers.json")
        assert faults(page) == []
        page.get_by_role("button", name="Next participant").click()
        expect(page.get_by_role("button", name="Begin")).to_be_visible()
    told = json.loads((tmp_path / "answers.json").read_text())
    assert [each["choice"] for each in told["answers"]] == ["B", "tie"]
    assert told["rater"] == "Ada <b>"
    done = command("study-score", tmp_path / "answers.json", "--key", study / "site.key.json")
    assert done.returncode == 0, done.stderr
    assert "judgements 2, participants 1, questions 2" in done.stdout


@pytest.mark.slow
def test_axe_finds_nothing_in_the_light(browser: Browser, study: Path) -> None:
    with opened(browser, viewport={"width": 1280, "height": 800}, color_scheme="light") as page:
        look(page, study)
        page.get_by_role("button", name="Begin").click()
        page.get_by_role("button", name="Tie").first.click()
        assert faults(page) == []
