"""Files that people write settings and prices in: TOML, YAML or JSON, by the end of their name."""

import json
import tomllib
from pathlib import Path
from typing import Any

from folding_client.interrupts import UsageError

SUFFIXES = (".toml", ".yaml", ".yml", ".json")


def read_mapping(path: Path) -> dict[str, Any]:
    """What a file says, by name. UsageError if it cannot be read, or says something else."""
    try:
        text = path.expanduser().read_text(encoding="utf-8")
        found = _parsed(path, text)
    except (OSError, RuntimeError) as error:
        message = f"Cannot read {path}: {getattr(error, 'strerror', None) or error}. Name a TOML, YAML or JSON file."
        raise UsageError(message) from error
    except ValueError as error:
        message = f"{path} cannot be read as {path.suffix[1:].upper()}: {' '.join(str(error).split())}."
        raise UsageError(message) from error
    if not isinstance(found, dict) or not all(isinstance(name, str) for name in found):
        message = f"{path} holds no settings by name; write one a line, such as max_queries = 100 in TOML."
        raise UsageError(message)
    return found


def _parsed(path: Path, text: str) -> Any:
    match path.suffix.lower():
        case ".toml":
            return tomllib.loads(text)
        case ".json":
            return json.loads(text)
        case ".yaml" | ".yml":
            import yaml

            try:
                return yaml.safe_load(text) or {}
            except yaml.YAMLError as error:
                raise ValueError(error) from error
    message = f"{path} does not say what it is; its name has to end in one of {', '.join(SUFFIXES)}."
    raise UsageError(message)
