"""How a step begins: system prompt, text summary of the steps so far, the step's prompt (paper, "Context
management").
"""

from collections.abc import Mapping, Sequence

from folding_prompts import prompt
from folding_schemas.actions import action_text
from folding_schemas.results import CheckpointState, RunInfo

from folding_client.agent.tool_selection import tool_list
from folding_client.messages import Message, ToolSpec, system, user


def opening(
    info: RunInfo,
    tools: Sequence[ToolSpec],
    history: Mapping[int, CheckpointState],
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
        history=summary(info, history),
    )
    return [about, *examples, user(text)]


def summary(info: RunInfo, history: Mapping[int, CheckpointState]) -> str:
    """One line for each saved frame: its actions, notes, attempts and restores; then what else is known."""
    lines = [_frame_line(frame, info, history.get(frame)) for frame in sorted(info.saved)]
    if left := info.attempts.get(info.next_frame or 0, 0):
        lines.append(f"Frame {info.next_frame} has had {left} of {info.budget} attempts.")
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
