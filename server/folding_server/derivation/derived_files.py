"""A derived sequence as files: the state of each frame, the steps, and the program if all of it is known."""

import json
from pathlib import Path
from typing import Any

from folding_schemas.actions import Actions

from folding_server.derivation.given_files import given_documents
from folding_server.derivation.sequence_derivation import DerivedSequence, derive_sequence
from folding_server.errors import FoldingError
from folding_server.interchange.fold_format import fold_document, fold_text
from folding_server.interchange.fold_reading import FaceOrders
from folding_server.interchange.programs import program_text


def derive_files(source: Path, out: Path, face_orders: FaceOrders, name: str) -> dict[str, Any]:
    """Derive the actions between the states at ``source``; write ``states``, ``derivation.json`` and, if every step is known,
    ``program.json`` into the folder ``out``. What ``derivation.json`` says.
    """
    derived = derive_sequence(given_documents(source), face_orders)
    told = derivation_document(derived, name)
    try:
        (out / "states").mkdir(parents=True, exist_ok=True)
        for frame, paper in enumerate(derived.papers, start=1):
            if paper is None:
                continue
            text = fold_text(fold_document(paper, f"{name}, frame {frame}"))
            (out / "states" / f"{frame:06}.fold").write_text(text, encoding="utf-8")
        (out / "derivation.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        program = derived.program(name)
        if program is not None:
            (out / "program.json").write_text(program_text(program), encoding="utf-8")
    except OSError as error:
        raise FoldingError(f"{out} cannot be written to ({error.strerror}); give another folder.") from error
    return told


def derivation_document(derived: DerivedSequence, name: str) -> dict[str, Any]:
    """What was derived, step by step, and why not where not."""
    return {
        "name": name,
        "frames": len(derived.papers),
        "start": {"creases": derived.creases, "actions": _plain(derived.start)},
        "steps": [
            {
                "frame": step.frame,
                "actions": _plain(step.actions),
                "reason": step.reason,
                "restarted": step.restarted,
            }
            for step in derived.steps
        ],
        "derived": sum(step.actions is not None for step in derived.steps),
        "program": derived.program(name) is not None,
    }


def _plain(actions: Actions | None) -> list[dict[str, Any]] | None:
    return (
        None if actions is None else [action.model_dump(mode="json", exclude_none=True) for action in actions]
    )
