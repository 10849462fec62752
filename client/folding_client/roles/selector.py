"""The selector: which of the states that were tried comes closest, when the budget of a frame is spent (paper,
"Selector")?
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal, Protocol

from folding_prompts import prompt
from folding_schemas.actions import Action
from folding_schemas.results import AttemptCommitted, AttemptList, AttemptState, Comparison, FrameView

from folding_client.interrupts import ReplyUnreadable, StepHopeless, ToolRefused
from folding_client.messages import Picture, system, user
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.roles.reply_parsing import read_label
from folding_client.roles.reply_repair import read_answer
from folding_client.roles.role_client import RoleClient


@dataclass(frozen=True)
class Candidate:
    """A state that can be chosen, and its diagram. The ``label`` is the name under which a selector sees it."""

    label: str
    tried: AttemptState
    diagram: Picture


@dataclass(frozen=True)
class Choice:
    """The candidate chosen, who chose it, and why, in words for the record."""

    candidate: Candidate
    by: Literal["model", "geometric"]
    reason: str


class Selector(Protocol):
    """Chooses among the states that the attempts at a frame came to."""

    async def choose(self, frame: int, candidates: Sequence[Candidate]) -> Choice:
        """One of the candidates, of which there is at least one."""
        ...


async def settle(server: ServerClient, selector: Selector, recorder: Recorder, frame: int) -> None:
    """Have a state chosen for a frame, and commit it. StepHopeless if there is none, or none can be told from others."""
    listed, diagrams = await server.ask(AttemptList, "list_attempts", frame=frame)
    found = selectable(listed, diagrams)
    if not found:
        message = f"No attempt at frame {frame} can be chosen; resume to try again."
        raise StepHopeless(message)
    choice = await selector.choose(frame, found)
    tried = choice.candidate.tried
    chosen = {"frame": frame, "attempt": tried.attempt} | ({} if tried.last else {"state": tried.state})
    unseen = f"; {listed.left_out} older states were not shown" if listed.left_out else ""
    recorder.event(
        "selected", **chosen, rewrites=tried.rewrites, by=choice.by, reason=f"{choice.reason}{unseen}"
    )
    try:
        await server.ask(AttemptCommitted, "commit_attempt", **chosen)
    except ToolRefused as refusal:
        raise StepHopeless(str(refusal)) from refusal


def selectable(attempts: AttemptList, diagrams: Sequence[Picture]) -> list[Candidate]:
    """The states that can be chosen: first those from what is saved for the frame before, then those from other frames.

    A state that several attempts came to from the same frames is a candidate once.
    """
    pairs = [
        (tried, diagram)
        for tried, diagram in zip(attempts.states, diagrams, strict=True)
        if tried.committable
    ]
    here = _different([pair for pair in pairs if pair[0].on_path])
    elsewhere = [pair for pair in pairs if not pair[0].on_path]
    return [
        Candidate(f"B{number}", tried, diagram)
        for number, (tried, diagram) in enumerate([*here, *elsewhere], start=1)
    ]


def _different(pairs: Sequence[tuple[AttemptState, Picture]]) -> list[tuple[AttemptState, Picture]]:
    """The states without those that the same actions led to before."""
    different: dict[tuple[Action, ...], tuple[AttemptState, Picture]] = {}
    for pair in pairs:
        different.setdefault(tuple(pair[0].actions), pair)
    return list(different.values())


class GeometricSelector:
    """Chooses by comparing each state, ancestors included, with the photo."""

    def __init__(self, server: ServerClient) -> None:
        self._server = server

    async def choose(self, frame: int, candidates: Sequence[Candidate]) -> Choice:
        """The state that agrees best with the photo; the first of several that agree alike, so rather one that rewrites
        no earlier frame.

        StepHopeless if none can be compared.
        """
        found, why = [], "there is none"
        for candidate in candidates:
            try:
                found.append((candidate, await self._agreement(frame, candidate.tried)))
            except ToolRefused as refusal:
                why = str(refusal)
        if not found:
            message = f"No attempt at frame {frame} can be compared with its photo: {why}"
            raise StepHopeless(message)
        best, agreement = max(found, key=lambda pair: pair[1])
        return Choice(best, "geometric", f"{best.label}: agreement {agreement:.4f}")

    async def _agreement(self, frame: int, tried: AttemptState) -> float:
        state = {} if tried.last else {"state": tried.state}
        comparison, _ = await self._server.ask(
            Comparison, "compare_to_frame", frame=frame, attempt=tried.attempt, **state
        )
        return comparison.agreement


class ModelSelector:
    """Chooses by a vision-language model that answers with a label; without one, twice, by geometry."""

    def __init__(self, role_client: RoleClient, server: ServerClient) -> None:
        self._role_client = role_client
        self._server = server

    async def choose(self, frame: int, candidates: Sequence[Candidate]) -> Choice:
        """The candidate that the model names."""
        _, photo = await self._server.ask(FrameView, "view_frame", frame=frame)
        labels = ", ".join(each.label for each in candidates)
        named = [
            *(each.named(f"A: {each.subject}") for each in photo),
            *(each.diagram.named(f"{each.label}:{_origin(each.tried)}") for each in candidates),
        ]
        question = prompt("selector/user", labels=labels, other_paths=_other_paths(candidates))
        messages = [system(prompt("selector/system")), user(question, tuple(named))]
        read = partial(read_label, count=len(candidates))
        try:
            label = await read_answer(self._role_client, messages, read, partial(_repair, labels))
        except ReplyUnreadable as reason:
            choice = await GeometricSelector(self._server).choose(frame, candidates)
            why = f"the selector named no label, twice ({reason}); {choice.reason}"
            return Choice(choice.candidate, "geometric", why)
        return Choice(candidates[label - 1], "model", f"B{label}")


def _origin(tried: AttemptState) -> str:
    """Where a state comes from, for a model that sees its diagram."""
    return "" if tried.on_path else f" (from other frames; {_rewriting(tried.rewrites)})"


def _rewriting(frames: Sequence[int]) -> str:
    """What choosing a state does to earlier frames."""
    return (
        f"choosing it rewrites frames {', '.join(map(str, frames))}"
        if frames
        else "choosing it rewrites none"
    )


def _other_paths(candidates: Sequence[Candidate]) -> str:
    """A word on the candidates that would rewrite earlier frames, if there are any."""
    others = [each.label for each in candidates if not each.tried.on_path]
    return prompt("selector/other_paths", others=", ".join(others)) if others else ""


def _repair(labels: str, reason: str) -> str:
    return prompt("selector/again", reason=reason, labels=labels)
