"""The view in a host of MCP Apps: headless Chromium, a small host page, and the real server behind it."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsers import HOST, VIEW, ShownRun, chromium, shown_run
from playwright.sync_api import Browser, expect

HALVED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("fold", {"edge": [1, 3], "direction": 1}),
    ("unfold", {}),
    ("fold", {"edge": [2, 4], "direction": 1}),
)
"""A sheet with one opened crease, 1-3, and one fold, 2-4, which cuts it at vertex 5."""

FOLDED, PATTERN, STOP, ANSWER = "#folded", "#pattern", "#stop", "#answer"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def halved(browser: Browser, tmp_path: Path) -> Iterator[ShownRun]:
    with shown_run(browser, tmp_path, *HALVED) as run:
        yield run


@pytest.mark.slow
def test_the_folded_state_and_the_crease_pattern_are_shown_with_text_for_both(halved: ShownRun) -> None:
    expect(halved.view.locator(STOP)).to_have_text(re.compile(r"Step 1 of 1: fold 2-4, \+ side"))
    assert halved.view.locator(f"{FOLDED} .face").count() == 4
    folded = halved.view.get_by_role("img", name=re.compile(r"^Folded state\. .* 2 layers"))
    pattern = halved.view.get_by_role("img", name=re.compile(r"^Crease pattern: .*2 opened creases"))
    assert folded.get_attribute("id") == "folded"
    assert pattern.get_attribute("id") == "pattern"


def test_the_page_asks_for_nothing_but_itself(halved: ShownRun) -> None:
    halved.view.get_by_role("button", name="First").click()
    assert halved.requested == [HOST, VIEW]


@pytest.mark.slow
def test_arrow_keys_go_through_the_program(halved: ShownRun) -> None:
    halved.view.locator(FOLDED).focus()
    seen = []
    for key in ("Home", "ArrowRight", "ArrowRight", "ArrowLeft", "End"):
        halved.page.keyboard.press(key)
        seen.append(halved.view.locator(STOP).inner_text().split(".")[0])
    assert [text.partition(": ")[2] for text in seen] == [
        "the flat sheet",
        "fold 1-3, + side",
        "unfold",
        "fold 1-3, + side",
        "fold 2-4, + side",
    ]


def test_enter_folds_the_crease_picked_with_the_keyboard(halved: ShownRun) -> None:
    halved.view.locator(FOLDED).focus()
    halved.page.keyboard.press("ArrowDown")
    u, v = (int(halved.view.locator(field).input_value()) for field in ("#from", "#to"))
    assert halved.view.locator(f"{FOLDED} .arrow").count() == 2
    halved.page.keyboard.press("Enter")
    expect(halved.view.locator(ANSWER)).to_contain_text(f"Done: fold([{u}, {v}], 1).")
    run_id = halved.call("get_run")["run_id"]
    assert halved.calls[-2:] == [
        ("fold", {"edge": [u, v], "direction": 1, "run_id": run_id}),
        ("show_model", {"run_id": run_id}),
    ]
    assert halved.call("get_run")["pending"][-1] == {"action": "fold", "edge": [u, v], "direction": 1}
    expect(halved.view.locator(STOP)).to_contain_text(f"fold {u}-{v}, + side")
    assert f"fold([{u}, {v}], 1)" in halved.heard("ui/update-model-context")[-1]["content"][0]["text"]
    expect(halved.view.locator(FOLDED)).to_be_focused()


def test_a_crease_clicked_in_the_pattern_is_unfolded_and_the_last_action_undone(halved: ShownRun) -> None:
    halved.view.locator(f"{PATTERN} .reach[data-kind=V], {PATTERN} .reach[data-kind=M]").first.click(
        force=True
    )
    halved.view.get_by_role("button", name="Unfold").click()
    expect(halved.view.locator(STOP)).to_contain_text("unfold")
    halved.view.get_by_role("button", name="Undo").click()
    expect(halved.view.locator(STOP)).to_contain_text("fold 2-4")
    assert len(halved.call("get_run")["pending"]) == len(HALVED)


def test_two_vertices_clicked_give_a_line_to_fold(browser: Browser, tmp_path: Path) -> None:
    with shown_run(browser, tmp_path) as run:
        for corner in ("1", "3"):
            run.view.locator(f'{FOLDED} .spot[data-ids="{corner}"]').click()
        run.view.get_by_label("lower").check()
        run.view.get_by_role("button", name="Fold", exact=True).click()
        expect(run.view.locator(ANSWER)).to_contain_text("Done: fold([1, 3], -1)")


def test_vertices_typed_in_are_folded_along_by_enter(browser: Browser, tmp_path: Path) -> None:
    with shown_run(browser, tmp_path) as run:
        run.view.locator("#from").fill("2")
        run.view.locator("#to").fill("4")
        run.view.locator("#to").press("Enter")
        expect(run.view.locator(ANSWER)).to_contain_text("Done: fold([2, 4], 1)")


def test_the_sides_of_an_upright_line_are_called_right_and_left(browser: Browser, tmp_path: Path) -> None:
    with shown_run(browser, tmp_path, ("add_vertex", {"edge": [1, 2], "position": 0.5})) as run:
        for field, vertex in (("#from", "2"), ("#to", "3")):
            run.view.locator(field).fill(vertex)
            run.view.locator(field).blur()
        expect(run.view.locator("#plus")).to_have_text("right")
        expect(run.view.locator("#minus")).to_have_text("left")


def test_a_refused_fold_is_told_and_nothing_changes(halved: ShownRun) -> None:
    for field, vertex in (("#from", "1"), ("#to", "3")):
        halved.view.locator(field).fill(vertex)
        halved.view.locator(field).blur()
    halved.view.get_by_role("button", name="Fold", exact=True).click()
    expect(halved.view.locator(ANSWER)).to_have_class("refused")
    assert "lie at one place" in halved.view.locator(ANSWER).inner_text()
    assert len(halved.call("get_run")["pending"]) == len(HALVED)


def test_pointing_at_a_vertex_names_it_in_both_pictures(halved: ShownRun) -> None:
    halved.view.locator(f'{FOLDED} .spot[data-ids="1,3"]').hover()
    assert halved.view.locator("#pointed").inner_text().startswith("Vertex 1, 3 at (")
    assert halved.view.locator(f"{FOLDED} .ids text").all_text_contents() == ["1, 3"]
    assert sorted(halved.view.locator(f"{PATTERN} .ids text").all_text_contents()) == ["1", "3"]


def test_folding_waits_for_the_last_state(halved: ShownRun) -> None:
    halved.view.get_by_role("button", name="First").click()
    expect(halved.view.locator("#cannot")).to_have_text("Go to the last state to fold from there.")
    expect(halved.view.get_by_role("button", name="Fold", exact=True)).to_be_disabled()


def test_a_host_that_passes_no_calls_on_gets_a_word_instead_of_controls(
    browser: Browser, tmp_path: Path
) -> None:
    with shown_run(browser, tmp_path, *HALVED, capabilities={}) as run:
        expect(run.view.locator("#cannot")).to_contain_text("ask its model to fold")
        expect(run.view.locator("#controls")).to_be_hidden()


def test_the_slider_uncovers_the_photo(browser: Browser, tmp_path: Path) -> None:
    with shown_run(browser, tmp_path, ("save_checkpoint", {"frame": 1}), sequence="cat") as run:
        assert run.view.locator(f"{FOLDED} image").count() == 0
        run.view.get_by_label("Uncover the photo of frame 1").fill("40")
        photo = run.view.get_by_role("img", name="Photo of frame 1")
        assert str(photo.get_attribute("href")).startswith("data:image/jpeg;base64,")
        assert run.view.locator("#uncovered-part rect").get_attribute("width") == "400"


@pytest.mark.slow
@pytest.mark.parametrize(("theme", "dark"), [("light", False), ("dark", True)])
def test_the_hosts_theme_counts_more_than_the_systems(
    browser: Browser, tmp_path: Path, theme: str, dark: bool
) -> None:
    system = "light" if dark else "dark"
    with shown_run(browser, tmp_path, context={"theme": theme}, color_scheme=system) as run:
        assert is_dark(run) is dark
        run.page.evaluate(
            "theme => send({method: 'ui/notifications/host-context-changed', params: {theme}})", system
        )
        expect(run.view.locator("html")).to_have_attribute("data-theme", system)
        assert is_dark(run) is not dark


def test_the_hosts_colours_are_worn(browser: Browser, tmp_path: Path) -> None:
    colors = {"--color-background-primary": "rgb(1, 2, 3)"}
    with shown_run(browser, tmp_path, context={"styles": {"variables": colors}}) as run:
        expect(run.view.locator("body")).to_have_css("background-color", "rgb(1, 2, 3)")


def test_the_host_is_told_the_size_of_the_page(halved: ShownRun) -> None:
    told = halved.heard("ui/notifications/size-changed")[-1]
    body = halved.view.locator("body").bounding_box()
    assert body is not None
    assert abs(told["height"] - body["height"]) <= 1


def test_the_host_can_ask_whether_the_page_lives_and_take_it_down(halved: ShownRun) -> None:
    for number, method in ((91, "ping"), (92, "ui/resource-teardown")):
        halved.page.evaluate("([id, method]) => send({id, method, params: {}})", [number, method])
    halved.page.evaluate("send({id: 93, method: 'ui/unheard-of', params: {}})")
    halved.page.wait_for_function("heard.some(message => message.id === 93)")
    answers = {each["id"]: each for each in halved.page.evaluate("heard.filter(m => !m.method)")}
    assert answers[91]["result"] == answers[92]["result"] == {}
    assert answers[93]["error"]["code"] == -32601


def is_dark(run: ShownRun) -> bool:
    """Whether the page has a dark ground."""
    color = run.view.locator("body").evaluate("body => getComputedStyle(body).backgroundColor")
    return sum(int(value) for value in re.findall(r"\d+", color)[:3]) < 3 * 128
