"""The critic: does the candidate state explain the target photo (paper, section "Critic")?

A critic is asked with a ``CriticCase`` and answers with a ``Judgement``. No verdict is an outcome of its own.
"""

from dataclasses import dataclass
from functools import partial
from typing import Protocol

from folding_prompts import prompt
from folding_schemas.results import ActionClass, Comparison, Verdict
from folding_schemas.state import FoldedState
from pydantic import BaseModel, ConfigDict, Field

from folding_client.interrupts import ReplyUnreadable
from folding_client.messages import Message, Picture, lettered, system, user
from folding_client.protocol.server_client import ServerClient
from folding_client.roles.reply_parsing import NO_ANCHOR, CriticReply, read_form, with_words
from folding_client.roles.reply_repair import read_answer
from folding_client.roles.role_client import RoleClient


class FoldAnchor(BaseModel):
    """A relation in the target photo by which a fold can be checked."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    moving_element: str = Field(min_length=1, description="what moves")
    static_reference: str = Field(min_length=1, description="what stays")
    relationship: str = Field(min_length=1, description="how the two lie to each other in the photo")


@dataclass(frozen=True)
class CriticCase:
    """A transition to judge: four pictures (photos of source and target, diagrams of source and candidate),
    the two states behind the diagrams, and what the agent says it did.
    """

    frame: int
    action_classes: tuple[ActionClass, ...]
    anchor: FoldAnchor | None
    source: FoldedState
    candidate: FoldedState
    pictures: tuple[Picture, ...]
    colors: tuple[str, str]


@dataclass(frozen=True)
class Judgement:
    """A critic's answer; ``verdict`` is None if it gave none that can be read, and ``analysis`` then says
    why, and what the critic wrote.
    """

    verdict: Verdict | None
    analysis: str
    anchor_check: str = NO_ANCHOR
    discrepancies: tuple[str, ...] = ()


class Critic(Protocol):
    """Judges a candidate."""

    async def judge(self, case: CriticCase) -> Judgement:
        """The critic's answer to one case."""
        ...


class GeometricCritic:
    """Judges by ``compare_to_frame``: no model, no words on anchors."""

    def __init__(self, server: ServerClient) -> None:
        self._server = server

    async def judge(self, case: CriticCase) -> Judgement:
        """The verdict of the geometric comparison of the current state with the photo."""
        comparison, _ = await self._server.ask(Comparison, "compare_to_frame", frame=case.frame)
        analysis = (
            f"The diagram agrees with the photo in {comparison.agreement:.1%} of the pixels; "
            f"the outlines are {comparison.outline_distance:.4f} of the sheet's side apart."
        )
        anchor = NO_ANCHOR if case.anchor is None else "a geometric comparison cannot check an anchor"
        return Judgement(
            comparison.verdict, analysis, anchor, (*comparison.warnings, *comparison.discrepancies)
        )


class ModelCritic:
    """Judges by a vision-language model that sees the four pictures in order."""

    def __init__(self, role_client: RoleClient) -> None:
        self._role_client = role_client

    async def judge(self, case: CriticCase) -> Judgement:
        """The model's verdict; a reply that cannot be read is sent back once."""
        try:
            form = await read_answer(
                self._role_client,
                _case_messages(case),
                partial(read_form, CriticReply),
                _repair,
                json_mode=True,
            )
        except ReplyUnreadable as reason:
            unread = f"The critic gave no verdict that can be read, twice ({reason})."
            return Judgement(None, with_words(unread, reason.text))
        return Judgement(form.verdict, form.analysis, form.anchor_check, tuple(form.discrepancies))


def _repair(reason: str) -> str:
    return prompt("critic/repair", reason=reason)


def _case_messages(case: CriticCase) -> list[Message]:
    front, back = case.colors
    anchor = (
        prompt("critic/no_anchor")
        if case.anchor is None
        else prompt("critic/anchor", **case.anchor.model_dump())
    )
    question = prompt(
        "critic/user",
        classes=", ".join(case.action_classes),
        anchor=anchor,
        source=case.source.model_dump_json(),
        candidate=case.candidate.model_dump_json(),
    )
    return [
        system(prompt("critic/system", front=front, back=back)),
        user(question, lettered(case.pictures, diagrams="medium")),
    ]
