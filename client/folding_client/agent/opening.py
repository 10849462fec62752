"""How a step begins: system prompt, text summary of the steps so far, the step's prompt (paper, "Context
management").
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType

from folding_prompts import prompt
from folding_schemas.actions import action_text
from folding_schemas.results import CheckpointState, FrameView, RenderView, RunInfo, StateView
from folding_schemas.wire import Wire

from folding_client.agent.tool_selection import tool_list
from folding_client.interrupts import ToolRefused
from folding_client.messages import Message, Picture, ToolSpec, json_text, lettered, system, user
from folding_client.protocol.server_client import ServerClient


@dataclass(frozen=True)
class StepView:
    """What every step looks up: the current state, and pictures of it and of the photos before and after."""

    state: str = ""
    pictures: tuple[Picture, ...] = ()


async def look(server: ServerClient, frame: int) -> StepView:
    """What a step towards a frame begins with. A picture that the server refuses is left out."""
    state, _ = await server.ask(StateView, "get_current_state")
    asked: tuple[tuple[type[Wire], str, dict[str, object]], ...] = (
        (FrameView, "view_frame", {"frame": frame - 1}),
        (FrameView, "view_frame", {"frame": frame}),
        (RenderView, "render_current", {"labels": True}),
    )
    pictures: list[Picture] = []
    for kind, tool, arguments in asked:
        with suppress(ToolRefused):
            pictures += (await server.ask(kind, tool, **arguments))[1]
    return StepView(json_text(state.state.model_dump(mode="json")), lettered(pictures))


def opening(
    info: RunInfo,
    tools: Sequence[ToolSpec],
    summary: str,
    view: StepView,
    examples: Sequence[Message] = (),
) -> list[Message]:
    """The messages that a step towards ``info.next_frame`` starts with; ``tools`` are those on offer.
    Everything up to the examples is the same in every step, so that a provider's cache finds it again.
    """
    about = system(
        prompt(
            "agent/system",
            front=info.front_color,
            back=info.back_color,
            tools=tool_list(tools),
            budget=info.budget,
        )
    )
    if info.next_frame == 1:
        return [about, *examples, user(prompt("agent/first_step", frames=info.frames))]
    text = prompt(
        "agent/later_step",
        frames=info.frames,
        before=(info.next_frame or 0) - 1,
        frame=info.next_frame,
        remaining=info.frames - (info.next_frame or 0) + 1,
        history=summary,
        state=view.state,
    )
    return [about, *examples, replace(user(text, view.pictures), state=view.state)]


def step_summary(
    info: RunInfo, history: Mapping[int, CheckpointState], against: Mapping[int, str] = MappingProxyType({})
) -> str:
    """One line for each saved frame: its actions, notes, attempts, restores, and the critic's word ``against`` it if it
    was saved nevertheless; then what else is known.
    """
    lines = [
        _frame_line(frame, info, history.get(frame))
        + (f" Saved against the critic's {against[frame]}." if frame in against else "")
        for frame in sorted(info.saved)
    ]
    if used := info.attempts_used.get(info.next_frame or 0, 0):
        lines.append(f"Frame {info.next_frame} has had {used} of {info.budget} attempts.")
    if info.locked_to:
        lines.append(f"Frames up to {info.locked_to} are committed for good.")
    return "\n".join(lines)


def _frame_line(frame: int, info: RunInfo, state: CheckpointState | None) -> str:
    actions = state.actions if state else []
    done = "; ".join(action_text(action) for action in actions) or (
        "flat square" if frame == 1 else "no action"
    )
    extras = [f"{info.attempts[frame]} attempts"] if info.attempts.get(frame, 0) > 1 else []
    extras += [f"restores: {info.restores[frame]}"] if info.restores.get(frame) else []
    notes = f" Notes: {state.notes}" if state and state.notes else ""
    return f"Frame {frame}: {done}{f' ({chr(44).join(extras)})' if extras else ''}.{notes}"
