"""The sequence of queries that ``tokens.py`` counts: a scripted agent on the real server, over a photographed
heart.

A transition takes nine queries: look at both photos and at the movement, read the state, act, draw, read the
state, ask the critic, save. One transition is first folded wrong, refused and restored. That makes 140 queries
of the agent, and one of the critic for every time it is asked.
"""

import asyncio
import json
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from folding_client.assembly import RoleModels, make_worker
from folding_client.messages import Message, Reply, ToolCall, ToolSpec
from folding_client.progress import Silent
from folding_client.protocol.connection import ServerAddress
from folding_client.protocol.server_client import ServerClient
from folding_client.record.folder import RunFolder
from folding_client.record.recorder import Recorder
from folding_client.settings import Settings

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
BETWEEN = 5
"""Images of the film between two photos; photos stand in for them, since the examples have no film."""
WRONG_FRAME = 7
MODEL = "litellm/openai/gpt-4o"
"""What the agent is taken for, so that its steps open with what a model that sees is shown; it is scripted here."""
Calls = list[tuple[str, dict[str, Any]]]


@dataclass(frozen=True)
class Query:
    """What a role was asked, everything included: messages with all their pictures, and the tools on offer."""

    role: str
    messages: tuple[Message, ...]
    tools: tuple[ToolSpec, ...]
    reply: Reply

    @property
    def opens_a_step(self) -> bool:
        """Whether nothing has been said before in this conversation."""
        return not any(message.role == "assistant" for message in self.messages)


@dataclass
class Listener:
    """A model that says what it was told to, and keeps what it was asked in ``heard``."""

    name: str
    replies: Iterable[Reply]
    heard: list[Query] = field(default_factory=list)

    async def query(
        self, messages: Sequence[Message], tools: Sequence[ToolSpec], *, json_mode: bool = False
    ) -> Reply:
        """The next reply."""
        del json_mode
        reply = next(iter(self.replies))
        self.heard.append(Query(self.name, tuple(messages), tuple(tools), reply))
        return reply


def record(folder: Path, again: bool = True) -> list[Query]:
    """The queries of one reconstruction of the heart, in order, recorded under ``folder``.

    The agent asks ``again`` for the photos and the state that its steps open with, or does not.
    """
    sequence = _with_film(EXAMPLES / "heart", folder / "heart")
    steps = json.loads((EXAMPLES / "heart" / "program.json").read_text(encoding="utf-8"))["steps"]
    return asyncio.run(_recorded(sequence, folder / "run", steps, again))


async def _recorded(sequence: Path, out: Path, steps: list[list[dict[str, Any]]], again: bool) -> list[Query]:
    heard: list[Query] = []
    agent = Listener("agent", iter([_reply(*said) for said in enumerate(script(steps, again))]), heard)
    critic = Listener("critic", iter(_verdicts(len(steps))), heard)
    run = RunFolder(out)
    run.create()
    recorder = Recorder(run, {})
    with (out / "server.log").open("w", encoding="utf-8") as log:
        server = ServerClient(ServerAddress(sequence, run.store, None), recorder, log)
        await server.start()
        try:
            info = await server.open_run(sequence.name)
            settings = Settings(
                model=MODEL, tools="all", keep_images=True, keep_results=True, full_descriptions=True
            )
            role_models = RoleModels(agent, critic, None, None)
            colors = (info.front_color, info.back_color)
            info = await make_worker(role_models, settings, server, recorder, Silent(), colors).run()
        finally:
            await server.close()
            recorder.close()
    assert info.complete, "the scripted agent saves every frame"
    return heard


def script(steps: Sequence[Sequence[dict[str, Any]]], again: bool) -> Iterable[Calls]:
    """The calls of the agent, reply by reply."""
    yield [("save_checkpoint", {"frame": 1})]
    for frame, actions in enumerate(steps, start=2):
        if again:
            yield [("view_frame", {"frame": frame - 1})]
            yield [("view_frame", {"frame": frame})]
        yield [("observe_movement", {"frame": frame})]
        if again:
            yield [("get_current_state", {})]
        if frame == WRONG_FRAME:
            yield from _wrong_try(frame)
        yield [(each["action"], {k: v for k, v in each.items() if k != "action"}) for each in actions]
        yield [("render_current", {"labels": True})]
        yield [("get_current_state", {})]
        yield [_critic_call(frame, actions[-1]["action"])]
        yield [("save_checkpoint", {"frame": frame, "notes": "The critic agrees; the crease is measured."})]


def _wrong_try(frame: int) -> Iterable[Calls]:
    yield [("rotate", {"angle": 30.0})]
    yield [("render_current", {"labels": True})]
    yield [_critic_call(frame, "rotate")]
    yield [("restore_checkpoint", {"frame": frame - 1})]


def _critic_call(frame: int, kind: str) -> tuple[str, dict[str, Any]]:
    anchor = {
        "moving_element": "the corner that turned over",
        "static_reference": "the opposite edge of the sheet",
        "relationship": "the tip ends on the edge, a little left of its middle",
    }
    asked: dict[str, Any] = {"frame": frame, "action_classes": [kind]}
    return "ask_critic", asked | ({"fold_anchor": anchor} if kind == "fold" else {})


def _verdicts(transitions: int) -> Iterable[Reply]:
    for frame in range(2, transitions + 2):
        if frame == WRONG_FRAME:
            yield _verdict("MISMATCH", ["the sheet was folded, not turned"])
        yield _verdict("MATCH", [])


def _verdict(verdict: str, discrepancies: list[str]) -> Reply:
    analysis = (
        "Photos and diagrams show the same outline. What moved in the photos moves in the diagrams, it comes "
        "from the same side, and its tip ends at the same place; the colours on top agree."
    )
    said = {"verdict": verdict, "analysis": analysis, "anchor_check": "holds", "discrepancies": discrepancies}
    return Reply(json.dumps(said))


def _reply(number: int, calls: Calls) -> Reply:
    made = [
        ToolCall(f"c{number}_{index}", name, json.dumps(given)) for index, (name, given) in enumerate(calls)
    ]
    text = "I compare what the photos show with the state that I have, then take the next step towards the frame."
    return Reply(text, tuple(made), finish_reason="tool_calls")


def _with_film(source: Path, folder: Path) -> Path:
    """A copy of a sequence in which the photo before a keyframe stands for each image of the film to it."""
    manifest = json.loads((source / "keyframes.json").read_text(encoding="utf-8"))
    (folder / "frames").mkdir(parents=True)
    keyframes = []
    for position, index in enumerate(manifest["keyframes"]):
        photo = source / "frames" / f"{index:06d}.jpg"
        first = position * (BETWEEN + 1)
        keyframes.append(first)
        for image in range(first, first + BETWEEN + 1):
            shutil.copyfile(photo, folder / "frames" / f"{image:06d}.jpg")
    text = json.dumps(manifest | {"keyframes": keyframes})
    (folder / "keyframes.json").write_text(text, encoding="utf-8")
    return folder
