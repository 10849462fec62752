"""Values that no caller should send, for ``benchmarks/fuzz.py``: drawn from a seeded generator, so that they come again."""

import random
from collections.abc import Callable, Mapping
from typing import Any

LONG_NAME = "n" * 1_000_000
"""A name of a megabyte."""
DIGITS = 5_000
"""More digits of a whole number than Python reads (4,300)."""
DEEP = 2_000
"""More brackets within one another than Python's recursion allows (1,000)."""
VALID_SHARE = 0.3
"""How many of a call's arguments are as they should be, so that calls get past the first check."""

TEXTS: tuple[str, ...] = (
    "",
    " ",
    "\0",
    "a\0b",
    "..",
    "../../etc/passwd",
    "..\\..\\windows\\win.ini",
    "/etc/passwd",
    "C:\\Windows\\win.ini",
    "\\\\server\\share",
    "%2e%2e%2f%2e%2e%2fetc%2fpasswd",
    "file:///etc/passwd",
    "~root",
    "$HOME",
    "$(id)",
    "`id`",
    "'; DROP TABLE folding_runs; --",
    '" OR 1=1 --',
    "{run_id}",
    "%s%n%x",
    "{0.__class__}",
    "\ud800",
    "x\udfffy",
    "\u202edcba",
    "\ufeff",
    "\x1b[2J\x07",
    "one\r\nX-Injected: two",
    "line\nline",
    "١٢",
    "1e999",
    "NaN",
    "null",
    "true",
    "[1, 2]",
    '{"a": 1}',
    "[" * 500,
    "-0",
    "0x10",
    "1_0",
    "🗺️" * 50,
    "e\u0301" * 100,
    "<script>alert(1)</script>",
)
NUMBERS: tuple[float, ...] = (
    0,
    -1,
    1,
    2,
    2**31,
    -(2**63) - 1,
    2**64,
    10**30,
    10**400,
    0.5,
    -0.0,
    1e-320,
    1e308,
    -1e308,
    float("nan"),
    float("inf"),
    float("-inf"),
)


def hostile(rng: random.Random, depth: int = 2) -> Any:  # noqa: ANN401 - any JSON value, and some that are none
    """Any value: of the wrong kind, too large, too deep, not a number, half a character."""
    kinds: list[Callable[[], Any]] = [
        lambda: None,
        lambda: rng.choice([True, False]),
        lambda: rng.choice(NUMBERS),
        lambda: rng.choice(TEXTS),
        lambda: rng.choice(TEXTS) + rng.choice(TEXTS),
        lambda: rng.choice(TEXTS) * rng.randrange(1, 300),
    ]
    if depth:
        kinds += [
            lambda: [hostile(rng, depth - 1) for _ in range(rng.randrange(5))],
            lambda: {str(rng.choice(TEXTS)): hostile(rng, depth - 1) for _ in range(rng.randrange(4))},
            lambda: [rng.choice(NUMBERS)] * rng.choice([1, 2, 3, 3000]),
            lambda: nested(rng.choice([3, 30, 300])),
        ]
    return rng.choice(kinds)()


def nested(depth: int) -> list[Any]:
    """A list in a list in a list."""
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


def arguments_for(rng: random.Random, schema: Mapping[str, Any], run_ids: list[str]) -> dict[str, Any]:
    """Arguments for a tool with this schema: some as they should be, some not, some missing, some more than there are."""
    given: dict[str, Any] = {}
    for name, part in schema.get("properties", {}).items():
        if name == "run_id":
            given[name] = rng.choice(run_ids) if rng.random() < 1 - VALID_SHARE / 2 else hostile(rng)
        elif rng.random() < VALID_SHARE:
            given[name] = valid(rng, part)
        elif rng.random() < 1 - VALID_SHARE / 2:
            given[name] = hostile(rng)
    if rng.random() < VALID_SHARE / 3:
        given[rng.choice(TEXTS)] = hostile(rng)
    if rng.random() < 0.002:
        given[rng.choice([*given, LONG_NAME])] = LONG_NAME
    return given


def valid(rng: random.Random, part: Mapping[str, Any]) -> Any:  # noqa: ANN401 - whatever the schema says
    """A value that fits a part of a published schema."""
    if "enum" in part:
        return rng.choice(part["enum"])
    match part.get("type"):
        case "integer":
            return rng.randrange(int(part.get("minimum", 0)), int(part.get("maximum", 6)) + 1)
        case "number":
            return rng.uniform(float(part.get("minimum", -10)), float(part.get("maximum", 10)))
        case "array":
            return [rng.randrange(1, 6) for _ in range(int(part.get("minItems", 2)))]
        case "boolean":
            return rng.choice([True, False])
        case _:
            return rng.choice(["cat", "hat", "folding"])
