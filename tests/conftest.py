"""Fixtures and settings for all tests."""

from collections.abc import Iterator

import pytest
from hypothesis import settings
from lasting import LASTING

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
