"""What a query leaves out of the conversation so far: answers in full, old states, old pictures.

Every part that is left out is replaced by a line that says so. Only what a model is told and shown is touched; the
data of a result stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from folding_client.messages import Message, Picture, ToolResult
from folding_client.protocol.acting import ACTIONS

_STATE = ("state",)
_UNSAID: dict[str, tuple[str, ...]] = {
    **dict.fromkeys([*ACTIONS, "undo", "get_current_state"], _STATE),
    "restore_checkpoint": ("next_attempt", "state"),
    **dict.fromkeys(
        ["view_frame", "observe_movement", "render_current", "save_checkpoint", "propose_actions"], ()
    ),
}
"""The parts of an answer's data that its summary does not say, by tool; all but the run's id for the others."""
_CURRENT = frozenset({*ACTIONS, "undo", "get_current_state", "restore_checkpoint"})
"""The tools that answer with the current state."""
PictureContent = tuple[str, int | None]
"""What a picture shows: its subject, and the frame of it."""


@dataclass(frozen=True)
class ContextPolicy:
    """What is sent in full: pictures and results although something newer follows or says the same, the tools'
    descriptions although the system prompt says as much. All three is what the paper's agent does.
    """

    images: bool = False
    results: bool = False
    descriptions: bool = False


def compacted(tool: str, result: ToolResult) -> ToolResult:
    """An answer of which only that data is told that its summary does not say."""
    if result.is_error or result.data is None or result.told is not None or not result.summary:
        return result
    return replace(result, told=_UNSAID.get(tool, tuple(name for name in result.data if name != "run_id")))


def without_old_states(messages: Sequence[Message]) -> list[Message]:
    """The messages with the current state told only by the last that tells it."""
    telling = [index for index, message in enumerate(messages) if _tells_state(message)]
    old = set(telling[:-1])
    return [_stateless(message) if index in old else message for index, message in enumerate(messages)]


def without_old_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without the pictures of which a later message shows the same thing anew, and without films once
    the paper has moved.
    """
    last = {
        _content(picture): index for index, message in enumerate(messages) for picture in message.pictures
    }
    moved = max((index for index, message in enumerate(messages) if _moves(message)), default=-1)
    return [
        _without(message, {_content(p) for p in message.pictures if last[_content(p)] > index}, moved > index)
        for index, message in enumerate(messages)
    ]


def _tells_state(message: Message) -> bool:
    return message.tool in _CURRENT and message.result is not None and bool(message.result.told_data)


def _stateless(message: Message) -> Message:
    assert message.result is not None, "what tells the state is a tool's result"
    notes = ("(State left out: a newer one follows.)", *message.result.notes)
    return replace(message, result=replace(message.result, told=(), notes=notes))


def _moves(message: Message) -> bool:
    return message.tool in ACTIONS and not message.is_error


def _without(message: Message, replaced: set[PictureContent], moved: bool) -> Message:
    """The message without the pictures of what was ``replaced``; without its film if the paper moved."""
    if moved and any(picture.role == "filmstrip" for picture in message.pictures):
        return message.showing((), "(Film left out, since the paper has moved; call again to see it.)")
    if not replaced:
        return message
    pictures = tuple(picture for picture in message.pictures if _content(picture) not in replaced)
    subjects = ", ".join(sorted(subject for subject, _ in replaced))
    return message.showing(pictures, f"(Left out, since a newer one follows: {subjects}.)")


def _content(picture: Picture) -> PictureContent:
    return picture.subject, picture.frame
