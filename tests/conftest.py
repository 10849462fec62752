"""Fixtures and settings for all tests."""

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings
from lasting import LASTING
from reference import REASON, REQUIRED, missing, required

# A worker of the tests has one processor; further threads for small matrices only wait for each other on it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

TOO_SLOW = "they are slow: --slow runs all tests"

# How long an example takes depends on the machine and is no fault.
settings.register_profile("project", deadline=None, print_blob=True)
settings.load_profile("project")


@pytest.fixture(scope="session")
def anyio_backend() -> str:
    """Tests marked ``anyio`` run on asyncio, as the server does."""
    return "asyncio"


@pytest.fixture(scope="session", autouse=True)
def ends_what_tests_share() -> Iterator[None]:
    """Ends, after the last test, what several tests have used."""
    yield
    LASTING.close()


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option that has all tests run."""
    parser.addoption("--slow", action="store_true", help="run the slow tests too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skips the slow tests, unless they are asked for or a test is named."""
    if config.getoption("--slow") or any("::" in argument for argument in config.args):
        return
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.skip(reason=TOO_SLOW))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skips a test whose reference data is missing, or fails it where that is not allowed."""
    part = missing(item)
    if part is None:
        return
    if required():
        pytest.fail(f"{REQUIRED} is set, but there is no {part}: {REASON}", pytrace=False)
    pytest.skip(REASON)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Says in a line each how many tests were skipped for want of reference data, and how many because they are slow."""
    skipped = [report.longrepr[2] for report in terminalreporter.stats.get("skipped", [])]
    for reason in (REASON, TOO_SLOW):
        count = sum(reason in each for each in skipped)
        if count:
            terminalreporter.write_line(f"tests skipped: {count}; {reason}")
