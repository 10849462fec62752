"""The state of a search as a file of its run's folder, so that a resumed run knows what was tried."""

from pydantic import ValidationError

from folding_client.interrupts import UsageError
from folding_client.record.folder import RunFolder
from folding_client.record.recorder import Recorder
from folding_client.search.search_state import SearchState

SEARCH_FILE = "search.json"


def known_search(recorder: Recorder) -> SearchState:
    """What a run that is resumed has tried; nothing for one that has not been opened."""
    return read_search(recorder.folder) if "run_id" in recorder.about else SearchState()


def read_search(folder: RunFolder) -> SearchState:
    """The state that was written last; an empty one if none was. UsageError if it cannot be read."""
    file = folder.path / SEARCH_FILE
    try:
        return SearchState.model_validate_json(file.read_bytes())
    except FileNotFoundError:
        return SearchState()
    except (OSError, ValidationError) as error:
        message = (
            f"{file} is not a search of format 1, so the run cannot go on from it; remove it to search anew."
        )
        raise UsageError(message) from error


def write_search(folder: RunFolder, state: SearchState) -> None:
    """Write the state in one move: a kill leaves the old state or the new."""
    folder.write_json(SEARCH_FILE, state.model_dump(mode="json", exclude_none=True))
