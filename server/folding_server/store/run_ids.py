"""Names of runs: short, sorted by time, safe in file names, and too random to guess."""

import re
import secrets
from datetime import datetime

_ALPHABET = "abcdefghijklmnopqrstuvwxyz234567"
_RANDOM_LETTERS = 10
_PATTERN = re.compile(r"[0-9]{8}-[0-9]{6}-[a-z2-7]{10}", re.ASCII)


def new_run_id(now: datetime) -> str:
    """A new id such as ``20260728-091500-k3vq7mzt2c``: the time to the second, then 50 random bits."""
    random = "".join(secrets.choice(_ALPHABET) for _ in range(_RANDOM_LETTERS))
    return f"{now:%Y%m%d-%H%M%S}-{random}"


def is_run_id(text: str) -> bool:
    """Whether the text has the form of a run id; says nothing about whether the run exists."""
    return _PATTERN.fullmatch(text) is not None
