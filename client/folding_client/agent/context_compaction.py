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


@dataclass(frozen=True)
class ContextPolicy:
    """What is sent in full: pictures that were shown before or are of no use any more, results although something
    newer follows or says the same, the tools' descriptions although the system prompt says as much. All three is what
    the paper's agent does.
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


def without_repeated_pictures(messages: Sequence[Message]) -> list[Message]:
    """The messages without the pictures that one before has shown, and without films once the paper has moved."""
    moved = max((index for index, message in enumerate(messages) if _moves(message)), default=-1)
    shown: set[object] = set()
    kept = []
    for index, message in enumerate(messages):
        films = [picture for picture in message.pictures if picture.role == "filmstrip" and moved > index]
        repeated = [
            picture for picture in message.pictures if picture not in films and _content(picture) in shown
        ]
        shown |= {_content(picture) for picture in message.pictures if picture not in films}
        kept.append(_without(message, films, repeated))
    return kept


def _tells_state(message: Message) -> bool:
    told = message.tool in _CURRENT and message.result is not None and bool(message.result.told_data)
    return told or bool(message.state)


def _stateless(message: Message) -> Message:
    if message.result is None:
        return replace(
            message, said=message.said.replace(message.state, "(left out: a newer one follows)"), state=""
        )
    notes = ("(State left out: a newer one follows.)", *message.result.notes)
    return replace(message, result=replace(message.result, told=(), notes=notes))


def _moves(message: Message) -> bool:
    return message.tool in ACTIONS and not message.is_error


def _without(message: Message, films: Sequence[Picture], repeated: Sequence[Picture]) -> Message:
    """The message without films that have had their time and without what was shown before."""
    if films:
        note = "(Film left out, since the paper has moved; call again to see it.)"
        message = message.showing(_others(message, films), note)
    if repeated:
        subjects = ", ".join(picture.subject for picture in repeated)
        message = message.showing(_others(message, repeated), f"(Shown above already: {subjects}.)")
    return message


def _others(message: Message, left_out: Sequence[Picture]) -> tuple[Picture, ...]:
    """The pictures of a message but for some."""
    return tuple(picture for picture in message.pictures if picture not in left_out)


def _content(picture: Picture) -> object:
    """What tells a picture from others: of a photo, its frame, since several tools show it; else the picture itself."""
    return ("photo", picture.frame) if picture.role == "photo" else picture.data
