"""Chromium without a window, and a host of MCP Apps in it that passes calls on to a real server in memory."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from anyio.from_thread import BlockingPortal, start_blocking_portal
from hosts import Host, in_memory
from paths import ROOT
from playwright.sync_api import Browser, FrameLocator, Page, Route, sync_playwright

FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)
HOST_PAGE = ROOT / "tests" / "data" / "app_host.html"
HOST, VIEW = "http://host.test/", "http://view.test/"
POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; media-src 'self' data:; connect-src 'none'"
)
"""What the specification has a host allow a view that asks for nothing more."""
CALLING = {"serverTools": {}}
PAGE = "ui://folding/model.html"


@contextmanager
def chromium() -> Iterator[Browser]:
    """The system's Chromium. Skips where there is none, but not in CI."""
    executable = shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None:
        if os.environ.get("CI"):
            pytest.fail("Chromium is missing, and CI leaves no test out")
        pytest.skip("there is no Chromium on this machine")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=list(FLAGS))
        yield browser
        browser.close()


@contextmanager
def opened(browser: Browser, **options: Any) -> Iterator[Page]:
    """A page of its own, on which no script may fail."""
    failures: list[str] = []
    context = browser.new_context(**options)
    page = context.new_page()
    page.on("pageerror", lambda error: failures.append(str(error)))
    page.on("console", lambda said: failures.append(said.text) if said.type == "error" else None)
    try:
        yield page
    finally:
        context.close()
    assert not failures, failures


@dataclass
class ShownRun:
    """A run that a host shows: the page in its frame, the host around it, and the server behind both."""

    page: Page
    view: FrameLocator
    portal: BlockingPortal
    host: Host
    calls: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    requested: list[str] = field(default_factory=list)

    def call(self, tool: str, **arguments: Any) -> dict[str, Any]:
        """The structured answer of the server to a call that does not come from the page."""
        return self.portal.call(lambda: self.host.call(tool, **arguments))

    def answer(self, tool: str, arguments: dict[str, Any]) -> Any:
        """The whole answer to a call of the page, as a host passes it on."""
        self.calls.append((tool, arguments))
        result = self.portal.call(lambda: self.host.answer(tool, **arguments))
        return result.model_dump(mode="json", by_alias=True, exclude_none=True)

    def html(self) -> str:
        """The page as the server gives it out."""
        read = self.portal.call(lambda: self.host.client.read_resource(PAGE))
        return str(read.contents[0].text)  # type: ignore[union-attr]

    def heard(self, method: str) -> list[dict[str, Any]]:
        """The parameters of the page's messages of one method, oldest first."""
        messages: list[dict[str, Any]] = self.page.evaluate("heard")
        return [message["params"] for message in messages if message.get("method") == method]

    def show(self, capabilities: dict[str, Any], context: dict[str, Any]) -> None:
        """Open the host with the page in it, and wait for the model."""
        pages = {HOST: HOST_PAGE.read_text(encoding="utf-8"), VIEW: self.html()}
        settings = json.dumps({"capabilities": capabilities, "context": context})
        pages[HOST] = pages[HOST].replace('"use strict";', f'"use strict"; const settings = {settings};')

        def fulfil(route: Route) -> None:
            self.requested.append(route.request.url)
            policy = {"Content-Security-Policy": POLICY} if route.request.url == VIEW else {}
            route.fulfill(body=pages[route.request.url], content_type="text/html", headers=policy)

        self.page.route("**/*", fulfil)
        self.page.expose_function("callTool", self.answer)
        self.page.goto(HOST)
        self.view.locator("#model").wait_for()


@contextmanager
def shown_run(
    browser: Browser,
    data: Path,
    *actions: tuple[str, dict[str, Any]],
    sequence: str | None = None,
    capabilities: dict[str, Any] | None = None,
    context: dict[str, Any] | None = None,
    **options: Any,
) -> Iterator[ShownRun]:
    """A host that shows a run after some calls of tools."""
    with (
        opened(browser, **options) as page,
        start_blocking_portal() as portal,
        portal.wrap_async_context_manager(in_memory(data, ROOT / "examples")) as host,
    ):
        run = ShownRun(page, page.frame_locator("iframe"), portal, host)
        run.call("open_run", **({"sequence": sequence} if sequence else {}))
        for tool, arguments in actions:
            run.call(tool, **arguments)
        run.show(CALLING if capabilities is None else capabilities, context or {})
        yield run
