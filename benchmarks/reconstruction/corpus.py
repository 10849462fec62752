"""The programs to reconstruct: those beside this file, those of the paper and, where the reference data is, published
results.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from folding_schemas.actions import Action, Program
from folding_server.interchange.programs import load_program, load_published, load_recorded, resolved
from folding_server.simulator import apply, new_paper
from reference_data import FIGURES, REFERENCE

HERE = Path(__file__).resolve().parent
RENDERED = REFERENCE / "photos" / "rendered"
TUTORIALS = REFERENCE / "photos" / "tutorials"
TOLERANCE, RENDERED_TOLERANCE = 0.02, 0.03
"""How far off (sheet units) a vertex may be, and how far in the ray-traced sequences."""


@dataclass(frozen=True)
class Subject:
    """A folder with photos, the program that they show, and how exact a reconstruction has to be."""

    name: str
    folder: Path
    truth: Program
    tolerance: float


def programs() -> dict[str, Program]:
    """All programs by name: our own, then the figures', then the recorded ones."""
    return {
        **{path.stem: load_program(_text(path)) for path in _files(HERE / "programs")},
        **{path.stem: load_published(_text(path)).program for path in _files(FIGURES)},
        **{path.stem: recorded(_text(path)) for path in _files(REFERENCE / "programs" / "recorded")},
    }


def recorded(text: str) -> Program:
    """A recorded list of actions as a program: each motion is a step, with the vertices added before it."""
    recording = load_recorded(text)
    actions = _resolved(text)
    return Program(name=recording.name, steps=keyframe_steps(actions))


def keyframe_steps(actions: Iterable[Action]) -> tuple[tuple[Action, ...], ...]:
    """Actions grouped so that each step ends with what a photo can show, which added vertices are not."""
    steps: list[tuple[Action, ...]] = []
    waiting: list[Action] = []
    for action in actions:
        waiting.append(action)
        if action.action != "add_vertex":
            steps.append(tuple(waiting))
            waiting = []
    if waiting and steps:
        steps[-1] = (*steps[-1], *waiting)
    return tuple(steps)


def rendered(place: Path | None = None) -> dict[str, Subject]:
    """The ray-traced sequences in a folder, RENDERED unless another is named, by name."""
    folders = sorted(path.parent for path in (place or RENDERED).glob("*/truth.json"))
    return {
        folder.name: Subject(folder.name, folder, rendered_program(folder), RENDERED_TOLERANCE)
        for folder in folders
    }


def rendered_program(folder: Path) -> Program:
    """The program that a folder's ``truth.json`` tells, one step for each frame after the first."""
    truth = json.loads(_text(folder / "truth.json"))
    steps = [frame["step"] for frame in truth["frames"][1:]]
    actions = _resolved(json.dumps({"actions": [action for step in steps for action in step]}))
    rest = iter(actions)
    return Program(name=truth["name"], steps=tuple(tuple(next(rest) for _ in step) for step in steps))


def _resolved(text: str) -> list[Action]:
    """The recorded actions with the vertex ids that this simulator gives."""
    paper, actions = new_paper(), []
    for recording in load_recorded(text).actions:
        action = resolved(paper, recording)
        paper = apply(paper, action)
        actions.append(action)
    return actions


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.json"))


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
