"""Fixtures and settings for all tests."""

import pytest
from hypothesis import settings

# How long an example takes depends on the machine and is no fault.
settings.register_profile("project", deadline=None, print_blob=True)
settings.load_profile("project")


@pytest.fixture(scope="session")
def anyio_backend() -> str:
    """Tests marked ``anyio`` run on asyncio, as the server does."""
    return "asyncio"
