"""Driving the server through a recorded run without a model, to see whether it answers as it did then."""

import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from folding_client.interrupts import ConnectionLost, ServerGone, UsageError
from folding_client.messages import ToolResult
from folding_client.protocol.connection import Connection, ServerAddress
from folding_client.protocol.requests import Request
from folding_client.record.event_log import Event, gaps, read_events
from folding_client.record.folder import RunFolder, picture_name

SAME_NUMBER = 1e-6
"""Numbers that differ by less are the same."""


@dataclass(frozen=True)
class Difference:
    """Where a result is not what was recorded: the event, the tool, and what differs."""

    seq: int
    tool: str
    what: str


@dataclass(frozen=True)
class Replay:
    """How a replay went."""

    calls: int
    differences: tuple[Difference, ...]


@dataclass(frozen=True)
class Exchange:
    """A recorded call and its result."""

    call: Event
    result: Event


def exchanges(events: Iterable[Event]) -> Iterator[Exchange]:
    """The answered calls of a recorded run in order; a call that was sent again counts once."""
    call: Event | None = None
    for event in events:
        match event["kind"]:
            case "call":
                call = event
            case "result" if call is not None:
                yield Exchange(call, event)
                call = None


async def replay_run(path: Path, sequence: Path | None = None) -> Replay:
    """Send a run's calls to a fresh server, in order, and compare the answers. UsageError if there is no such
    run or sequence, ServerGone if the server does not hold out.
    """
    folder = RunFolder(path.expanduser().resolve())
    photos = sequence.expanduser().resolve() if sequence else Path(folder.description()["sequence"]["folder"])
    if not (photos / "keyframes.json").is_file():
        message = f"{photos} holds no keyframes.json; name the folder where the run's sequence is now with --sequence."
        raise UsageError(message)
    recorded = list(read_events(folder.events))
    with tempfile.TemporaryDirectory() as data, (Path(data) / "server.log").open("w") as log:
        connection = Connection(ServerAddress(photos, Path(data)), log)
        try:
            await connection.open()
            found = await _replayed(connection, list(exchanges(recorded)))
            return replace(found, differences=(*_missing(recorded), *found.differences))
        except ConnectionLost as loss:
            message = f"The folding server ended during the replay: {loss}."
            raise ServerGone(message) from loss
        finally:
            await connection.close()


async def _replayed(connection: Connection, found: list[Exchange]) -> Replay:
    runs: dict[str, str] = {}
    differences: list[Difference] = []
    for exchange in found:
        name, arguments = exchange.call["name"], dict(exchange.call["arguments"])
        if arguments.get("run_id") in runs:
            arguments["run_id"] = runs[arguments["run_id"]]
        asked = Request(exchange.call["by"], name, arguments, None, exchange.call.get("technical", False))
        result = await connection.call(asked.tool, asked.arguments, asked.meta)
        recorded = exchange.result["structured"] or {}
        if name == "open_run" and result.data and "run_id" in recorded:
            runs[recorded["run_id"]] = result.data["run_id"]
        if (what := difference(exchange.result, result)) is not None:
            differences.append(Difference(exchange.call["seq"], name, what))
    return Replay(len(found), tuple(differences))


def _missing(recorded: list[Event]) -> Iterator[Difference]:
    """A difference for each gap in the numbers of the events."""
    for first, last in gaps(recorded):
        lines = f"event {first} is" if first == last else f"events {first} to {last} are"
        yield Difference(first, "events.jsonl", f"{lines} missing between {first - 1} and {last + 1}")


def difference(recorded: Event, result: ToolResult) -> str | None:
    """The first thing in which a result differs from the recorded one, None if it is the same."""
    if recorded["is_error"] != result.is_error:
        now = "refused" if result.is_error else "carried out"
        return (
            f"was {'refused' if recorded['is_error'] else 'carried out'}, is now {now}: {result.text[:200]}"
        )
    if result.is_error:
        return (
            None
            if recorded["text"] == result.text
            else f"was refused with {recorded['text']!r}, now {result.text!r}"
        )
    if where := _first_difference(recorded["structured"], result.data):
        return where
    pictures = [picture_name(picture) for picture in result.pictures]
    kept = [image["file"] for image in recorded["images"]]
    return None if pictures == kept else f"pictures: were {kept}, are {pictures}"


def _first_difference(before: Any, now: Any, where: str = "answer") -> str | None:  # noqa: ANN401
    """Where two JSON values part, leaving out run ids and differences of numbers below the tolerance."""
    if isinstance(before, dict) and isinstance(now, dict):
        keys = sorted(before.keys() | now.keys() - {"run_id"})
        return next(
            (
                found
                for key in keys
                if key != "run_id"
                and (found := _first_difference(before.get(key), now.get(key), f"{where}.{key}"))
            ),
            None,
        )
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return next(
            (
                found
                for index, pair in enumerate(zip(before, now, strict=True))
                if (found := _first_difference(*pair, f"{where}[{index}]"))
            ),
            None,
        )
    if isinstance(before, float) and isinstance(now, float | int) and abs(before - now) <= SAME_NUMBER:
        return None
    return None if before == now else f"{where}: was {before!r}, is {now!r}"
