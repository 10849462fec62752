"""What is said of a value that an option or a setting cannot have: the value, what is allowed, in place of pydantic's words."""

from typing import Any

import typer
from pydantic import ValidationError
from pydantic_core import ErrorDetails

LONGEST_SHOWN = 80
"""Characters of a bad value that are repeated."""


def allowed_in_words(error: ErrorDetails, least: float | None = None, most: float | None = None) -> str:
    """What to give instead of a value that pydantic refused; ``least`` and ``most`` are bounds, where they are known."""
    told: dict[str, Any] = {"ge": least, "le": most} | error.get("ctx", {})
    kind = error["type"]
    if kind.startswith("int"):
        return f"give a whole number{_range(told)}"
    if kind in {"float_parsing", "float_type", "finite_number"}:
        return f"give a number{_range(told)}"
    if kind in {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}:
        return f"give a number{_range(told)}"
    if kind in {"literal_error", "enum"}:
        return f"give {told['expected']}"
    if kind.startswith("bool"):
        return "give true or false"
    return error["msg"].removeprefix("Value error, ").rstrip(".")


def usage_sentence(error: typer.TyperException) -> str:
    """A mistake on the command line as one line that names the bad value and what is allowed."""
    cause, param = error.__cause__, getattr(error, "param", None)
    if not isinstance(cause, ValidationError) or param is None:
        return _with_advice(error)
    first = cause.errors(include_url=False)[0]
    words = allowed_in_words(first, getattr(param, "min", None), getattr(param, "max", None))
    if first["type"] != "value_error":  # typer's own words name the value
        words = f"{_shown(first['input'])} is not possible; {words}"
    return f"Invalid value for {param.get_error_hint()}: {words}."


def _with_advice(error: typer.TyperException) -> str:
    """Typer's own line, and where to look what there is if it says no more than that something is wrong."""
    said = " ".join(error.format_message().split()).rstrip(".")
    says_what = isinstance(error, typer.BadParameter) and error.message
    return f"{said}." if says_what else f"{said}; --help says what there is."


def _range(told: dict[str, Any]) -> str:
    """The bounds of a number in words."""
    if (above := told.get("gt")) is not None:
        return f" greater than {above:.12g}"
    if (below := told.get("lt")) is not None:
        return f" smaller than {below:.12g}"
    least, most = told.get("ge"), told.get("le")
    if least is not None and most is not None:
        return f" from {least:.12g} to {most:.12g}"
    return (
        f" from {least:.12g}" if least is not None else f" of at most {most:.12g}" if most is not None else ""
    )


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."
