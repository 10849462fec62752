"""What was said to the agent of a run and by it, as one conversation over all steps."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from folding_client.exports.exported_run import ExportedRun, ModelTurn, ToolTurn


@dataclass(frozen=True)
class ChatEntry:
    """A message: its role as in chats, text, pictures by file; calls of an assistant, call and tool of a result."""

    role: str
    text: str
    images: Sequence[Mapping[str, str]] = ()
    calls: Sequence[Mapping[str, str]] = ()
    thinking: str = ""
    call_id: str | None = None
    tool: str | None = None

    @classmethod
    def of_message(cls, entry: Mapping[str, Any]) -> "ChatEntry":
        """A message of a request on record."""
        return cls(
            entry["role"],
            entry["text"],
            entry.get("images", ()),
            entry.get("calls", ()),
            "",
            entry.get("call_id"),
            entry.get("tool"),
        )


def agent_conversation(run: ExportedRun) -> Iterator[ChatEntry]:
    """The messages in order. Every step begins with its own opening; a result that no query carried, such as that of the
    save which ends a step, is told by what the tool answered.
    """
    untold: dict[str, ToolTurn] = {}
    for turn in run.turns:
        if isinstance(turn, ToolTurn):
            if turn.call["by"] == "agent" and turn.call["id"] is not None:
                untold[turn.call["id"]] = turn
        elif turn.role == "agent":
            yield from _asked(turn, untold)
            yield from _replied(turn)
    yield from _results(untold)


def _asked(turn: ModelTurn, untold: dict[str, ToolTurn]) -> Iterator[ChatEntry]:
    new = [ChatEntry.of_message(entry) for entry in turn.request["new"]]
    for said in new:
        untold.pop(said.call_id or "", None)
    yield from _results(untold)
    untold.clear()
    yield from (said for said in new if said.role != "assistant")


def _replied(turn: ModelTurn) -> Iterator[ChatEntry]:
    reply = turn.reply
    if reply is not None and reply["kind"] == "reply":
        yield ChatEntry("assistant", reply["text"], calls=reply["calls"], thinking=reply["thinking"])


def _results(untold: Mapping[str, ToolTurn]) -> Iterator[ChatEntry]:
    for call_id, turn in untold.items():
        images = turn.result["images"] if turn.result else ()
        yield ChatEntry("tool", turn.text, images, call_id=call_id, tool=turn.call["name"])
