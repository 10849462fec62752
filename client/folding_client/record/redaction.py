"""Keys never reach a record, a message, a server or a terminal: they are cut out of every text on its way there."""

import json
import os
import re
from collections.abc import Mapping
from typing import Any

MARK = "[redacted]"
_SECRET_NAME = re.compile(r"KEY|TOKEN|SECRET|PASSWORD|CREDENTIAL", re.IGNORECASE)
_SECRET_SHAPE = re.compile(r"sk-[A-Za-z0-9_\-]{16,}|AIza[A-Za-z0-9_\-]{20,}|(?<=Bearer )[A-Za-z0-9._\-]{12,}")
_SHORTEST = 8
_IN_URL = re.compile(
    r"""(?<=://)[^/?\#\s"'<>@\\]+(?=@)"""
    r"""|(?<=[?&;])(?P<name>[\w.-]*(?:key|token|secret|password|passwd|pwd|signature|sig|credential)=)[^&\#\s"'<>\\]+""",
    re.IGNORECASE,
)
"""Who a URL logs in as, with or without a password, and the values of parameters that are named like keys."""


def secrets(environment: Mapping[str, str] = os.environ) -> tuple[str, ...]:
    """The values of the environment's variables that are named like keys and name no file, longest first."""
    found = {
        value
        for name, value in environment.items()
        if _SECRET_NAME.search(name) and len(value) >= _SHORTEST and not os.path.lexists(value)
    }
    return tuple(sorted(found, key=len, reverse=True))


def without_keys(data: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON object without any known secret in it."""
    clean: dict[str, Any] = json.loads(redact(json.dumps(dict(data))))
    return clean


def redact(text: str, environment: Mapping[str, str] = os.environ) -> str:
    """The text without any known secret, as it stands or as JSON writes it, nor anything shaped like
    a key, nor what URLs say of users, passwords and keys.
    """
    for secret in secrets(environment):
        text = text.replace(secret, MARK).replace(json.dumps(secret)[1:-1], MARK)
    text = _SECRET_SHAPE.sub(MARK, text)
    return _IN_URL.sub(lambda found: (found["name"] or "") + MARK, text)
