"""The tools on offer to the agent: the server's own, and ``ask_critic``, which the client answers (paper,
"Tool Library").
"""

import json
from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Any

from folding_prompts import prompt
from folding_schemas.results import ActionClass, CriticGrid
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_client.agent import context_compaction, tool_selection
from folding_client.agent.calls import checked_arguments
from folding_client.agent.context_compaction import ContextPolicy
from folding_client.interrupts import CallRefused, ToolRefused
from folding_client.messages import JsonObject, ToolCall, ToolResult, ToolSpec
from folding_client.protocol.acting import ACTIONS
from folding_client.protocol.server_client import ServerClient
from folding_client.record.event_log import Event, read_events
from folding_client.record.recorder import Recorder
from folding_client.roles.critic import Critic, CriticCase, FoldAnchor, Judgement
from folding_client.roles.overview import OverviewCritic
from folding_client.settings import ToolSet

FAILURES_BEFORE_OVERVIEW = 3
ANCHORED = frozenset({"fold", "compound"})
"""Kinds of action of which an anchor says what moved; a compound holds a fold, or it would be one of the others."""
MOVES = ACTIONS | {"undo", "restore_checkpoint"}
"""The tools after which the state is another than the critic judged."""


class AskCritic(BaseModel):
    """The arguments of ``ask_critic``."""

    model_config = ConfigDict(extra="forbid")

    frame: int = Field(ge=2, description="the frame to match, from 2")
    action_classes: list[ActionClass] = Field(
        min_length=1, description="what happened since the frame before, at least one"
    )
    fold_anchor: FoldAnchor | None = Field(
        default=None, description="for a fold or compound: a relation to check it by"
    )


class Toolbox:
    """Carries out an agent's tool calls: checks them, sends them, and adds what the critics say.

    ``offered`` holds the tools that may be called: those of the set ``tools``, those ``also`` named, and
    ``ask_critic``. Unless the ``policy`` keeps them, answers are compacted. Tools that are ``unseen`` are asked for no pictures.
    """

    def __init__(
        self,
        server: ServerClient,
        critic: Critic,
        overview: OverviewCritic,
        recorder: Recorder,
        colors: tuple[str, str],
        *,
        tools: ToolSet,
        policy: ContextPolicy,
        also: frozenset[str] = frozenset(),
        unseen: frozenset[str] = frozenset(),
    ) -> None:
        self._server = server
        self._critic = critic
        self._overview = overview
        self._recorder = recorder
        self._colors = colors
        self._policy = policy
        self._unseen = unseen
        self._failures: dict[int, int] = {}
        self._last: tuple[int, str] | None = None
        self.saved_against = saved_against(read_events(recorder.folder.events))
        own = ToolSpec(
            "ask_critic", prompt("agent/ask_critic"), AskCritic.model_json_schema(), read_only=True
        )
        specs = [*tool_selection.on_offer(server.specs(), tools, also), own]
        self.offered = {
            spec.name: spec if policy.descriptions else tool_selection.summarised(spec) for spec in specs
        }

    async def execute(self, call: ToolCall) -> ToolResult:
        """The result of one call; a call that cannot be sent, or is refused, is a result that says why."""
        try:
            arguments = checked_arguments(call, self.offered)
            if call.name == "ask_critic":
                return await self._ask_critic(arguments)
        except (CallRefused, ToolRefused) as refusal:
            self._recorder.event("refused", call=asdict(call), reason=str(refusal))
            return ToolResult(str(refusal), is_error=True)
        if call.name in self._unseen:
            arguments |= {"images": "none"}
        result = await self._server.call(call.name, arguments, by="agent", call=call)
        if call.name in MOVES and not result.is_error:
            self._last = None
        result = result if self._policy.results else context_compaction.compacted(call.name, result)
        return result if result.is_error else await self._with_advice(call.name, result)

    async def _with_advice(self, name: str, result: ToolResult) -> ToolResult:
        data = result.data or {}
        if name == "save_checkpoint":
            return self._saved(result, data["frame"])
        if name == "generate_checkpoint_overview":
            return await self._with_analysis(result)
        if name == "restore_checkpoint" and data["attempts_used"] >= FAILURES_BEFORE_OVERVIEW:
            return _with_note(result, prompt("agent/use_overview", frame=data["frame"] + 1))
        return result

    def _saved(self, result: ToolResult, frame: int) -> ToolResult:
        """The answer to a save, which says so if the critic had found no match in what was saved."""
        self._failures.pop(frame, None)
        self.saved_against.pop(frame, None)
        if self._last is None or self._last[0] != frame or self._last[1] == "MATCH":
            return result
        self.saved_against[frame] = self._last[1]
        self._recorder.event("saved_against", frame=frame, verdict=self._last[1])
        return _with_note(result, f"Saved although the critic's last word on this state was {self._last[1]}.")

    async def _with_analysis(self, result: ToolResult) -> ToolResult:
        analysis = asdict(await self._overview.analyse(result))
        self._recorder.event("overview", **analysis)
        return _with_note(result, json.dumps({"overview_analysis": analysis}))

    async def _ask_critic(self, arguments: JsonObject) -> ToolResult:
        asked = _asked(arguments)
        grid, pictures = await self._server.ask(CriticGrid, "critic_grid", frame=asked.frame)
        case = CriticCase(
            asked.frame,
            tuple(asked.action_classes),
            asked.fold_anchor,
            grid.source_state,
            grid.candidate_state,
            pictures,
            self._colors,
        )
        judgement = await self._critic.judge(case)
        self._recorder.event("verdict", frame=asked.frame, **asdict(judgement))
        self._last = asked.frame, judgement.verdict or "NO VERDICT"
        if judgement.verdict != "MATCH":
            self._failures[asked.frame] = self._failures.get(asked.frame, 0) + 1
        attempts = (await self._server.where()).attempts_used.get(asked.frame, 0)
        verdict = _verdict(judgement, attempts)
        result = ToolResult(json.dumps(verdict), verdict, pictures, told=())
        if judgement.verdict != "MATCH" and self._failures[asked.frame] >= FAILURES_BEFORE_OVERVIEW:
            return _with_note(result, prompt("agent/use_overview", frame=asked.frame))
        return result


def saved_against(events: Iterable[Event]) -> dict[int, str]:
    """The frames that a run has saved although the critic's last word on them was not a match, with that word."""
    found: dict[int, str] = {}
    for event in events:
        if event["kind"] == "result" and event["name"] == "save_checkpoint" and not event["is_error"]:
            found.pop((event["structured"] or {}).get("frame", 0), None)
        elif event["kind"] == "selected":
            found.pop(event["frame"], None)
        elif event["kind"] == "saved_against":
            found[event["frame"]] = event["verdict"]
    return found


def _asked(arguments: JsonObject) -> AskCritic:
    try:
        asked = AskCritic.model_validate(arguments)
    except ValidationError as error:
        raise CallRefused(error.errors()[0]["msg"]) from error
    anchored = [each for each in asked.action_classes if each in ANCHORED]
    if anchored and asked.fold_anchor is None:
        message = (
            f"ask_critic needs a fold_anchor when {anchored[0]} is among the action classes: say what moves, what "
            "stays, and how the two lie to each other in the photo."
        )
        raise CallRefused(message)
    return asked


def _verdict(judgement: Judgement, attempts: int) -> dict[str, Any]:
    return {
        "critic_verdict": judgement.verdict or "NO VERDICT",
        "critic_analysis": judgement.analysis,
        "critic_anchor_check": judgement.anchor_check,
        "critic_discrepancies": list(judgement.discrepancies),
        "transition_attempt": attempts,
    }


def _with_note(result: ToolResult, note: str) -> ToolResult:
    return replace(result, notes=(*result.notes, note))
