"""Who calls: bearer tokens from a file, each with its owner.

A token file has a line ``OWNER TOKEN`` for each token; an owner may have several. Empty lines and lines that begin
with ``#`` are passed over. Only digests of the tokens are kept in memory, and no message shows a token.
"""

import hashlib
import hmac
import logging
import os
import re
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

from mcp.server.auth.middleware.auth_context import get_access_token
from mcp.server.auth.provider import AccessToken
from mcp.server.auth.settings import AuthSettings
from pydantic import AnyHttpUrl

from folding_server.errors import FoldingError

SHORTEST_TOKEN = 16
"""Characters of the shortest token: 80 bits where each is one of 32."""
_OWNER = re.compile(r"[A-Za-z0-9._@-]{1,64}")
_TOKEN = re.compile(r"[A-Za-z0-9._~+/-]+=*")
"""What RFC 6750, section 2.1, lets a bearer token be."""

_logger = logging.getLogger(__name__)


class TokenFileError(FoldingError):
    """A token file that cannot be used."""


class OwnedTokens:
    """The tokens that a server accepts, as the SDK's token verifier. Keys of ``owners`` are their digests."""

    def __init__(self, owners: Mapping[bytes, str]) -> None:
        self._owners = dict(owners)

    async def verify_token(self, token: str) -> AccessToken | None:
        """The owner's access, without the token itself; None for a token that is not accepted.

        The time it takes does not depend on how much of a token is right.
        """
        presented = _digest(token)
        found = None
        for digest, owner in self._owners.items():
            if hmac.compare_digest(digest, presented):
                found = owner
        return AccessToken(token="", client_id=found, subject=found, scopes=[]) if found else None


def caller() -> str | None:
    """The owner of the token that the current call came with; None over stdio, in memory or without tokens."""
    access = get_access_token()
    return access.client_id if access else None


def auth_settings() -> AuthSettings:
    """Bearer tokens that the operator hands out: there is no authorization server to be discovered.

    The SDK asks for an issuer all the same, and publishes it only where a resource server is named.
    """
    return AuthSettings(issuer_url=AnyHttpUrl("http://localhost"), resource_server_url=None)


def read_tokens(path: Path) -> OwnedTokens:
    """The tokens in a file. A warning is logged if others can read it.

    TokenFileError if it cannot be read, holds no token, or holds a line that is no owner and token.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        mode = path.stat().st_mode
    except OSError as error:
        raise TokenFileError(
            f"The token file {path} cannot be read ({error.strerror}); give a text file with a line OWNER TOKEN "
            "for each user."
        ) from error
    except UnicodeDecodeError as error:
        raise TokenFileError(
            f"The token file {path} is not text in UTF-8; write a line OWNER TOKEN for each user."
        ) from error
    if os.name == "posix" and mode & (stat.S_IRGRP | stat.S_IROTH):
        _logger.warning("Other users can read the token file %s; take that away with chmod 600.", path)
    return OwnedTokens(_owners(path, text))


def _owners(path: Path, text: str) -> dict[bytes, str]:
    """The owner of each token, by the token's digest."""
    owners: dict[bytes, str] = {}
    for number, line in _lines(text):
        owner, token = _owner_and_token(f"Line {number} of the token file {path}", line)
        digest = _digest(token)
        if owners.setdefault(digest, owner) != owner:
            raise TokenFileError(
                f"Line {number} of the token file {path} gives {owner} a token that {owners[digest]} has already; "
                "give each owner one of their own."
            )
    if not owners:
        raise TokenFileError(f"The token file {path} holds no token; write a line OWNER TOKEN for each user.")
    return owners


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """The lines that say something, with their numbers."""
    for number, line in enumerate(text.splitlines(), start=1):
        if (said := line.strip()) and not said.startswith("#"):
            yield number, said


def _owner_and_token(where: str, line: str) -> tuple[str, str]:
    words = line.split()
    if len(words) != 2 or not _OWNER.fullmatch(words[0]):
        raise TokenFileError(
            f"{where} is not OWNER TOKEN; write a name of letters, digits and . _ @ -, a space, and a token."
        )
    owner, token = words
    if len(token) < SHORTEST_TOKEN:
        raise TokenFileError(
            f"{where} gives {owner} a token of {len(token)} characters; it must have at least {SHORTEST_TOKEN}."
        )
    if not _TOKEN.fullmatch(token):
        raise TokenFileError(
            f"{where} gives {owner} a token that HTTP cannot carry; use letters, digits and - . _ ~ + / alone."
        )
    return owner, token


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode(errors="surrogatepass")).digest()
