"""VLM-CP: crease pattern in, crease pattern out, without simulator, tools or state (paper, section
"Ablations").
"""

import json
from dataclasses import dataclass
from functools import partial
from typing import Literal

from folding_prompts import prompt
from folding_schemas.results import FrameView, RunInfo
from pydantic import BaseModel, ConfigDict, Field, model_validator

from folding_client.interrupts import ReplyUnreadable, StepHopeless
from folding_client.messages import Message, system, user
from folding_client.progress import Progress
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.roles.reply_parsing import read_form
from folding_client.roles.reply_repair import read_answer
from folding_client.roles.role_client import RoleClient


class PatternReply(BaseModel):
    """The part of a FOLD file that the variant uses: coordinates of vertices on the sheet, edges, assignments."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    vertices_coords: list[tuple[float, float]] = Field(min_length=3)
    edges_vertices: list[tuple[int, int]] = Field(min_length=3)
    edges_assignment: list[Literal["B", "M", "V", "F", "U"]]

    @model_validator(mode="after")
    def _fits_together(self) -> "PatternReply":
        if len(self.edges_assignment) != len(self.edges_vertices):
            message = f"{len(self.edges_vertices)} edges have {len(self.edges_assignment)} assignments"
            raise ValueError(message)
        last = len(self.vertices_coords) - 1
        for edge in self.edges_vertices:
            if not all(0 <= vertex <= last for vertex in edge):
                message = f"edge {list(edge)} names a vertex that is not there; they are 0 to {last}"
                raise ValueError(message)
        return self

    def fold_file(self, frame: int) -> dict[str, object]:
        """The pattern as a FOLD file."""
        return {
            "file_spec": 1.2,
            "file_creator": "foldingagent",
            "frame_title": f"frame {frame}",
            "frame_classes": ["creasePattern"],
            **self.model_dump(mode="json"),
        }


SQUARE = PatternReply(
    vertices_coords=[(0, 1), (1, 1), (1, 0), (0, 0)],
    edges_vertices=[(0, 1), (1, 2), (2, 3), (3, 0)],
    edges_assignment=["B", "B", "B", "B"],
)


@dataclass
class PatternPerStep:
    """Predicts one crease pattern per frame, each from the one before; kept in ``patterns.json``."""

    role_client: RoleClient
    server: ServerClient
    recorder: Recorder
    progress: Progress
    examples: tuple[Message, ...] = ()
    simulates: bool = False

    async def run(self) -> RunInfo:
        """Predict every frame that has no pattern yet. StepHopeless if the model gives none that can
        be read.
        """
        info = await self.server.where()
        patterns = self._recorded(info) or [SQUARE]
        self._write(patterns, info)
        for frame in range(2, len(patterns) + 1):
            if frame not in self.recorder.decided:
                self._over(frame, info)
        while len(patterns) < info.frames:
            frame = len(patterns) + 1
            self.recorder.outcome("running", "", len(patterns), info.frames)
            self.recorder.event("step_started", frame=frame, saved=list(range(1, frame)))
            self.progress.step(frame, info.frames, len(patterns))
            patterns.append(await self._predicted(info, frame, patterns[-1]))
            self._write(patterns, info)
            self._over(frame, info)
        return info.model_copy(update={"saved": list(range(1, info.frames + 1)), "complete": True})

    def _over(self, frame: int, info: RunInfo) -> None:
        complete = frame == info.frames
        self.recorder.event("step_over", frame=frame, complete=complete, by=self.role_client.model.name)

    async def _predicted(self, info: RunInfo, frame: int, pattern: PatternReply) -> PatternReply:
        _, before = await self.server.ask(FrameView, "view_frame", frame=frame - 1)
        _, after = await self.server.ask(FrameView, "view_frame", frame=frame)
        about = system(prompt("variants/cp_system", front=info.front_color, back=info.back_color))
        step = prompt(
            "variants/cp_step",
            before=frame - 1,
            frame=frame,
            frames=info.frames,
            pattern=json.dumps(pattern.model_dump(mode="json")),
        )
        messages = [about, *self.examples, user(step, (*before, *after))]
        try:
            read = partial(read_form, PatternReply)
            return await read_answer(self.role_client, messages, read, _repair, json_mode=True)
        except ReplyUnreadable as reason:
            message = (
                f"The model gave no readable crease pattern for frame {frame} ({reason}); resume to ask "
                "again."
            )
            raise StepHopeless(message) from reason

    def _write(self, patterns: list[PatternReply], info: RunInfo) -> None:
        files = [pattern.fold_file(frame) for frame, pattern in enumerate(patterns, start=1)]
        self.recorder.folder.write_json("patterns.json", {"sequence": info.sequence, "patterns": files})
        self.recorder.folder.write_json("crease_pattern.fold", files[-1])

    def _recorded(self, info: RunInfo) -> list[PatternReply]:
        file = self.recorder.folder.path / "patterns.json"
        if not file.exists():
            return []
        found = [
            PatternReply.model_validate(each) for each in json.loads(file.read_text("utf-8"))["patterns"]
        ]
        return found[: info.frames]


def _repair(reason: str) -> str:
    return prompt("variants/cp_repair", reason=reason)
