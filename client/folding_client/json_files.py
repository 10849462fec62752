"""JSON files of a known form that a user names."""

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from folding_client.interrupts import UsageError

_File = TypeVar("_File", bound=BaseModel)


def read_json_file(kind: type[_File], file: Path, form: str, expected: str) -> _File:
    """What a file says. UsageError if it cannot be read, or not as ``form``, such as ``"an evaluation"``; ``expected`` is what to
    name instead, such as ``"what foldingagent evaluate --json printed"``.
    """
    try:
        return kind.model_validate_json(file.read_bytes())
    except OSError as error:
        message = f"Cannot read {file}: {error.strerror}. Name {expected}."
        raise UsageError(message) from error
    except ValidationError as error:
        message = f"{file} cannot be read as {form} ({first_error(error)}); name {expected}."
        raise UsageError(message) from error


def first_error(error: ValidationError) -> str:
    """The first thing that is wrong with a document, and where."""
    first = error.errors()[0]
    where = ".".join(map(str, first["loc"]))
    return f"{where}: {first['msg']}" if where else first["msg"]
