"""The selector: which of the attempts comes closest, when the budget of a frame is spent (paper,
"Selector")?
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal, Protocol

from folding_prompts import prompt
from folding_schemas.results import AttemptList, Comparison, FrameView

from folding_client.interrupts import ReplyUnreadable, StepHopeless, ToolRefused
from folding_client.messages import Picture, system, user
from folding_client.protocol.server_client import ServerClient
from folding_client.roles.reply_parsing import read_label
from folding_client.roles.reply_repair import read_answer
from folding_client.roles.role_client import RoleClient


@dataclass(frozen=True)
class Choice:
    """The attempt chosen, who chose it, and why, in words for the record."""

    attempt: int
    by: Literal["model", "geometric"]
    reason: str


class Selector(Protocol):
    """Chooses among the attempts at a frame."""

    async def choose(self, attempts: AttemptList, diagrams: tuple[Picture, ...]) -> Choice:
        """One of the attempts; ``diagrams`` shows their states in the same order."""
        ...


class GeometricSelector:
    """Chooses by comparing the state that each attempt came to, ancestors included, with the photo."""

    def __init__(self, server: ServerClient) -> None:
        self._server = server

    async def choose(self, attempts: AttemptList, diagrams: tuple[Picture, ...]) -> Choice:  # noqa: ARG002
        """The attempt whose state agrees best with the photo; the first of several that agree alike.

        StepHopeless if none can be compared with the photo.
        """
        why = "there is none"
        found = []
        for attempt in attempts.attempts:
            try:
                found.append((attempt, await self._agreement(attempts.frame, attempt.attempt)))
            except ToolRefused as refusal:
                why = str(refusal)
        if not found:
            message = f"No attempt at frame {attempts.frame} can be compared with its photo: {why}"
            raise StepHopeless(message)
        best, agreement = max(found, key=lambda pair: pair[1])
        return Choice(best.attempt, "geometric", f"{best.label}: agreement {agreement:.4f}")

    async def _agreement(self, frame: int, attempt: int) -> float:
        comparison, _ = await self._server.ask(Comparison, "compare_to_frame", frame=frame, attempt=attempt)
        return comparison.agreement


class ModelSelector:
    """Chooses by a vision-language model that answers with a label; without one, twice, by geometry."""

    def __init__(self, role_client: RoleClient, server: ServerClient) -> None:
        self._role_client = role_client
        self._server = server

    async def choose(self, attempts: AttemptList, diagrams: tuple[Picture, ...]) -> Choice:
        """The attempt that the model names."""
        _, photo = await self._server.ask(FrameView, "view_frame", frame=attempts.frame)
        labels = ", ".join(f"B{index}" for index in range(1, len(attempts.attempts) + 1))
        messages = [
            system(prompt("selector/system")),
            user(prompt("selector/user", labels=labels), (*photo, *diagrams)),
        ]
        read = partial(read_label, count=len(attempts.attempts))
        try:
            label = await read_answer(self._role_client, messages, read, partial(_repair, labels))
        except ReplyUnreadable as reason:
            choice = await GeometricSelector(self._server).choose(attempts, diagrams)
            why = f"the selector named no label, twice ({reason}); {choice.reason}"
            return Choice(choice.attempt, "geometric", why)
        return Choice(attempts.attempts[label - 1].attempt, "model", f"B{label}")


def _repair(labels: str, reason: str) -> str:
    return prompt("selector/again", reason=reason, labels=labels)
