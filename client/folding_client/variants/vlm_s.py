"""VLM-S and VLM-S-C: one action plan per step, without tools (paper, section "Ablations").

VLM-S carries the plan out and saves what comes of it. VLM-S-C asks the critic first, gives its words back to
the model, and lets the selector choose after three plans without a match.
"""

import json
from dataclasses import asdict, dataclass
from typing import cast

from folding_prompts import prompt
from folding_schemas.results import (
    ActionClass,
    CheckpointRestored,
    CheckpointSaved,
    CriticGrid,
    FrameView,
    RenderView,
    RunInfo,
    StateView,
)

from folding_client.interrupts import ReplyUnreadable, StepHopeless, ToolRefused
from folding_client.messages import Message, Picture, answered, lettered, system, user
from folding_client.progress import Progress
from folding_client.protocol.acting import carry_out
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.roles.critic import Critic, CriticCase, Judgement
from folding_client.roles.reply_parsing import read_form
from folding_client.roles.role_client import RoleClient
from folding_client.roles.selector import Selector, settle
from folding_client.variants.plans import ActionPlan

PLANS = 3
"""Plans for one frame before the selector chooses (VLM-S-C)."""
READINGS = 2
"""How often one plan is asked for: once, and once more if it cannot be read or carried out."""


@dataclass
class PlanPerStep:
    """Works frame by frame. Without a critic and selector it is VLM-S, with them VLM-S-C."""

    role_client: RoleClient
    server: ServerClient
    recorder: Recorder
    progress: Progress
    critic: Critic | None = None
    selector: Selector | None = None
    examples: tuple[Message, ...] = ()
    simulates: bool = True

    async def run(self) -> RunInfo:
        """Plan and save until every frame is saved. StepHopeless if a plan cannot be carried out."""
        while not (info := await self.server.where()).complete:
            frame = info.next_frame or info.frames
            self.recorder.outcome("running", "", len(info.saved), info.frames)
            self.recorder.event("step_started", frame=frame, saved=info.saved)
            self.progress.step(frame, info.frames, len(info.saved))
            await self._step(info, frame)
        return info

    async def _step(self, info: RunInfo, frame: int) -> None:
        if info.pending:
            await self.server.return_to(frame - 1)
        if frame > 1:
            messages = await self._opening(info, frame)
            if self.critic is not None and not await self._criticised(info, frame, messages, self.critic):
                await self._select(frame)
                return
            if self.critic is None:
                await self._planned(frame, messages)
        saved, _ = await self.server.ask(CheckpointSaved, "save_checkpoint", frame=frame)
        self.recorder.event("step_over", frame=frame, complete=saved.complete, by=self.role_client.model.name)

    async def _opening(self, info: RunInfo, frame: int) -> list[Message]:
        photos = await self._photos(frame)
        state, _ = await self.server.ask(StateView, "get_current_state")
        about = system(prompt("variants/plan_system", front=info.front_color, back=info.back_color))
        step = prompt(
            "variants/plan_step",
            before=frame - 1,
            frame=frame,
            frames=info.frames,
            state=state.state.model_dump_json(),
        )
        return [about, *self.examples, user(step, photos)]

    async def _photos(self, frame: int) -> tuple[Picture, ...]:
        _, before = await self.server.ask(FrameView, "view_frame", frame=frame - 1)
        _, after = await self.server.ask(FrameView, "view_frame", frame=frame)
        return lettered((*before, *after))

    async def _planned(self, frame: int, messages: list[Message]) -> ActionPlan:
        """A plan that has been carried out; the conversation grows by how it came about. StepHopeless without
        one.
        """
        why = ""
        for _ in range(READINGS):
            reply = await self.role_client.query(messages, json_mode=True)
            messages.append(answered(reply))
            try:
                plan = read_form(ActionPlan, reply.text)
                await carry_out(self.server, plan.actions)
            except (ReplyUnreadable, ToolRefused) as reason:
                why = str(reason)
                self.recorder.event("plan_refused", frame=frame, reason=why)
                messages.append(user(prompt("variants/plan_repair", reason=why)))
                await self._restore(frame - 1)
                continue
            return plan
        message = (
            f"The model gave no plan for frame {frame} that can be carried out ({why}); resume to ask again."
        )
        raise StepHopeless(message)

    async def _criticised(self, info: RunInfo, frame: int, messages: list[Message], critic: Critic) -> bool:
        """Whether a plan within the limit is a match, and the current state its result."""
        while (used := await self._used(frame)) is not None:
            plan = await self._planned(frame, messages)
            judgement = await self._judged(info, frame, plan, critic)
            if judgement.verdict == "MATCH":
                return True
            _, diagram = await self.server.ask(RenderView, "render_current")
            verdict = json.dumps({**asdict(judgement), "verdict": judgement.verdict or "NO VERDICT"})
            messages.append(user(prompt("variants/plan_again", frame=frame, verdict=verdict), diagram))
            self.recorder.event("plan_failed", frame=frame, plan=used + 1)
            await self._restore(frame - 1)
        return False

    async def _used(self, frame: int) -> int | None:
        """How many attempts at the frame were made; None if that is all there may be."""
        now = await self.server.where()
        used = now.attempts_used.get(frame, 0)
        return used if used < PLANS and now.attempts_left != 0 else None

    async def _judged(self, info: RunInfo, frame: int, plan: ActionPlan, critic: Critic) -> Judgement:
        grid, pictures = await self.server.ask(CriticGrid, "critic_grid", frame=frame)
        classes = cast("tuple[ActionClass, ...]", plan.classes())
        judgement = await critic.judge(
            CriticCase(
                frame,
                classes,
                plan.fold_anchor,
                grid.source_state,
                grid.candidate_state,
                pictures,
                (info.front_color, info.back_color),
            )
        )
        self.recorder.event("verdict", frame=frame, **asdict(judgement))
        return judgement

    async def _select(self, frame: int) -> None:
        assert self.selector is not None, "VLM-S-C has a selector"
        await settle(self.server, self.selector, self.recorder, frame)

    async def _restore(self, frame: int) -> None:
        await self.server.ask(CheckpointRestored, "restore_checkpoint", frame=frame)
