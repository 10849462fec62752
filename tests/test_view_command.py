"""``foldingagent-server view``: one file, or the page served on this machine alone; in both, looked at by Chromium."""

import json
import re
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsers import chromium, opened
from folding_schemas.actions import Fold
from folding_server.store.run_store import RunStore
from hosts import server
from paths import ROOT
from playwright.sync_api import Browser, Page, expect

CAT = ROOT / "examples" / "programs" / "cat.json"
PHONE, DESK = {"width": 390, "height": 844}, {"width": 1200, "height": 900}


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def cat_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example cat as one HTML file."""
    file = tmp_path_factory.mktemp("view") / "cat.html"
    written = server("view", CAT, "-o", file)
    assert (written.returncode, written.stdout) == (0, f"wrote {file}\n"), written.stderr
    return file


@contextmanager
def serving(*arguments: str | Path) -> Iterator[str]:
    """A process that serves a model; yields its address."""
    command = [sys.executable, "-m", "folding_server", "view", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            found = re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline())
            assert found
            yield found.group()
        finally:
            process.terminate()
            process.communicate(timeout=20)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with serving(CAT) as address:
        yield address


def status(address: str, data: bytes | None, **headers: str) -> int:
    """The status of an answer."""
    request = urllib.request.Request(  # noqa: S310 - an address of our own
        address, data, {name.replace("_", "-"): value for name, value in headers.items()}
    )
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:  # noqa: S310
            return int(answer.status)
    except urllib.error.HTTPError as error:
        with error:
            return error.code


def look(page: Page, file: Path) -> None:
    page.goto(file.as_uri())
    page.locator("#model").wait_for()


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [PHONE, DESK], ids=["phone", "desk"])
def test_the_file_needs_no_sideways_scrolling(
    browser: Browser, cat_file: Path, viewport: dict[str, int]
) -> None:
    with opened(browser, viewport=viewport) as page:
        look(page, cat_file)
        assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
        pictures = [page.locator(name).bounding_box() for name in ("#folded", "#pattern")]
    left, right = (box for box in pictures if box)
    assert (left["y"] == right["y"]) is (viewport is DESK)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_and_creases_stand_out_in_both_themes(browser: Browser, cat_file: Path, scheme: str) -> None:
    pairs = (
        ("body", "color", "body"),
        (".pattern .M", "stroke", ".pattern .sheet"),
        ("#keys", "color", "body"),
    )
    with opened(browser, color_scheme=scheme) as page:
        look(page, cat_file)
        for front, kind, behind in pairs:
            ground = "fill" if behind.endswith("sheet") else "backgroundColor"
            colors = [
                page.locator(where).first.evaluate("(e, p) => getComputedStyle(e)[p]", name)
                for where, name in ((front, kind), (behind, ground))
            ]
            assert contrast(*colors) >= 4.5, (front, colors)


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two computed colours (WCAG 2.1)."""
    light, dark = sorted(map(luminance, (first, second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def luminance(color: str) -> float:
    red, green, blue = (int(value) / 255 for value in re.findall(r"\d+", color)[:3])
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in (red, green, blue)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize(("motion", "moves"), [("reduce", False), ("no-preference", True)])
def test_nothing_moves_for_who_wants_no_motion(
    browser: Browser, cat_file: Path, motion: str, *, moves: bool
) -> None:
    with opened(browser, reduced_motion=motion) as page:
        look(page, cat_file)
        assert page.evaluate("goTo(0), document.getAnimations().length > 0") is moves


def test_every_control_has_a_name_and_focus_is_seen(browser: Browser, cat_file: Path) -> None:
    with opened(browser) as page:
        look(page, cat_file)
        nameless = page.evaluate(
            "[...document.querySelectorAll('button, input, select, svg[role=img], image')]"
            ".filter(e => !(e.ariaLabel || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).map(e => e.id)"
        )
        assert nameless == []
        reached = []
        page.keyboard.press("Tab")
        while page.evaluate("document.activeElement !== document.body"):
            reached.append(page.evaluate("document.activeElement.id"))
            assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
            page.keyboard.press("Tab")
    assert {"first", "play", "position", "folded", "pattern", "ids"} <= set(reached)


def test_playing_goes_through_all_states(browser: Browser, cat_file: Path) -> None:
    with opened(browser) as page:
        page.clock.install()
        look(page, cat_file)
        last = page.locator("#stop").inner_text()
        page.get_by_role("button", name="Play").click()
        expect(page.locator("#stop")).to_contain_text("the flat sheet")
        page.clock.run_for(30_000)
        assert page.locator("#stop").inner_text() == last
        expect(page.get_by_role("button", name="Play")).to_be_visible()


def test_a_file_only_shows_and_says_how_to_fold(browser: Browser, cat_file: Path) -> None:
    with opened(browser) as page:
        look(page, cat_file)
        expect(page.locator("#controls")).to_be_hidden()
        expect(page.locator("#cannot")).to_contain_text("foldingagent-server view")


@pytest.mark.slow
def test_what_a_program_is_called_is_text_and_nothing_else(browser: Browser, tmp_path: Path) -> None:
    program, name = tmp_path / "odd.json", "</script><img src=x onerror=alert(1)> $view &amp;"
    program.write_text(json.dumps({"name": name, "steps": []}))
    assert server("view", program, "-o", tmp_path / "odd.html").returncode == 0
    with opened(browser) as page:
        look(page, tmp_path / "odd.html")
        assert page.locator("h1").inner_text() == name
        assert page.locator("img").count() == 0


@pytest.mark.slow
def test_the_served_page_folds_and_takes_back(browser: Browser, address: str) -> None:
    with opened(browser) as page:
        page.goto(address)
        page.locator("#folded").focus()
        page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        expect(page.locator("#answer")).to_contain_text("Done: fold")
        expect(page.locator("#stop")).to_contain_text("Step 9 of 9")
        page.get_by_role("button", name="Undo").click()
        expect(page.locator("#stop")).to_contain_text("Step 8 of 8")
        page.get_by_role("button", name="Undo").click()
        expect(page.locator("#answer")).to_contain_text("Nothing was folded here yet")


def test_other_sites_reach_neither_the_page_nor_the_model(address: str) -> None:
    call = json.dumps({"name": "show_model", "arguments": {}}).encode()
    assert status(address, None) == 200
    assert status(address + "call", call, Content_Type="application/json") == 200
    assert status(address, None, Host="evil.test") == 400
    assert status(address + "call", call, Content_Type="text/plain") == 415
    assert status(address + "call", call, Content_Type="application/json", Host="evil.test") == 400
    assert status(address + "call", b"no JSON", Content_Type="application/json") == 400


def test_a_stored_run_is_shown_by_its_id(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path / "data") as store:
        run = store.create()
        with store.change(run.run_id) as change:
            change.act(Fold(edge=(1, 3), direction=1))
    file = tmp_path / "run.html"
    written = server("view", run.run_id, "--data", tmp_path / "data", "-o", file)
    assert written.returncode == 0, written.stderr
    assert "fold 1-3, + side" in file.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_run_is_found_in_the_database_that_the_environment_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"sqlite:///{tmp_path / 'runs.sqlite3'}"
    with RunStore(url) as store:
        run = store.create()
        with store.change(run.run_id) as change:
            change.act(Fold(edge=(1, 3), direction=1))
    file = tmp_path / "run.html"
    by_option = server("view", run.run_id, "--database", url, "-o", file)
    assert by_option.returncode == 0, by_option.stderr
    file.unlink()
    monkeypatch.setenv("FOLDINGAGENT_DATABASE", url)
    by_environment = server("view", run.run_id, "--data", tmp_path / "none", "-o", file)
    assert by_environment.returncode == 0, by_environment.stderr
    assert "fold 1-3, + side" in file.read_text(encoding="utf-8")
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
def test_looking_for_a_run_makes_no_data_folder(tmp_path: Path) -> None:
    for data in (tmp_path / "none", tmp_path / "empty"):
        (tmp_path / "empty").mkdir(exist_ok=True)
        refused = server("view", "20260101-000000-aaaaaaaaaa", "--data", data, "-o", tmp_path / "x.html")
        assert refused.returncode == 1
        assert f"the data folder {data} holds no runs" in refused.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["empty"]
    assert list((tmp_path / "empty").iterdir()) == []


def test_a_run_folder_is_shown_with_its_photos(tmp_path: Path) -> None:
    (tmp_path / "program.json").write_text(CAT.read_text(encoding="utf-8"))
    about = {"format": 1, "sequence": {"name": "cat", "folder": str(ROOT / "examples" / "cat")}}
    (tmp_path / "run.json").write_text(json.dumps(about))
    file = tmp_path / "run.html"
    assert server("view", tmp_path, "-o", file).returncode == 0
    assert file.read_text(encoding="utf-8").count("data:image/jpeg;base64,") == 9


@pytest.mark.slow
@pytest.mark.parametrize("sequence", [{"folder": "gone"}, {}, None])
def test_a_run_whose_photos_are_gone_is_shown_without(
    tmp_path: Path, sequence: dict[str, str] | None
) -> None:
    (tmp_path / "program.json").write_text(CAT.read_text(encoding="utf-8"))
    (tmp_path / "run.json").write_text(json.dumps({"sequence": sequence}))
    written = server("view", tmp_path, "-o", tmp_path / "run.html")
    assert written.returncode == 0
    assert written.stderr.startswith("Shown without photos: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "named"),
    [
        ("nothing.json", "nothing.json"),
        ("20260101-000000-aaaaaaaaaa", "no run"),
        (".", "run.json"),
        ("a" * 300, "cannot be looked at"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_sentence(tmp_path: Path, source: str, named: str) -> None:
    refused = server("view", source, "--data", tmp_path / "data", "-o", tmp_path / "x.html", cwd=tmp_path)
    assert refused.returncode == 1
    assert named in refused.stderr
    assert refused.stderr.count("\n") == 1


def test_a_port_in_use_is_refused_in_one_sentence(address: str) -> None:
    refused = server("view", CAT, "--port", address.rstrip("/").rpartition(":")[2])
    assert refused.returncode == 1
    assert "--port" in refused.stderr
    assert refused.stderr.count("\n") == 1
