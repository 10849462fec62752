"""The tools on offer to the agent: the server's own, and ``ask_critic``, which the client answers (paper,
"Tool Library").
"""

import json
from dataclasses import asdict
from typing import Any

from folding_prompts import prompt
from folding_schemas.results import ActionClass, CriticGrid
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_client.agent.calls import checked_arguments
from folding_client.critic import Critic, CriticCase, FoldAnchor, Judgement
from folding_client.interrupts import CallRefused, ToolRefused
from folding_client.messages import JsonObject, ToolCall, ToolResult, ToolSpec
from folding_client.overview import OverviewCritic
from folding_client.record.recorder import Recorder
from folding_client.server import FoldingServer

FAILURES_BEFORE_OVERVIEW = 3
NOT_OFFERED = frozenset({"list_sequences", "open_run", "commit_attempt"})
"""Tools that would leave the run or take a decision that is the controller's."""
PAPER_TOOLS = frozenset(
    {
        "add_vertex",
        "fold",
        "unfold",
        "rotate",
        "flip",
        "view_frame",
        "observe_movement",
        "get_current_state",
        "render_current",
        "save_checkpoint",
        "restore_checkpoint",
        "get_checkpoint_state",
        "generate_checkpoint_overview",
    }
)
"""The tools that the paper's agent has, beside ``ask_critic``."""


class AskCritic(BaseModel):
    """The arguments of ``ask_critic``."""

    model_config = ConfigDict(extra="forbid")

    frame: int = Field(ge=2, description="The frame that the current state should match.")
    action_classes: list[ActionClass] = Field(
        min_length=1, description="What happened between the frame before and this one, in order."
    )
    fold_anchor: FoldAnchor | None = Field(
        default=None,
        description="Needed if a fold is among the classes: a relation by which it can be checked.",
    )


class Toolbox:
    """Carries out an agent's tool calls: checks them, sends them, and adds what the critics say.

    ``frugal`` leaves the critic's four pictures out of its answer, ``paper_only`` the tools that the paper's
    agent does not have.
    """

    def __init__(
        self,
        server: FoldingServer,
        critic: Critic,
        overview: OverviewCritic,
        recorder: Recorder,
        colors: tuple[str, str],
        *,
        paper_only: bool = False,
        frugal: bool = True,
    ) -> None:
        self._server = server
        self._critic = critic
        self._overview = overview
        self._recorder = recorder
        self._colors = colors
        self._frugal = frugal
        self._failures: dict[int, int] = {}
        hidden = {spec.name for spec in server.specs()} - PAPER_TOOLS if paper_only else NOT_OFFERED
        specs = [spec for spec in server.specs() if spec.name not in hidden]
        specs.append(
            ToolSpec("ask_critic", prompt("agent/ask_critic"), AskCritic.model_json_schema(), read_only=True)
        )
        self.offered = {spec.name: spec for spec in specs}

    async def execute(self, call: ToolCall) -> ToolResult:
        """The result of one call; a call that cannot be sent, or is refused, is a result that says why."""
        try:
            arguments = checked_arguments(call, self.offered)
            if call.name == "ask_critic":
                return await self._ask_critic(arguments)
        except (CallRefused, ToolRefused) as refusal:
            self._recorder.event("refused", call=asdict(call), reason=str(refusal))
            return ToolResult(str(refusal), is_error=True)
        result = await self._server.call(call.name, arguments, by="agent", call=call)
        return result if result.is_error else await self._with_advice(call.name, result)

    async def _with_advice(self, name: str, result: ToolResult) -> ToolResult:
        data = result.structured or {}
        if name == "save_checkpoint":
            self._failures.pop(data["frame"], None)
        if name == "generate_checkpoint_overview":
            return await self._with_analysis(result)
        if name == "restore_checkpoint" and data["next_attempt"] > FAILURES_BEFORE_OVERVIEW:
            return _with_text(result, prompt("agent/use_overview", frame=data["frame"] + 1))
        return result

    async def _with_analysis(self, result: ToolResult) -> ToolResult:
        analysis = asdict(await self._overview.analyse(result))
        self._recorder.event("overview", **analysis)
        return _with_text(result, json.dumps({"overview_analysis": analysis}))

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
        if judgement.verdict != "MATCH":
            self._failures[asked.frame] = self._failures.get(asked.frame, 0) + 1
        attempts = (await self._server.where()).attempts.get(asked.frame, 0)
        text = json.dumps(_verdict(judgement, attempts))
        if judgement.verdict != "MATCH" and self._failures[asked.frame] >= FAILURES_BEFORE_OVERVIEW:
            text += "\n" + prompt("agent/use_overview", frame=asked.frame)
        shown = () if self._frugal else pictures
        return ToolResult(text, _verdict(judgement, attempts), shown)


def _asked(arguments: JsonObject) -> AskCritic:
    try:
        asked = AskCritic.model_validate(arguments)
    except ValidationError as error:
        raise CallRefused(error.errors()[0]["msg"]) from error
    if "fold" in asked.action_classes and asked.fold_anchor is None:
        message = (
            "ask_critic needs a fold_anchor when a fold is among the action classes: say what moves, what "
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


def _with_text(result: ToolResult, text: str) -> ToolResult:
    return ToolResult(f"{result.text}\n{text}", result.structured, result.pictures, result.is_error)
