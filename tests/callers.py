"""Calling as the owner of a token, without HTTP."""

from collections.abc import Iterator
from contextlib import contextmanager

from mcp.server.auth.middleware.auth_context import auth_context_var
from mcp.server.auth.middleware.bearer_auth import AuthenticatedUser
from mcp.server.auth.provider import AccessToken


@contextmanager
def calling_as(owner: str) -> Iterator[None]:
    """What is called within, and connected within, is called by this owner."""
    user = AuthenticatedUser(AccessToken(token="", client_id=owner, subject=owner, scopes=[]))
    before = auth_context_var.set(user)
    try:
        yield
    finally:
        auth_context_var.reset(before)
