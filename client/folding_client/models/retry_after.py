"""How long a provider asks to wait, wherever it says so.

In the header ``retry-after-ms`` (OpenAI, Azure), in ``retry-after`` as seconds or as a date (RFC 9110, section 10.2.3),
or in the words of the error: ``"retryDelay": "35s"`` (Gemini), "try again in 1m26.4s" (OpenAI).
"""

import math
import re
from collections.abc import Mapping
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

_IN_WORDS = re.compile(
    r"(?:retryDelay\W+|(?:try again|retry) (?:in|after) )"
    r"((?:\d+h)?(?:\d+m(?!s))?(?:\d+(?:\.\d+)?(?:ms|s\b|\s*seconds?))?)",
    re.IGNORECASE,
)
_PART = re.compile(r"(\d+(?:\.\d+)?)\s*(ms|h|m|s)")
_SECONDS = {"h": 3600.0, "m": 60.0, "s": 1.0, "ms": 0.001}


def seconds_asked(headers: Mapping[str, str], words: str) -> float | None:
    """The seconds that a provider asks to wait from now on, never negative; None if it does not say."""
    for name, read in (("retry-after-ms", _milliseconds), ("retry-after", _seconds_or_date)):
        asked = read(headers.get(name, ""))
        if asked is not None:
            return max(asked, 0.0)
    return _in_words(words)


def _milliseconds(text: str) -> float | None:
    number = _number(text)
    return None if number is None else number / 1000


def _seconds_or_date(text: str) -> float | None:
    number = _number(text)
    if number is not None or not text:
        return number
    try:
        when = parsedate_to_datetime(text)
    except ValueError:
        return None
    return (when.replace(tzinfo=when.tzinfo or UTC) - datetime.now(UTC)).total_seconds()


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _in_words(words: str) -> float | None:
    found = _IN_WORDS.search(words)
    parts = _PART.findall(found.group(1)) if found else []
    return sum(float(number) * _SECONDS[unit.lower()] for number, unit in parts) if parts else None
