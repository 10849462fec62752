"""States to score: what programs come to, measured by the server's own functions, and states as evaluation compares them."""

import json
import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from folding_client.evaluation.compared_state import ComparedState, compared_state
from folding_client.evaluation.scoring_states import StateScorer, StateScores
from folding_schemas.actions import Action, AddVertex, Fold, Program
from folding_schemas.state_measures import StateMeasures
from folding_server.interchange.programs import load_program
from folding_server.measuring.state_measuring import measured_paper
from folding_server.simulate import run_steps
from folding_server.simulator.apply import replay
from paths import ROOT

EXAMPLES = ("cat", "cup", "heart")


def example_program(name: str) -> Program:
    return load_program((ROOT / "examples" / "programs" / f"{name}.json").read_text(encoding="utf-8"))


@cache
def example_states(name: str) -> tuple[StateMeasures, ...]:
    """The state after each step of an example."""
    return tuple(measured_paper(result.paper) for result in run_steps(example_program(name)) if result.step)


def after(*actions: Action) -> ComparedState:
    return compared_state(measured_paper(replay(actions)))


def pleat(off: float, *then: Action) -> ComparedState:
    """The sheet folded along an upright line at 0.25 and a shift, and the flap again along a level line; then what is given."""
    return after(
        AddVertex(edge=(1, 2), position=0.25 + off),
        AddVertex(edge=(4, 3), position=0.25 + off),
        Fold(edge=(5, 6), direction=-1),
        AddVertex(edge=(2, 3), position=0.3),
        AddVertex(edge=(5, 6), position=0.3),
        Fold(edge=(7, 8), direction=1),
        *then,
    )


def scored(state: ComparedState | None, truth: ComparedState) -> StateScores:
    return StateScorer(truth).scored(state)


def relabelled(measured: StateMeasures, seed: int) -> ComparedState:
    """The same state with its vertices, edges and faces numbered in another order."""
    chance = random.Random(seed)
    vertices = list(range(len(measured.vertices_coords)))
    faces = list(range(len(measured.faces_vertices)))
    edges = list(range(len(measured.edges_vertices)))
    for numbers in (vertices, faces, edges):
        chance.shuffle(numbers)
    new_vertex, new_face = np.argsort(vertices).tolist(), np.argsort(faces).tolist()
    assert measured.folded_coords is not None
    changed: dict[str, Any] = {
        "vertices_coords": [measured.vertices_coords[v] for v in vertices],
        "folded_coords": [measured.folded_coords[v] for v in vertices],
        "edges_vertices": [
            (new_vertex[measured.edges_vertices[e][1]], new_vertex[measured.edges_vertices[e][0]])
            for e in edges
        ],
        "edges_assignment": [measured.edges_assignment[e] for e in edges],
        "faces_vertices": [[new_vertex[v] for v in measured.faces_vertices[f]] for f in faces],
        "over": [(new_face[a], new_face[b]) for a, b in measured.over],
    }
    return compared_state(measured.model_copy(update=changed))


def write_run(
    folder: Path,
    sequence: str,
    steps: list[list[dict[str, Any]]],
    *,
    frames: int,
    status: str = "complete",
    reason: str = "",
    model: str = "geometric",
    variant: str = "agent",
) -> Path:
    """A run folder as the client leaves it, as far as evaluation reads it."""
    folder.mkdir(parents=True)
    totals = {
        "queries": 4,
        "input_tokens": 1000,
        "output_tokens": 50,
        "cached_tokens": 0,
        "thinking_tokens": 0,
        "cost": 0.25,
        "seconds": 2.0,
    }
    about = {
        "format": 1,
        "created": "2026-01-01T00:00:00+00:00",
        "sequence": {"name": sequence, "folder": f"/sequences/{sequence}", "frames": frames},
        "models": {"agent": model},
        "settings": {"given": {}, "defaulted": {"variant": variant, "few_shot": False}},
        "versions": {},
        "outcome": {
            "status": status,
            "reason": reason,
            "frames_saved": len(steps) + 1,
            "frames": frames,
            "seconds": 12.5,
            "updated": "2026-01-01T00:00:00+00:00",
        },
        "decided": {},
        "fits": {},
        "tally": {},
        "totals": {"agent": totals},
    }
    (folder / "run.json").write_text(json.dumps(about), encoding="utf-8")
    saved = [{"frame": frame, "actions": step} for frame, step in enumerate([[], *steps], start=1)]
    (folder / "checkpoints.json").write_text(json.dumps(saved), encoding="utf-8")
    return folder
