"""The site of recorded runs in headless Chromium: from files, on a phone, by keyboard, in both themes, while it is served."""

import asyncio
import contextlib
import json
import re
import shutil
import socket
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import anyio.from_thread
import pytest
from axe_playwright_python.sync_playwright import Axe
from browsers import chromium, opened
from folding_client.report.site import ReportOptions, SiteBuilder
from folding_client.report.watching import watch_site
from playwright.sync_api import Browser, Page, expect
from report_runs import edited, many_sorts

THEMES = ("light", "dark")
WIDTHS = (1280, 390)
PHONE = {"width": 390, "height": 844}


def build(out: Path, *roots: Path) -> Path:
    asyncio.run(SiteBuilder(roots, out, ReportOptions(server=False), lambda _: None).build())
    return out


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("batches")
    (place / "first").mkdir()
    many_sorts(place / "first")
    shutil.copytree(place / "first" / "plain3", place / "second" / "plain3")
    edited(place / "second" / "plain3", models={"agent": "another"})
    return place


@pytest.fixture(scope="module")
def site(runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("report") / "site", runs / "first", runs / "second")


@pytest.fixture(scope="module")
def seeded(runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site of one sequence reconstructed with three seeds, and by another model."""
    batch = tmp_path_factory.mktemp("seeds") / "batch"
    for seed, seconds in ((1, 10.0), (2, 20.0), (3, 60.0)):
        folder = shutil.copytree(runs / "first" / "plain3", batch / f"drawn_seed-{seed}" / "plain3")
        told = json.loads((folder / "run.json").read_text())
        told["settings"]["given"]["seed"] = seed
        told["outcome"]["seconds"] = seconds
        edited(folder, models={"agent": "drawn"}, settings=told["settings"], outcome=told["outcome"])
    shutil.copytree(runs / "first" / "plain3", batch / "other" / "plain3")
    edited(batch / "other" / "plain3", models={"agent": "other"})
    return build(batch.parent / "site", batch)


@pytest.fixture(scope="module")
def browser(site: Path, seeded: Path) -> Iterator[Browser]:
    """A browser, started after the runs are made: both take the thread's event loop for themselves."""
    assert site.is_dir() and seeded.is_dir()
    with chromium() as browser:
        yield browser


def address(site: Path, name: str = "", place: str = "") -> str:
    """The address of the overview, or of the page of a run."""
    if not name:
        return f"{(site / 'index.html').as_uri()}{place}"
    (page,) = site.glob(f"runs/*-{name}-??????.html")
    return f"{page.as_uri()}{place}"


def faults(page: Page) -> list[str]:
    found: list[dict[str, Any]] = Axe().run(page, options={"preload": False}).response["violations"]
    return [f"{each['id']}: {each['nodes'][0]['html'][:200]}" for each in found]


def check(browser: Browser, address: str, theme: str, width: int) -> None:
    """That axe finds nothing on a page with all of it open, and that nothing is wider than the window."""
    with opened(browser, color_scheme=theme, viewport={"width": width, "height": 800}) as page:
        page.goto(address)
        for button in page.get_by_role("button", name="Open all").all():
            button.click()
        assert faults(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_axe_finds_nothing_on_the_overview(browser: Browser, site: Path) -> None:
    check(browser, address(site), "dark", 390)


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("name", ["", "first-plain3", "first-damaged"], ids=["overview", "run", "damaged"])
def test_axe_finds_nothing(browser: Browser, site: Path, theme: str, width: int, name: str) -> None:
    check(browser, address(site, name), theme, width)


def test_nothing_is_asked_for_but_files_of_the_site_and_nothing_hostile_runs(
    browser: Browser, site: Path
) -> None:
    asked: list[str] = []
    with opened(browser) as page:
        page.on("request", lambda request: asked.append(request.url))
        for name in ("", "first-hostile", "first-plain3"):
            page.goto(address(site, name))
            for button in page.get_by_role("button", name="Open all").all():
                button.click()
            assert "owned" not in page.title().replace("document.title", "").replace('="owned"', "")
            assert page.locator('img[src="x"]').count() == 0
    assert asked
    assert [url for url in asked if not url.startswith(site.as_uri())] == []


def test_arrow_keys_step_through_the_frames_and_the_address_keeps_the_place(
    browser: Browser, site: Path
) -> None:
    with opened(browser) as page:
        page.goto(address(site, "first-plain3"))
        heading = page.locator(".frame:visible h3")
        for key, frame in (
            ("ArrowRight", 2),
            ("ArrowRight", 3),
            ("ArrowRight", 3),
            ("ArrowLeft", 2),
            ("Home", 1),
            ("End", 3),
        ):
            page.keyboard.press(key)
            expect(heading).to_have_text(re.compile(rf"^Frame {frame} "))
            assert page.evaluate("location.hash") == f"#f{frame}"
        expect(page.locator("#at")).to_have_text("3 of 3")
        expect(page.locator("#next")).to_be_disabled()
        page.reload()
        expect(heading).to_have_text(re.compile("^Frame 3 "))
        assert page.locator(".pick [aria-current=step]").get_attribute("href") == "#f3"


def test_the_focus_is_seen(browser: Browser, site: Path) -> None:
    with opened(browser) as page:
        page.goto(address(site, "first-plain3"))
        for _ in range(12):
            page.keyboard.press("Tab")
            outline = page.evaluate(
                "(({outlineStyle, outlineWidth}) => [outlineStyle, outlineWidth])(getComputedStyle(document.activeElement))"
            )
            assert outline == ["solid", "3px"], page.evaluate("document.activeElement.outerHTML")


def test_an_attempt_leads_to_its_place_in_the_trace(browser: Browser, site: Path) -> None:
    with opened(browser) as page:
        page.goto(address(site, "first-plain3"))
        page.locator(".tree ul a").first.click()
        opened_entry = page.locator(".entry[open]").last
        expect(opened_entry.locator("> summary")).to_be_in_viewport()
        assert f"#{opened_entry.get_attribute('id')}" == page.evaluate("location.hash")


def test_runs_are_found_filtered_and_sorted(browser: Browser, site: Path) -> None:
    with opened(browser, viewport=PHONE) as page:
        page.goto(address(site))
        names = page.locator("#list h3:visible")
        expect(names).to_have_count(6)
        page.get_by_label("Status").select_option("stopped")
        expect(names).to_have_text(["plain4"])
        expect(page.locator("#count")).to_have_text("1 of 6 runs.")
        page.get_by_label("Status").select_option("all")
        page.get_by_label("Find").fill("another")
        expect(names).to_have_text(["plain3"])
        page.get_by_label("Find").fill("")
        page.get_by_label("Sort by").select_option("cost, highest first")
        expect(names).to_have_count(6)
        costs = page.locator(".run").evaluate_all("rows => rows.map(row => Number(row.dataset.cost))")
        assert costs == sorted(costs, reverse=True) and costs[0] > costs[-1]
        page.reload()
        expect(page.get_by_label("Sort by")).to_have_value("cost")


def test_two_batches_are_compared_side_by_side(browser: Browser, site: Path) -> None:
    with opened(browser, viewport={"width": 1280, "height": 800}) as page:
        page.goto(address(site))
        groups = page.locator("#left option").all_inner_texts()
        (first,) = [name for name in groups if name.startswith("first · scripted") and "plain3" in name]
        (second,) = [name for name in groups if name.startswith("second")]
        page.get_by_label("Compare").select_option(first)
        page.get_by_label("with").select_option(second)
        pair = page.locator(".pair").filter(has_text="plain3")
        expect(pair.locator(".run")).to_have_count(2)
        left, right = (pair.locator(".run").nth(number).bounding_box() for number in (0, 1))
        assert left is not None and right is not None
        assert left["y"] == right["y"] and left["x"] + left["width"] <= right["x"]
        assert faults(page) == []


@pytest.mark.slow
def test_seeds_of_a_group_are_compared_by_mean_and_range_with_each_run_behind_it(
    seeded: Path, browser: Browser
) -> None:
    for theme, width in (("light", 1280), ("dark", 390)):
        with opened(browser, color_scheme=theme, viewport={"width": width, "height": 800}) as page:
            page.goto(address(seeded))
            expect(page.get_by_text("drawn, seed 3", exact=True)).to_be_visible()
            page.get_by_label("Compare").select_option("drawn")
            page.get_by_label("with").select_option("other")
            seeds = page.locator(".pair .seeds")
            expect(seeds).to_contain_text("time30 s (10 s to 60 s)")
            expect(seeds.locator(".run:visible")).to_have_count(0)
            seeds.get_by_text("Seeds 1, 2, 3").click()
            expect(seeds.locator(".run:visible")).to_have_count(3)
            page.get_by_label("Find").fill("plain")
            expect(seeds.locator(".run:visible")).to_have_count(3)
            assert faults(page) == []
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_without_scripts_everything_is_there(browser: Browser, site: Path) -> None:
    with opened(browser, java_script_enabled=False) as page:
        page.goto(address(site))
        expect(page.locator(".run")).to_have_count(6)
        expect(page.locator("#controls")).to_be_hidden()
        page.goto(address(site, "first-plain3"))
        expect(page.locator(".frame:visible")).to_have_count(3)


@contextlib.contextmanager
def watched(roots: list[Path], out: Path) -> Iterator[str]:
    """The address of a site that is served and rebuilt, in a thread of its own."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    builder = SiteBuilder(roots, out, ReportOptions(server=False, live=True), lambda _: None)
    told: list[str] = []
    with anyio.from_thread.start_blocking_portal() as portal:
        serving = portal.start_task_soon(partial(watch_site, builder, port, told.append))
        while not told:
            assert not serving.done(), serving.result()
        yield told[0]
        serving.cancel()


def test_a_page_takes_over_what_changed_without_losing_the_place(
    browser: Browser, runs: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(runs / "first" / "plain3", tmp_path / "runs" / "plain3")
    edited(folder, decided={"3": "nobody yet"})
    with watched([tmp_path / "runs"], tmp_path / "site") as url, opened(browser, viewport=PHONE) as page:
        page.goto(url)
        page.get_by_role("link", name="plain3").click()
        expect(page.locator("#at")).to_have_text("1 of 3")
        page.keyboard.press("End")
        page.locator("#log .step > summary").nth(1).click()
        page.evaluate("scrollTo(0, 500)")
        expect(page.locator(".frame.current")).to_contain_text("Decided by nobody yet")
        page.wait_for_timeout(2500)  # the page knows by now which version it is
        edited(folder, decided={"3": "somebody else"})
        expect(page.locator(".frame.current")).to_contain_text("Decided by somebody else", timeout=15_000)
        assert page.evaluate("scrollY") == 500
        expect(page.locator("#log .step[open]")).to_have_count(1)
        expect(page.locator("#at")).to_have_text("3 of 3")
        assert page.request.get(url, headers={"Host": "evil.test"}).status == 400
        versions = json.loads((tmp_path / "site" / "versions.json").read_text())
        assert set(versions) == {
            "index.html",
            *(f"runs/{p.name}" for p in (tmp_path / "site/runs").iterdir()),
        }
