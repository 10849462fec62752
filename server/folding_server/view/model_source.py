"""What ``foldingagent-server view`` is pointed at: a program's file, a run folder of the client, or a stored run."""

import json
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from folding_schemas.actions import Program

from folding_server.data_folder import data_folder
from folding_server.errors import FoldingError, PhotoError
from folding_server.frames.added_sequences import added_folder
from folding_server.frames.sequences import Library, Sequence, load_sequence
from folding_server.interchange.program_files import program_in
from folding_server.store.database import DATABASE_NAME
from folding_server.store.run_ids import is_run_id
from folding_server.store.run_store import RunStore
from folding_server.typed_path import typed_path
from folding_server.typed_text import text_in
from folding_server.view.local_model import LocalModel
from folding_server.view.photo_strip import photos_of
from folding_server.view.stops import ViewWindow

_WANTED = "give a program's JSON file or the folder of a run"

Tell = Callable[[str], None]
"""Says one sentence to the user, such as why there are no photos."""


@dataclass(frozen=True)
class StoredRuns:
    """Where stored runs are looked for: in a data folder, or in the database at an SQLAlchemy URL instead."""

    data: Path
    database: str | None = None

    def open(self, run_id: str) -> RunStore:
        """The store that may hold a run. FoldingError if there is none yet: nothing is made by looking."""
        if self.database is not None:
            return RunStore(self.database)
        if not (self.data / DATABASE_NAME).is_file():
            raise FoldingError(
                f"There is no run {run_id!r}: the data folder {self.data} holds no runs; name another with --data."
            )
        return RunStore.in_folder(self.data)

    def library(self, sequences: Iterable[Path], owner: str | None) -> Library:
        """The sequences in folders, and those that the owner of a run has added. PhotoError if a folder is missing."""
        return Library(list(sequences), added_folder(self.data, owner))


def asked_model(
    source: str, data: Path | None, database: str | None, sequences: Iterable[Path] = ()
) -> LocalModel:
    """The model that a command is asked for, as ``open_model`` has it, with its options; what there is to tell goes to stderr."""

    def tell(sentence: str) -> None:
        sys.stderr.write(sentence + "\n")

    return open_model(source, StoredRuns(data_folder(data), database), sequences, tell)


def open_model(source: str, stored: StoredRuns, sequences: Iterable[Path], tell: Tell) -> LocalModel:
    """The model that ``source`` names: a program's file, a run folder, or the id of one of the ``stored`` runs.

    Photos come from the run's own sequence folder, or for a stored run from ``sequences``; ``tell`` is told why
    there are none. FoldingError if ``source`` is none of the three or cannot be read.
    """
    path = typed_path(source)
    try:
        is_folder, is_file = path.is_dir(), path.is_file()
    except OSError as error:
        raise FoldingError(
            f"{source!r:.80} cannot be looked at ({error.strerror}); give a program's JSON file, the folder of a run, or a run id."
        ) from error
    if is_folder:
        return _of_run_folder(path, tell)
    if is_file:
        return LocalModel(program_in(text_in(path, _WANTED)))
    if is_run_id(source):
        return _of_stored_run(
            stored, source, lambda name, owner: stored.library(sequences, owner).open(name), tell
        )
    raise FoldingError(
        f"There is no program, run folder or run {source!r}; give a program's JSON file, the folder of a run, or a run id."
    )


def _of_run_folder(folder: Path, tell: Tell) -> LocalModel:
    """A run of the client, finished or not."""
    about = _json(folder / "run.json")
    sequence = about.get("sequence")
    recorded = sequence.get("folder") if isinstance(sequence, dict) else None

    def photos(_name: str, _owner: str | None = None) -> Sequence:
        if not isinstance(recorded, str):
            raise PhotoError(f"{folder / 'run.json'} names no folder of photos")
        return load_sequence(Path(recorded))

    run_id = about.get("run_id")
    if isinstance(run_id, str) and (folder / "store" / DATABASE_NAME).is_file():
        return _of_stored_run(StoredRuns(folder / "store"), run_id, photos, tell)
    program = program_in(text_in(folder / "program.json", _WANTED))
    return LocalModel(program, _photos(lambda: photos(program.name), program, tell))


def _of_stored_run(
    stored: StoredRuns, run_id: str, find: Callable[[str, str | None], Sequence], tell: Tell
) -> LocalModel:
    with stored.open(run_id) as store:
        run, owner = store.load(run_id), store.owner_of(run_id)
    program = run.current_program()
    name = run.sequence
    return LocalModel(program, None if name is None else _photos(lambda: find(name, owner), program, tell))


def _photos(
    find: Callable[[], Sequence], program: Program, tell: Tell
) -> Callable[[ViewWindow], dict[int, str]] | None:
    """The photos of a run's frames; None where they cannot be had."""
    try:
        sequence = find()
    except PhotoError as error:
        tell(f"Shown without photos: {error}.")
        return None
    return lambda window: photos_of(sequence, range(1, len(program.steps) + 2), window)


def _json(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(text_in(path, _WANTED))
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise FoldingError(f"{path} is not the record of a run; give the folder of a run of foldingagent.")
    return document
