"""What a query leaves out of the conversation so far: answers in full, old states, old pictures.

Every part that is left out is replaced by a line that says so. Only what a model is told and shown is touched; the
data of a result stays.
"""

from collections.abc import Collection, Sequence
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
_MOVES = ACTIONS | {"undo", "restore_checkpoint"}
"""The tools after which the paper is another."""
_CURRENT = _MOVES | {"get_current_state"}
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
    """The messages without the pictures that one before has shown, and without films once the paper has moved.

    Once the paper as it is now has been drawn, what shows it as it was is small: earlier diagrams, and the photo of the frame
    before. A critic's match is told without the pictures that it was given. Diagrams, and that photo, are never larger than
    medium, where models have such a resolution.
    """
    acted = max((index for index, message in enumerate(messages) if _is_done(message, ACTIONS)), default=-1)
    moved = max((index for index, message in enumerate(messages) if _is_done(message, _MOVES)), default=-1)
    drawn = any(_is_done(message, {"render_current"}) for message in messages[moved + 1 :])
    before = _photo_before(messages)
    shown: set[object] = set()
    kept = []
    for index, message in enumerate(messages):
        past = index < moved and drawn
        films = [picture for picture in message.pictures if picture.role == "filmstrip" and acted > index]
        judged = list(message.pictures) if drawn and _is_match(message) else []
        others = [picture for picture in message.pictures if picture not in films and picture not in judged]
        repeated = [picture for picture in others if _content(picture) in shown]
        if index > moved:  # what is asked for again after a move is shown in full again
            repeated = [picture for picture in repeated if not (drawn and _content(picture) == before)]
        shown |= {_content(picture) for picture in others}
        left = _without(message, films, repeated, judged)
        kept.append(_smaller(left, before, past=past))
    return kept


def _photo_before(messages: Sequence[Message]) -> object:
    """The photo of the frame before, with which a step opens; None where it does not."""
    openings = [
        [_content(picture) for picture in message.pictures if picture.role == "photo"]
        for message in messages
        if message.role == "user"
    ]
    return next((photos[0] for photos in reversed(openings) if len(photos) > 1), None)


def _smaller(message: Message, before: object, *, past: bool) -> Message:
    """The message with the pictures of the paper as it was in less than full resolution."""
    changed = tuple(_in_resolution(picture, before, past=past) for picture in message.pictures)
    if changed == message.pictures:
        return message
    small = [picture.subject for picture in changed if picture.resolution == "small"]
    note = f"(Small now, since the paper has moved: {', '.join(small)}.)" if small else ""
    return message.showing(changed, note) if note else message.showing_instead(changed)


def _in_resolution(picture: Picture, before: object, *, past: bool) -> Picture:
    if picture.role != "diagram" and _content(picture) != before:
        return picture
    return replace(picture, resolution="small" if past else "medium")


def _is_match(message: Message) -> bool:
    data = message.result.data if message.tool == "ask_critic" and message.result else None
    return data is not None and data.get("critic_verdict") == "MATCH"


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


def _is_done(message: Message, tools: Collection[str]) -> bool:
    return message.tool in tools and not message.is_error


def _without(
    message: Message, films: Sequence[Picture], repeated: Sequence[Picture], judged: Sequence[Picture]
) -> Message:
    """The message without films that have had their time, what was shown before, and what a critic found to match."""
    if films:
        note = "(Film left out, since the paper has moved; call again to see it.)"
        message = message.showing(_others(message, films), note)
    if repeated:
        subjects = ", ".join(picture.subject for picture in repeated)
        message = message.showing(_others(message, repeated), f"(Shown above already: {subjects}.)")
    if judged:
        message = message.showing(_others(message, judged), "(The critic saw both photos and both diagrams.)")
    return message


def _others(message: Message, left_out: Sequence[Picture]) -> tuple[Picture, ...]:
    """The pictures of a message but for some."""
    return tuple(picture for picture in message.pictures if picture not in left_out)


def _content(picture: Picture) -> object:
    """What tells a picture from others: of a photo, its frame, since several tools show it; else the picture itself."""
    return ("photo", picture.frame) if picture.role == "photo" else picture.data
