"""Folding programs as JSON files, read with plain errors and written back with their comments.

A program is ``{"name", "front_color"?, "back_color"?, "sheet"?, "comment"?, "steps": [[action, ...], ...]}``.
Comments are JSON too, so that every tool can read the file: a ``"comment"`` on the program,
and one on any action.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from folding_schemas.actions import Action, Program
from pydantic import ValidationError

from folding_server.errors import ProgramError
from folding_server.geometry.line import Point
from folding_server.interchange.fold_frames import parse_json_object
from folding_server.simulator import Paper

LONGEST_SIDE = 100.0


@dataclass(frozen=True)
class CommentedProgram:
    """A program and the comments on its actions, by (step, action) counted from 0."""

    program: Program
    comments: Mapping[tuple[int, int], str] = field(default_factory=dict)


@dataclass(frozen=True)
class PublishedProgram:
    """A program printed in a figure: where it is from and the vertex ids that each step creates."""

    program: Program
    new_vertices: tuple[tuple[int, ...], ...]
    source: str
    note: str


@dataclass(frozen=True)
class RecordedAction:
    """An action of a recorded result. ``at``: where its vertices lie on the sheet, since ids may differ."""

    action: Action
    at: tuple[Point, Point] | None


@dataclass(frozen=True)
class RecordedProgram:
    """A published result: its actions and the final state, stated on the sheet and free of ids."""

    name: str
    actions: tuple[RecordedAction, ...]
    final: Mapping[str, Any]


def load_program(text: str) -> Program:
    """The program in a JSON text. ProgramError names the step, the action and what is wrong with it."""
    return load_commented_program(text).program


def load_commented_program(text: str) -> CommentedProgram:
    """As ``load_program``, with the comments on single actions."""
    return _commented(dict(parse_json_object(text, "program")))


def program_text(program: Program, comments: Mapping[tuple[int, int], str] | None = None) -> str:
    """A program as JSON, one action a line. Reading it back gives the same program and comments."""
    head = program.model_dump(mode="json", exclude={"steps"}, exclude_none=True)
    if program.sheet == (1.0, 1.0):
        del head["sheet"]
    lines = [f"  {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}," for key, value in head.items()]
    steps = []
    for i, step in enumerate(program.steps):
        actions = [
            f"      {_action_text(action, (comments or {}).get((i, j)))}" for j, action in enumerate(step)
        ]
        steps.append("    [\n" + ",\n".join(actions) + "\n    ]" if actions else "    []")
    body = "[\n" + ",\n".join(steps) + "\n  ]" if steps else "[]"
    return "\n".join(["{", *lines, f'  "steps": {body}', "}", ""])


def load_published(text: str) -> PublishedProgram:
    """A program file with the extra keys ``source``, ``note`` and ``new_vertices``."""
    document = dict(parse_json_object(text, "program"))
    source, note = (str(document.pop(key, "")) for key in ("source", "note"))
    created = document.pop("new_vertices", [])
    try:
        new_vertices = tuple(tuple(int(v) for v in step) for step in created)
    except (TypeError, ValueError):
        raise ProgramError(
            "The program's new_vertices is not a list of lists of vertex ids; mend or remove it."
        ) from None
    return PublishedProgram(_commented(document).program, new_vertices, source, note)


def load_recorded(text: str) -> RecordedProgram:
    """A recorded result: a flat list ``actions``, each with ``at``, and the state ``final``."""
    document = parse_json_object(text, "recorded program")
    actions, final = document.get("actions"), document.get("final", {})
    if (
        not isinstance(actions, list)
        or not all(isinstance(a, Mapping) for a in actions)
        or not isinstance(final, Mapping)
    ):
        raise ProgramError("The recorded program has no list of actions with a final state; give both.")
    bare = [{key: value for key, value in action.items() if key != "at"} for action in actions]
    program = _commented({"name": str(document.get("name", "untitled")), "steps": [bare]}).program
    ends = [_ends(action.get("at"), i) for i, action in enumerate(actions)]
    recorded = tuple(RecordedAction(*pair) for pair in zip(program.steps[0], ends, strict=True))
    return RecordedProgram(program.name, recorded, final)


def resolved(paper: Paper, recorded: RecordedAction) -> Action:
    """The action with its edge named by the vertices of this paper nearest to ``at`` on the sheet."""
    if recorded.at is None:
        return recorded.action
    edge = tuple(_nearest(paper, point) for point in recorded.at)
    return recorded.action.model_copy(update={"edge": edge})


def _nearest(paper: Paper, point: Point) -> int:
    x, y = point
    return min(
        paper.vertices_coords,
        key=lambda v: (paper.vertices_coords[v][0] - x) ** 2 + (paper.vertices_coords[v][1] - y) ** 2,
    )


def _ends(at: Any, index: int) -> tuple[Point, Point] | None:
    if at is None:
        return None
    try:
        (a, b), (c, d) = at
        return (float(a), float(b)), (float(c), float(d))
    except (TypeError, ValueError):
        raise ProgramError(
            f"Action {index + 1} of the recorded program has an 'at' that is not two points."
        ) from None


def _commented(document: dict[str, Any]) -> CommentedProgram:
    steps = document.get("steps", [])
    comments: dict[tuple[int, int], str] = {}
    if isinstance(steps, Sequence) and not isinstance(steps, str):
        document["steps"] = [_without_comments(step, i, comments) for i, step in enumerate(steps)]
    try:
        program = Program.model_validate(document)
    except ValidationError as error:
        raise ProgramError(_first_error(error)) from None
    _check_numbers(program)
    return CommentedProgram(program, comments)


def _without_comments(step: Any, i: int, comments: dict[tuple[int, int], str]) -> Any:
    """The step with the comments of its actions moved to ``comments``."""
    if not isinstance(step, list):
        return step
    bare = []
    for j, action in enumerate(step):
        if isinstance(action, Mapping) and isinstance(action.get("comment"), str):
            comments[(i, j)] = action["comment"]
            bare.append({key: value for key, value in action.items() if key != "comment"})
        else:
            bare.append(action)
    return bare


def _first_error(error: ValidationError) -> str:
    """The first mistake in a program as one sentence: where it is and what is allowed."""
    first = error.errors()[0]
    loc = list(first["loc"])
    where = "The program"
    if loc[:1] == ["steps"]:
        numbers = [part + 1 for part in loc[1:3] if isinstance(part, int)]
        where = ("The list of steps", "Step {} of the program", "Action {1} of step {0} of the program")[
            len(numbers)
        ].format(*numbers)
        loc = loc[1 + len(numbers) :]
    place = ".".join(map(str, loc))
    if first["type"] == "extra_forbidden":
        known = f"a program has the keys {', '.join(Program.model_fields)}"
        cure = known if len(first["loc"]) == 1 else "remove it"
        return f"{where} has a key {str(loc[-1])!r} that is not known; {cure}."
    return f"{where} is wrong{f' at {place}' if place else ''}: {first['msg']}."


def _check_numbers(program: Program) -> None:
    if not all(0 < side <= LONGEST_SIDE for side in program.sheet):
        width, height = program.sheet
        raise ProgramError(
            f"The program's sheet is {width:g} by {height:g}; width and height must be above 0 and at "
            f"most {LONGEST_SIDE:g}."
        )
    for i, step in enumerate(program.steps):
        for j, action in enumerate(step):
            for name in ("position", "angle"):
                value = getattr(action, name, 0.0)
                if not isfinite(value):
                    raise ProgramError(
                        f"Action {j + 1} of step {i + 1} of the program has the {name} {value}; give a "
                        "number."
                    )


def _action_text(action: Action, comment: str | None) -> str:
    values = action.model_dump(mode="json", exclude_none=True)
    if comment is not None:
        values["comment"] = comment
    return json.dumps(values, ensure_ascii=False)
