"""What a query leaves out of the conversation so far: answers in full, old states, old pictures.

Every part that is left out is replaced by a line that says so. Only a message's text and pictures as they go out are
touched; its data stays.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace

from folding_client.messages import JsonObject, Message, Picture, ToolResult
from folding_client.protocol.recovery import ACTIONS

_STATE = ("state",)
_BRIEF: dict[str, tuple[str, ...]] = {
    **dict.fromkeys([*ACTIONS, "undo", "get_current_state"], _STATE),
    "restore_checkpoint": ("next_attempt", "state"),
    **dict.fromkeys(
        ["view_frame", "observe_movement", "render_current", "save_checkpoint", "propose_actions"], ()
    ),
}
"""The parts of an answer's data that its short text does not say, by tool; all but the run's id for the others."""
_CURRENT = frozenset({*ACTIONS, "undo", "get_current_state", "restore_checkpoint"})
"""The tools that answer with the current state."""
_FILM = "observe_movement"


@dataclass(frozen=True)
class ContextPolicy:
    """What is sent in full: pictures and results although something newer follows or says the same, the tools'
    descriptions although the system prompt says as much. All three is what the paper's agent does.
    """

    images: bool = False
    results: bool = False
    descriptions: bool = False


def in_brief(tool: str, result: ToolResult) -> ToolResult:
    """An answer whose data is cut to what its short text does not say."""
    if result.is_error or result.structured is None or not result.detail:
        return result
    names = _BRIEF.get(tool, tuple(name for name in result.structured if name != "run_id"))
    detail = _compact({name: result.structured[name] for name in names}) if names else ""
    text = result.text.replace(result.detail, detail).rstrip("\n")
    return replace(result, text=text, detail=detail)


def without_old_states(messages: Sequence[Message]) -> list[Message]:
    """The messages with the current state told only by the last that tells it."""
    telling = [index for index, message in enumerate(messages) if _tells_state(message)]
    old = set(telling[:-1])
    return [_stateless(message) if index in old else message for index, message in enumerate(messages)]


def without_old_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without the pictures of which a later message shows the same subject anew, and without
    films once the paper has moved.
    """
    last = {picture.subject: index for index, message in enumerate(messages) for picture in message.pictures}
    moved = max((index for index, message in enumerate(messages) if _moves(message)), default=-1)
    return [
        _without(message, {p.subject for p in message.pictures if last[p.subject] > index}, moved > index)
        for index, message in enumerate(messages)
    ]


def _compact(data: JsonObject) -> str:
    return json.dumps(data, separators=(",", ":"), ensure_ascii=False)


def _tells_state(message: Message) -> bool:
    return message.tool in _CURRENT and bool(message.detail)


def _stateless(message: Message) -> Message:
    text = message.text.replace(message.detail, "(State left out: a newer one follows.)")
    return replace(message, text=text, detail="")


def _moves(message: Message) -> bool:
    return message.tool in ACTIONS and not message.is_error


def _without(message: Message, replaced: set[str], moved: bool) -> Message:
    """The message without the pictures of subjects that were replaced; without its film if the paper moved."""
    if message.tool == _FILM and moved and message.pictures:
        return _noted(message, (), "Film left out, since the paper has moved; call again to see it.")
    if not replaced:
        return message
    kept = tuple(picture for picture in message.pictures if picture.subject not in replaced)
    return _noted(message, kept, f"Left out, since a newer one follows: {', '.join(sorted(replaced))}.")


def _noted(message: Message, pictures: tuple[Picture, ...], note: str) -> Message:
    return replace(message, text=f"{message.text}\n({note})".strip(), pictures=pictures)
