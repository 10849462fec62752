"""``Change``: one change of a run, decided on what the run is and recorded within one transaction."""

from datetime import UTC, datetime
from typing import Any

from folding_schemas.actions import Action

from folding_server.errors import RunError
from folding_server.store import rules
from folding_server.store.database import Transaction
from folding_server.store.run_events import Acted, Committed, Opened, Restored, RunEvent, Saved, Undone
from folding_server.store.views import RunView, step


class Change:
    """One change of a run, within the transaction that ``RunStore.change`` holds open for it.

    ``view`` is the run as it stands, and stays so until the transaction ends. One of the five methods is
    called, once: it checks the rules, records the event, and returns the run's new view. An exception
    afterwards, such as the simulator's refusal, takes the event back.

    Where the request was carried out before, ``view`` is the run as it stood then, and the method returns the
    view that came of it then, and records nothing. Raises RunError where it was another call.
    """

    def __init__(
        self, transaction: Transaction, view: RunView, request_id: str | None, recorded: RunEvent | None
    ) -> None:
        self.view = view
        self.after: RunView | None = None
        self._transaction = transaction
        self._request_id = request_id
        self._recorded = recorded

    def act(self, action: Action) -> RunView:
        """Add an action. Whether it is possible on the paper is for the caller to find out."""
        return self._record(Acted(**self._heading(), action=action))

    def undo(self) -> RunView:
        """Take back the newest action since the base checkpoint; back at the checkpoint, the attempt has ended."""
        return self._record(Undone(**self._heading()))

    def save(self, frame: int, notes: str | None = None) -> RunView:
        """Save the current state as the checkpoint of the frame after the base, and stand on it."""
        rules.check_notes(notes)
        return self._record(Saved(**self._heading(), frame=frame, notes=notes))

    def restore(self, frame: int, *, technical: bool = False) -> RunView:
        """Go back (or forth) to a frame's checkpoint; pending actions are given up, checkpoints stay.

        A ``technical`` return, because a reply was cut off, say, costs no attempt.
        """
        return self._record(Restored(**self._heading(), frame=frame, technical=technical))

    def commit(self, frame: int, attempt: int, state: int | None = None) -> RunView:
        """Choose an attempt for good: save it and the chain it grew from, lock these frames, stand on it.

        With ``state``, counted from 1, it is that one of the attempt's states, else its last.
        """
        return self._record(Committed(**self._heading(), frame=frame, attempt=attempt, state=state))

    def _heading(self) -> dict[str, Any]:
        """What the event to record has in common with all events."""
        return {"seq": self.view.seq + 1, "time": datetime.now(UTC), "request_id": self._request_id}

    def _record(self, event: RunEvent) -> RunView:
        assert self.after is None, "one change is one event"
        if self._recorded is not None:
            require_same_call(self._recorded, event)
        else:
            rules.check_event(self.view, event)
        self.after = step(self.view, self._recorded or event)
        if self._recorded is None:
            self._transaction.append(self.after, event)
        return self.after


def require_same_call(recorded: RunEvent, asked: RunEvent) -> None:
    """Raise RunError unless the event recorded for a request is what is asked for now.

    Of an opening only the sequence was asked for; the rest is what the sequence was like.
    """
    if isinstance(recorded, Opened) and isinstance(asked, Opened):
        same = recorded.sequence == asked.sequence
    else:
        same = recorded.model_copy(update={"seq": asked.seq, "time": asked.time}) == asked
    if not same:
        raise other_call(asked.request_id)


def other_call(request_id: str | None) -> RunError:
    """The refusal of a request id that another call has used."""
    return RunError(
        f"the request id {request_id} was used by an earlier call with another tool or other arguments; "
        f"send every call with a request id of its own"
    )
