"""The store as most of its tests use it: every change a call of its own."""

from folding_schemas.actions import Action
from folding_server.store.run_store import RunStore
from folding_server.store.views import RunView


class DirectStore(RunStore):
    """A store of which one change is asked for at a time, with nothing to decide in between."""

    def act(self, run_id: str, action: Action, request_id: str | None = None) -> RunView:
        with self.change(run_id, request_id) as change:
            return change.act(action)

    def undo(self, run_id: str, request_id: str | None = None) -> RunView:
        with self.change(run_id, request_id) as change:
            return change.undo()

    def save(
        self, run_id: str, frame: int, notes: str | None = None, request_id: str | None = None
    ) -> RunView:
        with self.change(run_id, request_id) as change:
            return change.save(frame, notes)

    def restore(
        self, run_id: str, frame: int, request_id: str | None = None, *, technical: bool = False
    ) -> RunView:
        with self.change(run_id, request_id) as change:
            return change.restore(frame, technical=technical)

    def commit(
        self,
        run_id: str,
        frame: int,
        attempt: int,
        state: int | None = None,
        request_id: str | None = None,
    ) -> RunView:
        with self.change(run_id, request_id) as change:
            return change.commit(frame, attempt, state)
