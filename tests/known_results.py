"""The files of ``data/results``: programs of ours with the final state that the plain folder comes to.

``PYTHONPATH=tests .venv/bin/python tests/known_results.py`` writes them anew.
"""

import json
from collections import defaultdict
from itertools import combinations
from pathlib import Path
from typing import Any

from folding_schemas.actions import Program
from folding_server.interchange.programs import load_program
from folding_server.simulator import apply, new_paper
from paths import DATA, ROOT
from plain_folder import Face, Sheet, overlap

FROZEN = ("cup", "fan", "heart", "house", "paper_plane", "samurai_hat", "shirt", "swan")
PROGRAMS = ROOT / "benchmarks" / "reconstruction" / "programs"
BEYOND = {"bookmark", "cushion", "flower_card"}
"""Programs that open an older fold, for which the plain folder has no rule."""
Place = list[float]


def program(name: str) -> Program:
    """A program of the reconstruction benchmark."""
    return load_program((PROGRAMS / f"{name}.json").read_text(encoding="utf-8"))


def placed_actions(given: Program) -> list[dict[str, Any]]:
    """The actions of a program with ``at``, where the vertices that they name lie on the flat sheet.

    The simulator is asked for no more than what its vertex ids stand for.
    """
    paper, actions = new_paper(), []
    for action in (action for step in given.steps for action in step):
        document = action.model_dump(mode="json", exclude_none=True)
        if "edge" in document:
            document["at"] = [_rounded(complex(*paper.vertices_coords[v])) for v in document["edge"]]
        actions.append(document)
        paper = apply(paper, action)
    return actions


def folded_plainly(actions: list[dict[str, Any]]) -> Sheet:
    """What the plain folder makes of actions with ``at``."""
    sheet = Sheet()
    for document in actions:
        action = {key: value for key, value in document.items() if key != "at"}
        if "at" in document:
            action["edge"] = [
                min(sheet.points, key=lambda v: abs(sheet.points[v] - complex(*at))) for at in document["at"]
            ]
        sheet.act(action)
    return sheet


def final_state(sheet: Sheet) -> dict[str, Any]:
    """A folded sheet in the form of a recorded result: stated on the flat sheet and free of ids."""
    faces = sheet.faces
    outlines = {face: sheet.outline(face) for face in faces}
    over = [
        [_middle(sheet, upper), _middle(sheet, lower)]
        for lower, upper in combinations(faces, 2)
        if overlap(outlines[lower], outlines[upper])
    ]
    return {
        "vertices": [
            {"sheet": _rounded(at), "folded": _rounded(sheet.place(v))} for v, at in sheet.points.items()
        ],
        "edges": _edges(sheet),
        "front_up": [_middle(sheet, face) for face in faces if not face.motion.over],
        "over": over,
    }


def _edges(sheet: Sheet) -> list[dict[str, Any]]:
    beside: dict[frozenset[int], list[Face]] = defaultdict(list)
    for face in sheet.faces:
        for side in face.sides():
            beside[side].append(face)
    return [
        {"sheet": sorted(_rounded(sheet.points[v]) for v in side), "kind": _kind(faces)}
        for side, faces in beside.items()
    ]


def _kind(faces: list[Face]) -> str:
    if len(faces) == 1:
        return "boundary"
    return "flat" if faces[0].motion.over == faces[1].motion.over else "folded"


def _middle(sheet: Sheet, face: Face) -> Place:
    return _rounded(sum(map(sheet.points.__getitem__, face.points)) / len(face.points))


def _rounded(z: complex) -> Place:
    return [round(z.real, 6) + 0.0, round(z.imag, 6) + 0.0]


def _text(name: str) -> str:
    actions = placed_actions(program(name))
    final = final_state(folded_plainly(actions))
    lists = {key: ",\n   ".join(map(json.dumps, values)) for key, values in final.items()}
    states = ",\n".join(f'  "{key}": [\n   {values}\n  ]' for key, values in lists.items())
    listed = ",\n  ".join(map(json.dumps, actions))
    return f'{{\n "name": "{name}",\n "actions": [\n  {listed}\n ],\n "final": {{\n{states}\n }}\n}}\n'


def write(folder: Path) -> None:
    """Write the files anew."""
    for name in FROZEN:
        (folder / f"{name}.json").write_text(_text(name), encoding="utf-8")


if __name__ == "__main__":
    write(DATA / "results")
