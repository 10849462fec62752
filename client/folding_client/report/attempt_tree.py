"""What a run tried: its attempts as a tree in which each grows from the frame that was saved before it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from folding_schemas.actions import Action, Actions
from folding_schemas.event_record import CallEvent, RecordedEvent, ResultEvent, VerdictEvent
from pydantic import TypeAdapter, ValidationError

from folding_client.protocol.acting import ACTIONS

_ACTION: TypeAdapter[Action] = TypeAdapter(Action)


@dataclass(eq=False)
class AttemptNode:
    """An attempt at a frame: its actions from the frame before, how it ended, the last verdict on it. ``attempt`` is 0 for
    a frame that was saved without an action. ``outcome`` is ``open``, ``given up``, ``saved`` or ``chosen``; ``overlay`` the
    file of the picture that came with the last comparison.
    """

    frame: int
    attempt: int
    parent: "AttemptNode | None" = field(default=None, repr=False)
    actions: list[Action] = field(default_factory=list)
    outcome: str = "open"
    verdict: str | None = None
    agreement: float | None = None
    overlay: str | None = None
    notes: str | None = None
    seq: int = 0
    grown: list["AttemptNode"] = field(default_factory=list)

    def way(self) -> Iterator["AttemptNode"]:
        """This node and those it grew from, the flat sheet last."""
        node: AttemptNode | None = self
        while node is not None:
            yield node
            node = node.parent


@dataclass(frozen=True)
class ReachedFrame:
    """What is saved for a frame: the actions from the frame before, the remark that was kept with it, and the recorded
    picture of its last comparison with the photo.
    """

    frame: int
    actions: Actions
    notes: str | None
    overlay: str | None = None


class AttemptTree:
    """Built from the events of a run. ``root`` is the flat sheet, frame 1."""

    def __init__(self, events: Iterable[RecordedEvent], run_id: str | None) -> None:
        self.root = AttemptNode(1, 0, outcome="saved")
        self.count = 0
        self._run_id = run_id
        self._saved: dict[int, AttemptNode] = {}
        self._base = self.root
        self._open: AttemptNode | None = None
        call: CallEvent | None = None
        for event in events:
            if isinstance(event, CallEvent):
                call = event
            elif isinstance(event, ResultEvent) and call is not None:
                self._add(call, event)
                call = None
            elif isinstance(event, VerdictEvent):
                self._at_hand.verdict = event.verdict or "NO VERDICT"

    @property
    def saved(self) -> dict[int, ReachedFrame]:
        """The frames that are saved in the end, in order."""
        return {
            frame: ReachedFrame(frame, tuple(node.actions), node.notes, node.overlay)
            for frame, node in sorted(self._saved.items())
        }

    def is_saved(self, node: AttemptNode) -> bool:
        """Whether a node is part of the result."""
        return self._saved.get(node.frame) is node

    def line(self, node: AttemptNode) -> Iterator[tuple[AttemptNode, list[AttemptNode]]]:
        """What grew from a node step by step, each with what was tried instead: along what is saved, else what was last."""
        while node.grown:
            best = max(node.grown, key=lambda each: (self.is_saved(each), bool(each.grown), each.seq))
            yield best, [each for each in node.grown if each is not best]
            node = best

    @property
    def _at_hand(self) -> AttemptNode:
        """The node that a verdict now tells of."""
        return self._open or self._base

    def _add(self, call: CallEvent, result: ResultEvent) -> None:
        arguments, answer = call.arguments, result.structured or {}
        if result.is_error or (self._run_id and arguments.get("run_id", self._run_id) != self._run_id):
            return
        if call.name in ACTIONS:
            self._act(call, answer)
        elif call.name == "undo" and self._open and self._open.actions:
            self._open.actions.pop()
        elif call.name == "compare_to_frame":
            self._compare(arguments, result)
        elif call.name == "save_checkpoint":
            self._save(answer.get("frame"), arguments.get("notes"), call.seq)
        elif call.name == "restore_checkpoint":
            self._restore(answer.get("frame"))
        elif call.name == "commit_attempt":
            self._commit(answer.get("frame"), answer.get("attempt"), arguments.get("state"))

    def _act(self, call: CallEvent, answer: dict[str, Any]) -> None:
        frame, attempt = answer.get("frame"), answer.get("attempt")
        if not isinstance(frame, int) or not isinstance(attempt, int):
            return
        told = {name: value for name, value in call.arguments.items() if name != "run_id"}
        try:
            action = _ACTION.validate_python({**told, "action": call.name})
        except ValidationError:
            return
        if self._open is None or (self._open.frame, self._open.attempt) != (frame, attempt):
            self._open = self._new(frame, attempt, call.seq)
        self._open.actions.append(action)
        self._open.verdict = self._open.agreement = self._open.overlay = None

    def _new(self, frame: int, attempt: int, seq: int) -> AttemptNode:
        node = AttemptNode(frame, attempt, self._base, seq=seq)
        self._base.grown.append(node)
        self.count += 1
        return node

    def _compare(self, arguments: dict[str, Any], result: ResultEvent) -> None:
        attempt, answer = arguments.get("attempt"), result.structured or {}
        node = self._at_hand if attempt is None else self._find(arguments.get("frame"), attempt)
        if node is not None and isinstance(answer.get("agreement"), int | float):
            node.agreement, node.verdict = float(answer["agreement"]), str(answer.get("verdict"))
            node.overlay = next((picture.file for picture in result.images), None)

    def _find(self, frame: object, attempt: object) -> AttemptNode | None:
        """The newest attempt with these numbers."""
        left, found = [self.root], None
        while left:
            node = left.pop()
            left += node.grown
            if (node.frame, node.attempt) == (frame, attempt) and (found is None or node.seq > found.seq):
                found = node
        return found

    def _save(self, frame: object, notes: object, seq: int) -> None:
        if not isinstance(frame, int):
            return
        if frame == 1:
            node = self.root
        elif self._open is None and self._base.frame == frame:
            node = self._base
        else:
            node = self._open or self._new(frame, 0, seq)
        node.outcome, node.notes = "saved", notes if isinstance(notes, str) else None
        self._settle(node)

    def _settle(self, node: AttemptNode) -> None:
        """Take a node and all that it grew from for what is saved, without later frames."""
        self._saved = {each.frame: each for each in node.way()}
        self._base, self._open = node, None

    def _restore(self, frame: object) -> None:
        if self._open is not None:
            self._open.outcome = "given up"
            self._open = None
        if isinstance(frame, int) and frame in self._saved:
            self._base = self._saved[frame]

    def _commit(self, frame: object, attempt: object, state: object) -> None:
        node = self._find(frame, attempt)
        if node is None:
            return
        if isinstance(state, int) and 0 < state < len(node.actions):
            node.actions = node.actions[:state]
        node.outcome = "chosen"
        self._settle(node)
