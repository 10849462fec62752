"""What is known of the sequences that were to be reconstructed: folders and files of programs, or of states."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, cast

from folding_schemas.actions import Actions, Program
from folding_schemas.evaluation import StepClass
from pydantic import ValidationError

from folding_client.interrupts import UsageError
from folding_client.json_files import first_error
from folding_client.reconstruct import sequence_name

PROGRAM_FILE = "program.json"
STATES_FOLDER = "states"
"""The folder of a sequence with a FOLD file for each frame, ``000001.fold`` and so on; it goes before the program."""
DERIVATION_FILE = "derivation.json"
"""The actions of each step beside such states, as far as they are known."""


@dataclass(frozen=True)
class SequenceTruth:
    """The true states of a sequence: a program's, or the FOLD files of its frames. Frames without a file are not scored.

    ``steps`` are the actions to each frame from 2 on, None where they are not known; ``sheet`` is the width and height of what
    they fold, which need not be quite square: no sheet that was photographed is.
    """

    name: str
    steps: tuple[Actions | None, ...]
    state_files: Mapping[int, Path] = field(default_factory=dict)
    sheet: tuple[float, float] = (1.0, 1.0)

    @property
    def frames(self) -> int:
        """How many keyframes the sequence has."""
        return len(self.steps) + 1

    @cached_property
    def classes(self) -> dict[int, StepClass]:
        """What is done to come to each frame from 2 on."""
        return {frame: step_class(step) for frame, step in enumerate(self.steps, start=2)}


def step_class(step: Actions | None) -> StepClass:
    """The class of a step: its one kind of action besides add_vertex, ``compound`` if there are several."""
    if step is None:
        return "unknown"
    kinds = {action.action for action in step if action.action != "add_vertex"}
    if len(kinds) > 1:
        return "compound"
    return cast("StepClass", next(iter(kinds), "none"))


def truths_in(source: Path, names: Sequence[str] = ()) -> dict[str, SequenceTruth]:
    """The sequences below a folder by name, in order: folders with a program or states, and files of programs.

    With ``names`` only those. UsageError if there is none, a name is not there, two have one name, or a file cannot be read.
    """
    if not source.is_dir():
        message = f"There is no folder {source}; name with --truth a folder of sequences that hold a {PROGRAM_FILE}, or of programs."
        raise UsageError(message)
    found: dict[str, SequenceTruth] = {}
    for truth in _truths(source):
        if truth.name in found:
            message = f"{source} holds two sequences named {truth.name}; rename one, or name a folder with one of them."
            raise UsageError(message)
        found[truth.name] = truth
    if missing := [name for name in names if name not in found]:
        message = f"{source} holds no sequence {missing[0]!r}; it holds {', '.join(sorted(found)) or 'none'}."
        raise UsageError(message)
    if not found:
        message = f"{source} holds no truth: no folder with a {PROGRAM_FILE} or a folder {STATES_FOLDER}, and no program."
        raise UsageError(message)
    return {name: found[name] for name in sorted(names or found)}


def _truths(source: Path) -> Iterator[SequenceTruth]:
    folders = [source] if _is_truth(source) else sorted(each for each in source.iterdir() if _is_truth(each))
    for folder in folders:
        yield _of_folder(folder)
    if not folders:
        for file in sorted(source.glob("*.json")):
            document = _document(file)
            if "steps" in document:
                yield _of_program(str(document.get("name") or file.stem), _program(file, document))


def _is_truth(folder: Path) -> bool:
    return (folder / PROGRAM_FILE).is_file() or (folder / STATES_FOLDER).is_dir()


def _of_folder(folder: Path) -> SequenceTruth:
    name = sequence_name(folder.resolve())
    files = {
        int(file.stem): file
        for file in sorted((folder / STATES_FOLDER).glob("*.fold"))
        if file.stem.isdecimal()
    }
    if not files:
        return _of_program(name, _program(folder / PROGRAM_FILE, _document(folder / PROGRAM_FILE)))
    return SequenceTruth(name, _derived(folder, max(files) - 1), files)


def _of_program(name: str, program: Program) -> SequenceTruth:
    return SequenceTruth(name, program.steps, sheet=program.sheet)


def _derived(folder: Path, count: int) -> tuple[Actions | None, ...]:
    """The actions of ``count`` steps beside states."""
    if (file := folder / DERIVATION_FILE).is_file():
        steps = [
            None if step.get("actions") is None else Program(steps=(step["actions"],)).steps[0]
            for step in _document(file).get("steps", [])
        ]
    elif (file := folder / PROGRAM_FILE).is_file():
        steps = list(_program(file, _document(file)).steps)
    else:
        steps = []
    return tuple((*steps, *[None] * count)[:count])


def _document(file: Path) -> dict[str, Any]:
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = f"{file} cannot be read: {error}."
        raise UsageError(message) from error
    return document if isinstance(document, dict) else {}


def _program(file: Path, document: dict[str, Any]) -> Program:
    """The program in a document, without what published ones say besides."""
    known = {key: value for key, value in document.items() if key in Program.model_fields}
    try:
        return Program.model_validate(known)
    except ValidationError as error:
        message = f"{file} cannot be read as a program: {first_error(error)}."
        raise UsageError(message) from error
