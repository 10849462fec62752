"""Log messages of the client and of what it is built on, on stderr, without keys."""

import logging
from typing import Literal

from folding_client.record.redaction import redact

LogLevel = Literal["debug", "info", "warning", "error"]
"""The least weight of messages that are shown."""
_FORM = "%(asctime)s %(levelname)s %(name)s: %(message)s"
_LIBRARIES = ("LiteLLM", "openai", "httpx", "httpx2", "httpcore", "mcp")


class _Redacted(logging.Formatter):
    """Cuts keys out of every message."""

    def format(self, record: logging.LogRecord) -> str:
        """The message as it is written."""
        return redact(super().format(record))


def show_logs(level: LogLevel) -> None:
    """Show messages from a level on, those of the libraries included."""
    handler = logging.StreamHandler()
    handler.setFormatter(_Redacted(_FORM))
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    for name in _LIBRARIES:
        logging.getLogger(name).setLevel(level.upper())
