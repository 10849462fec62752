"""Actions derived between states that are rounded, renumbered and lettered as data sets have them.

    PYTHONPATH=benchmarks .venv/bin/python benchmarks/derivation.py [PROGRAM.json ...]

Prints JSON: for each program (those of the examples and of ``benchmarks/reconstruction/programs`` if none is named) how many of
its steps were derived, and which only from the state in the file or not at all, with the reasons and the seconds it took.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from corrupted_states import PROGRAMS
from data_set_states import data_set_states
from folding_server.derivation.sequence_derivation import derive_sequence
from folding_server.interchange.fold_reading import FaceOrders
from folding_server.interchange.programs import load_program


def derive(file: Path) -> dict[str, Any]:
    """What is derived of the states of a program."""
    program = load_program(file.read_text(encoding="utf-8"))
    documents = data_set_states(program)
    started = time.perf_counter()
    found = derive_sequence(documents, FaceOrders.VIEWER)
    return {
        "program": file.stem,
        "steps": len(program.steps),
        "replayed": sum(step.actions is not None and not step.restarted for step in found.steps),
        "restarted": [step.frame for step in found.steps if step.restarted],
        "not derived": {step.frame: step.reason for step in found.steps if step.actions is None},
        "seconds": round(time.perf_counter() - started, 1),
    }


def main() -> None:
    """Derive each, tell of each on stderr, and print all."""
    found = []
    for file in map(Path, sys.argv[1:] or map(str, PROGRAMS)):
        found.append(derive(file))
        sys.stderr.write(f"{found[-1]}\n")
    total = {name: sum(each[name] for each in found) for name in ("steps", "replayed")}
    print(json.dumps({**total, "programs": found}, indent=1))


if __name__ == "__main__":
    main()
