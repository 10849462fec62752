"""Writes the JSON schemas of a run's files anew: ``PYTHONPATH=tests .venv/bin/python tests/contract/record_contract.py``."""

import json
from pathlib import Path

import folding_schemas
from folding_schemas.event_record import record_schemas

FOLDER = Path(folding_schemas.__file__).parent


def published() -> dict[str, str]:
    """The text of each schema, by its file's name."""
    return {name: json.dumps(schema, indent=1) + "\n" for name, schema in record_schemas().items()}


if __name__ == "__main__":
    for name, text in published().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
        print(f"wrote {FOLDER / name}")
