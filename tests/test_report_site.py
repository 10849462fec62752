"""The site of recorded runs: what is on its pages, for runs of every sort, and what it is built from."""

import asyncio
import json
import re
import shutil
import socket
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from client_runs import shortened
from folding_client.interrupts import UsageError
from folding_client.report.attempt_tree import AttemptTree
from folding_client.report.frame_reports import MOST_FRAMES, usage_by_frame
from folding_client.report.recorded_runs import RunPlace, find_runs, read_run
from folding_client.report.run_pages import MOST_IN_ROW, gather_page
from folding_client.report.run_scores import Evaluations
from folding_client.report.site import ReportOptions, SiteBuilder
from folding_client.report.trace import LONGEST_TEXT, Trace
from paths import ROOT
from report_runs import HOSTILE_NAME, edited, many_sorts
from test_client_commands import TURN, command, script
from test_client_commands import save as saves

RECORDED = ReportOptions(server=False)


def build(out: Path, *roots: Path, options: ReportOptions = RECORDED) -> SiteBuilder:
    builder = SiteBuilder(roots, out, options, lambda _: None)
    asyncio.run(builder.build())
    return builder


def page_of(site: Path, name: str) -> str:
    (page,) = site.glob(f"runs/*-{name}-??????.html")
    return page.read_text(encoding="utf-8")


def words_of(page: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return many_sorts(tmp_path_factory.mktemp("batch"))


@pytest.fixture(scope="module")
def site(runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "site"
    build(out, runs)
    return out


def test_every_run_has_a_row_and_a_page_whatever_became_of_it(runs: Path, site: Path) -> None:
    overview = (site / "index.html").read_text(encoding="utf-8")
    assert overview.count("<article") == len(list(runs.iterdir())) == 5
    links = re.findall(r'<h3[^>]*><a href="([^"#]+)"', overview)
    assert sorted(links) == sorted(f"runs/{page.name}" for page in (site / "runs").iterdir())


def test_a_run_that_stopped_says_why_and_which_frames_it_lacks(site: Path) -> None:
    page = words_of(page_of(site, "stopped"))
    assert "The run ended early" in page
    assert "Frames without a solution: 4." in page


def test_a_damaged_record_says_what_is_damaged_and_shows_the_rest(site: Path) -> None:
    page = words_of(page_of(site, "damaged"))
    assert "run.json is damaged" in page
    assert "Lines of events.jsonl that are no event: 6." in page
    assert "Events 6 to 7 are missing from events.jsonl." in page
    assert "rotate(45.0)" in page


def test_predicted_crease_patterns_are_drawn(site: Path) -> None:
    page = next(text for p in (site / "runs").iterdir() if "vlm-cp" in (text := p.read_text()))
    drawn = set(re.findall(r'src="\.\./(media/[0-9a-f]+\.svg)" alt="Crease pattern at frame', page))
    assert len(drawn) == 2  # the flat sheet, and one that was predicted twice
    assert any("#1f5fd0" in (site / name).read_text() for name in drawn)
    assert "a predicted crease pattern" in page
    assert "Frames without a solution" not in page


def test_nothing_of_a_model_or_a_name_becomes_markup(site: Path) -> None:
    for page in (site / "index.html", *(site / "runs").iterdir()):
        text = page.read_text(encoding="utf-8")
        assert "<script>document" not in text
        assert "<img src=x" not in text
    assert "&lt;script&gt;document" in page_of(site, "plain3")
    names = [page.name for page in (site / "runs").iterdir()]
    assert all(re.fullmatch(r"[a-z0-9-]+\.html", name) for name in names)


def test_pages_forbid_everything_but_their_own_files(site: Path) -> None:
    for page in (site / "index.html", *(site / "runs").iterdir()):
        text = page.read_text(encoding="utf-8")
        policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', text)
        assert policy is not None
        assert policy[1].startswith("default-src 'none'; img-src 'self'; style-src 'self'; script-src 'self'")
        assert "connect-src 'none'" in policy[1]
        assert not re.search(r'(?:src|href)="(?:https?:)?//', text)
        assert "style=" not in text


def test_every_file_that_a_page_names_is_there(site: Path) -> None:
    for page in (site / "index.html", *(site / "runs").iterdir()):
        for name in re.findall(r'(?:src|href)="([^"#]+)', page.read_text(encoding="utf-8")):
            assert (page.parent / name).is_file(), (page.name, name)


def test_every_picture_has_words(site: Path) -> None:
    for page in (site / "index.html", *(site / "runs").iterdir()):
        assert re.findall(r"<img(?![^>]*\balt=)[^>]*>", page.read_text(encoding="utf-8")) == []


def test_files_are_there_to_download(runs: Path, site: Path) -> None:
    names = re.findall(r'href="\.\./(files/[^"]+)" download', page_of(site, "plain3"))
    assert {"program.json", "final.fold", "events.jsonl"} <= {Path(name).name for name in names}
    program = next(site / name for name in names if name.endswith("program.json"))
    assert program.read_bytes() == (runs / "plain3" / "program.json").read_bytes()


def test_the_attempts_are_a_tree_in_which_what_was_given_up_is_a_branch(runs: Path) -> None:
    run = read_run(RunPlace(runs / "plain3", "batch", "plain3"))
    tree = AttemptTree(run.events, run.run_id)
    (second, instead), (third, nothing) = tree.line(tree.root)
    assert [action.action for action in second.actions] == ["rotate"]
    assert (second.attempt, second.verdict, tree.is_saved(second)) == (2, "MATCH", True)
    (wrong,) = instead
    assert (wrong.attempt, wrong.verdict, wrong.outcome) == (1, "MISMATCH", "given up")
    assert (third.frame, nothing, third.parent) == (3, [], second)
    assert {frame: len(saved.actions) for frame, saved in tree.saved.items()} == {1: 0, 2: 1, 3: 1}


def test_the_trace_nests_the_critic_in_the_query_that_asked_it(runs: Path) -> None:
    steps = Trace(read_run(RunPlace(runs / "plain3", "batch", "plain3")).events).steps
    towards = next(step for step in steps if step.frame == 2)
    asking = [entry for entry in towards.entries if entry.gist.startswith("ask_critic")]
    assert [[child.title for child in entry.entries] for entry in asking] == [
        ["critic_grid", "critic", "verdict", "get_run"]
    ] * 2
    refused = asking[0].entries[2]
    assert (refused.kind, refused.tone) == ("event", "bad")
    assert asking[1].entries[2].tone == "good"
    assert not any(entry.title == "critic" for entry in towards.entries)


def test_what_was_shown_before_is_referred_to_and_long_texts_are_cut(runs: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(runs / "plain3", tmp_path / "long")
    lines = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    reply = next(line for line in lines if line["kind"] == "reply")
    reply["text"] = "x" * (LONGEST_TEXT + 7)
    (folder / "events.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    steps = Trace(read_run(RunPlace(folder, "batch", "long")).events).steps
    texts = [text for step in steps for entry in step.entries for text in entry.texts]
    assert any(text.text.endswith("[7 more characters are in events.jsonl]") for text in texts)
    system = [text for text in texts if text.heading == "system message"]
    assert system[0].text and all(text.shown_at and not text.text for text in system[1:])


def test_usage_by_frame_adds_up_to_the_run(runs: Path) -> None:
    run = read_run(RunPlace(runs / "plain3", "batch", "plain3"))
    assert run.about is not None
    by_frame = usage_by_frame(run.events).values()
    totals = run.about.totals.values()
    assert sum(usage.queries for usage in by_frame) == sum(each.queries for each in totals)
    assert sum(usage.tokens for usage in by_frame) == sum(
        each.input_tokens + each.output_tokens for each in totals
    )
    assert sum(usage.seconds for usage in by_frame) <= run.about.outcome.seconds


def test_only_what_changed_is_written_again(runs: Path, tmp_path: Path) -> None:
    place = shutil.copytree(runs, tmp_path / "batch")
    builder = build(tmp_path / "site", place)
    assert asyncio.run(builder.build()) == []
    edited(place / "plain3", decided={"2": "somebody else"})
    changed = asyncio.run(builder.build())
    assert [name.partition("-")[0] for name in changed] == ["runs/plain3"]
    shutil.copytree(place / "plain3", place / "another")
    assert sorted(name.partition("-")[0] for name in asyncio.run(builder.build())) == [
        "index.html",
        "runs/plain3",
    ]


@pytest.mark.slow
def test_the_server_draws_what_the_record_lacks(tmp_path: Path) -> None:
    cat = shortened(ROOT / "examples" / "cat", tmp_path / "cat", 2)
    model = script(tmp_path, [saves(1)], [TURN, saves(2)])
    done = command("run", cat, "--model", model, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    build(tmp_path / "site", tmp_path / "run", options=ReportOptions())
    page = page_of(tmp_path / "site", "run")
    shown = re.findall(r'<img src="\.\./media/[0-9a-f]+\.(\w+)" alt="([A-Z]\w+)[^"]* frame (\d)', page)
    assert {(kind, suffix, frame) for suffix, kind, frame in shown} == {
        *(("Photo", "jpg", frame) for frame in "12"),
        *(("Diagram", "svg", frame) for frame in "12"),
        *(("Crease", "svg", frame) for frame in "12"),
        ("Outline", "jpg", "2"),
    }
    assert "Pictures are missing" not in page
    thumbnails = re.findall(r'src="(media/[^"]+)" alt="Photo \d', (tmp_path / "site/index.html").read_text())
    assert len(thumbnails) == 2
    assert all((tmp_path / "site" / name).stat().st_size < 8_000 for name in thumbnails)


@pytest.mark.slow
def test_what_cannot_be_compared_is_drawn_all_the_same(runs: Path, tmp_path: Path) -> None:
    build(tmp_path / "site", runs / "plain3", options=ReportOptions())
    page = page_of(tmp_path / "site", "plain3")
    assert len(re.findall(r'alt="Diagram of the recovered state', page)) == 3
    assert "Pictures are missing: " in page


@pytest.mark.slow
def test_a_run_whose_photos_are_gone_is_drawn_without_them(runs: Path, tmp_path: Path) -> None:
    folder = edited(
        shutil.copytree(runs / "plain3", tmp_path / "run"),
        sequence={"name": HOSTILE_NAME, "folder": "/gone", "frames": 3},
    )
    build(tmp_path / "site", folder, options=ReportOptions())
    (page,) = (tmp_path / "site" / "runs").iterdir()
    text = page.read_text()
    assert "The photos are not where the run had them (/gone)." in text
    assert len(re.findall(r'alt="Diagram of the recovered state', text)) == 3


def evaluation(*runs: dict[str, Any]) -> str:
    return json.dumps({"format": 1, "groups": [{"label": "x", "runs": list(runs)}]})


def test_scores_are_shown_where_an_evaluation_lies_with_the_runs(runs: Path, tmp_path: Path) -> None:
    place = shutil.copytree(runs, tmp_path / "batch")
    steps = [
        {"frame": 2, "scores": {"TSS": 0.75, "SIM": 0.5, "CPD": 0.125}, "equal": False},
        {"frame": 3, "scores": {"TSS": 1.0, "SIM": 0.875, "CPD": 0.0}, "equal": True},
    ]
    told = {"sequence": "plain3", "run": "plain3", "steps": steps}
    (place / "evaluation.json").write_text(evaluation(told))
    build(tmp_path / "site", place)
    page = words_of(page_of(tmp_path / "site", "plain3"))
    assert "SIM, last frame 0.875" in page
    assert "TSS 0.750 CPD 0.125 SIM 0.500" in page
    assert "SIM 0.875" in words_of((tmp_path / "site" / "index.html").read_text())


def test_totals_of_several_seeds_have_the_range_of_the_means_of_one_seed(runs: Path, tmp_path: Path) -> None:
    evaluated = []
    for seed, score in ((1, 0.5), (2, 0.75)):
        folder = shutil.copytree(runs / "plain3", tmp_path / "batch" / f"seed-{seed}" / "plain3")
        settings = json.loads((folder / "run.json").read_text())["settings"]
        edited(folder, settings={**settings, "given": {**settings["given"], "seed": seed}})
        steps = [{"frame": 3, "scores": {"SIM": score}}]
        evaluated.append({"sequence": "plain3", "run": f"seed-{seed}/plain3", "steps": steps})
    document = {"groups": [{"runs": evaluated}]}
    (tmp_path / "batch" / "evaluation.json").write_text(json.dumps(document))
    build(tmp_path / "site", tmp_path / "batch")
    words = words_of((tmp_path / "site" / "index.html").read_text())
    assert "seeds 1, 2" in words
    assert "0.625 0.500 to 0.750" in words


def test_a_row_of_a_long_run_shows_some_frames_those_that_do_not_match_among_them(runs: Path) -> None:
    page = gather_page(RunPlace(runs / "plain3", "batch", "plain3"), Evaluations(()))
    first, *_, last = page.frames
    many = [replace(last, frame=frame, verdict="MATCH") for frame in range(2, 3 * MOST_IN_ROW)]
    doubtful = replace(last, frame=20, verdict="MISMATCH")
    many[18] = doubtful
    page.frames = [first, *many]
    numbers = [frame.frame for frame in page.in_row]
    assert len(numbers) == MOST_IN_ROW
    assert numbers == sorted(set(numbers))
    assert {1, 20, 3 * MOST_IN_ROW - 1} <= set(numbers)
    assert max(later - earlier for earlier, later in pairwise(numbers)) <= 6, "the others are spread evenly"
    page.frames = [first, *many[: MOST_IN_ROW - 1]]
    assert page.in_row == page.frames


@pytest.mark.parametrize(
    ("text", "named"),
    [("{", "cannot be read as an evaluation"), ('{"groups": [{}]}', "groups.0.runs"), (None, "Cannot read")],
)
def test_an_evaluation_that_is_none_is_refused_in_one_sentence(
    runs: Path, tmp_path: Path, text: str | None, named: str
) -> None:
    file = tmp_path / "scores.json"
    if text is not None:
        file.write_text(text)
    done = command("report", runs, "-o", tmp_path / "site", "--recorded-only", "--evaluation", file)
    assert done.returncode == 2
    assert named in done.stderr and str(file) in done.stderr
    assert done.stderr.count("\n") == 1


def test_folders_that_are_no_sites_or_hold_no_runs_are_refused_in_one_sentence(
    runs: Path, tmp_path: Path
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    for words, named in (
        ((tmp_path / "mine", "-o", tmp_path / "site"), "holds no recorded run"),
        ((tmp_path / "none", "-o", tmp_path / "site"), "holds no recorded run"),
        ((runs, "-o", tmp_path / "mine"), "holds other things"),
        ((runs, "-o", tmp_path / "mine" / "thesis.txt"), "is a file"),
        ((runs, "-o", tmp_path / "site", "--port", "4000"), "--watch"),
    ):
        done = command("report", *words, "--recorded-only")
        assert done.returncode == 2, done.stderr
        assert named in done.stderr
        assert done.stderr.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["mine"]


def test_a_port_in_use_is_refused_in_one_sentence(runs: Path, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = command("report", runs, "-o", tmp_path / "site", "--watch", "--recorded-only", "--port", port)
    assert (done.returncode, str(port) in done.stderr, done.stderr.count("\n")) == (2, True, 1), done.stderr


def test_a_record_that_claims_a_million_frames_is_shown_all_the_same(runs: Path, tmp_path: Path) -> None:
    told = json.loads((runs / "plain3" / "run.json").read_text())
    folder = shutil.copytree(runs / "plain3", tmp_path / "run")
    edited(folder, outcome={**told["outcome"], "frames": 10**9})
    page = gather_page(RunPlace(folder, "batch", "run"), Evaluations(()))
    assert len(page.frames) == MOST_FRAMES


def test_each_folder_that_is_named_is_a_batch_of_its_own(runs: Path, tmp_path: Path) -> None:
    for name in ("first", "second"):
        shutil.copytree(runs / "plain3", tmp_path / name / "plain3")
    places = find_runs([tmp_path / "first", tmp_path / "second"])
    assert [place.batch for place in places] == ["first", "second"]
    build(tmp_path / "site", tmp_path / "first", tmp_path / "second")
    overview = (tmp_path / "site" / "index.html").read_text()
    assert re.findall(r'<option value="(\d)">(\w+) ', overview) == [("0", "first"), ("1", "second")] * 3


def test_the_command_prints_where_the_site_is(runs: Path, tmp_path: Path) -> None:
    done = command("report", runs / "plain3", "-o", tmp_path / "site", "--recorded-only")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'site' / 'index.html'}\n")


def test_no_run_is_found_twice_and_hidden_folders_are_left_alone(runs: Path, tmp_path: Path) -> None:
    shutil.copytree(runs / "plain3", tmp_path / "runs" / "a" / "b" / "plain3")
    shutil.copytree(runs / "plain3", tmp_path / "runs" / ".hidden")
    places = find_runs([tmp_path / "runs", tmp_path / "runs" / "a"])
    assert [place.within for place in places] == ["a/b/plain3"]
    with pytest.raises(UsageError, match="holds no recorded run"):
        find_runs([tmp_path / "runs", ROOT / "examples"])
