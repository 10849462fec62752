"""What was tried for a frame: attempts, the states that each came to, and the checkpoints it grew from."""

from dataclasses import dataclass, replace

from folding_schemas.actions import Actions, AddVertex
from folding_schemas.results import AttemptOutcome


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A saved frame: ``actions`` lead to it from the frame before, ``path`` from the flat sheet."""

    frame: int
    actions: Actions
    path: Actions
    notes: str | None = None


@dataclass(frozen=True, slots=True)
class Attempt:
    """One explored transition to ``frame``: its ancestors, checkpoints 1..frame-1, and the actions to its last state.

    ``states`` has the actions to each state that it came to, in the order in which actions reached them last, its last
    state among them once it has ended. A state that differs from the next by a vertex added alone is left out, since
    it looks the same. What is not ``counted``, a step that was cut short, costs no attempt.
    """

    frame: int
    number: int
    ancestors: tuple[Checkpoint, ...]
    actions: Actions = ()
    outcome: AttemptOutcome = "open"
    notes: str | None = None
    states: tuple[Actions, ...] = ()
    counted: bool = True

    @property
    def label(self) -> str:
        """The name under which a selector sees the attempt: B1, B2, ..."""
        return f"B{self.number}"

    @property
    def base_path(self) -> Actions:
        """All actions from the flat sheet to the checkpoint that the attempt grew from."""
        return self.ancestors[-1].path

    @property
    def path(self) -> Actions:
        """All actions from the flat sheet to the attempt's state."""
        return self.base_path + self.actions

    def checkpoint(self) -> Checkpoint:
        """The attempt's state as a checkpoint of its frame."""
        return Checkpoint(self.frame, self.actions, self.path, self.notes)

    def chain(self) -> tuple[Checkpoint, ...]:
        """The checkpoints that a commitment to the attempt would make."""
        return (*self.ancestors, self.checkpoint())

    def at(self, state: int) -> "Attempt":
        """The attempt as it was at one of its states, counted from 1."""
        return replace(self, actions=self.states[state - 1])

    def acted(self, actions: Actions) -> "Attempt":
        """The attempt after an action, to which these lead from its checkpoint."""
        states = tuple(each for each in self.states if each != actions)
        if states and states[-1] == actions[:-1] and isinstance(states[-1][-1], AddVertex):
            states = states[:-1]
        return replace(self, actions=actions, states=(*states, actions))

    def ended(self, outcome: AttemptOutcome, *, counted: bool = True) -> "Attempt":
        """The attempt when it is over."""
        states = self.states if self.actions in self.states else (*self.states, self.actions)
        return replace(self, outcome=outcome, counted=counted and self.counted, states=states)

    def taken_back(self) -> "Attempt":
        """The attempt after an undo to its checkpoint, which ends it. It came to the state that actions reached last."""
        return replace(self, actions=self.states[-1], outcome="restored")
