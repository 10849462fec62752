"""States with one mistake in them, and which metric of ``foldingagent evaluate`` tells them from the truth.

    PYTHONPATH=benchmarks .venv/bin/python benchmarks/corrupted_states.py [--states 600] [--seed 0] [--write]

Prints JSON: for each kind of mistake, how often ``state_equal`` and each metric told the state from the truth. With ``--write``
the shares become what ``foldingagent evaluate`` says of its metrics (``client/folding_client/evaluation/blindness.json``). The
states are those that the programs of the examples and of ``benchmarks/reconstruction/programs`` pass through, their steps from the
third on; each gets one mistake, drawn by the seed, and is measured by the server's own functions.
"""

import argparse
import json
import random
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from folding_client.evaluation.compared_state import ComparedState, compared_state
from folding_client.evaluation.evaluation_constants import CONSTANTS
from folding_client.evaluation.scoring_states import StateScorer, StateScores
from folding_client.evaluation.state_equality import state_equal
from folding_schemas.evaluation import METRICS, MetricName
from folding_schemas.state_measures import StateMeasures
from folding_server.interchange.programs import load_program
from folding_server.measuring.state_measuring import measured_model, measured_paper
from folding_server.measuring.stated_model import stated_model
from folding_server.simulate import run_steps

ROOT = Path(__file__).resolve().parent.parent
PROGRAMS = (
    *sorted((ROOT / "examples" / "programs").glob("*.json")),
    *sorted((ROOT / "benchmarks" / "reconstruction" / "programs").glob("*.json")),
)
BLINDNESS = ROOT / "client" / "folding_client" / "evaluation" / "blindness.json"
FIRST_STEP = 3
"""Before it there is too little paper for every kind of mistake."""
TOLD = 1e-6
"""A metric that differs by more from that of the truth against itself tells the state from the truth."""
LEAST_MOVE, MOST_MOVE = 0.02, 0.1
"""Sheet units that a vertex is moved by."""
INSIDE = 1e-6
"""Sheet units from the sheet's outline beyond which a vertex is inside."""
Draft = dict[str, Any]
"""A state as its measures hold it, to be spoilt."""


def crease_dropped(state: Draft, chance: random.Random) -> bool:
    """A crease is missing: its two faces are one."""
    edges, faces = state["edges_vertices"], state["faces_vertices"]
    inner = [index for index, letter in enumerate(state["edges_assignment"]) if letter != "B"]
    if not inner:
        return False
    crease = chance.choice(inner)
    u, v = edges[crease]
    beside = [index for index, cycle in enumerate(faces) if _has_side(cycle, u, v)]
    first, second = (_from_side(faces[index], u, v) for index in beside)
    kept, gone = beside
    faces[kept] = [*first, *second[1:-1]]
    del edges[crease], state["edges_assignment"][crease], faces[gone]
    renumbered = [(_without(a, kept, gone), _without(b, kept, gone)) for a, b in state["over"]]
    state["over"] = sorted({(a, b) for a, b in renumbered if a != b and (b, a) not in renumbered})
    return len(set(faces[kept])) == len(faces[kept])


def letter_swapped(state: Draft, chance: random.Random) -> bool:
    """A mountain is called valley, or a valley mountain."""
    letters = state["edges_assignment"]
    folded = [index for index, letter in enumerate(letters) if letter in "MV"]
    if folded:
        crease = chance.choice(folded)
        letters[crease] = "V" if letters[crease] == "M" else "M"
    return bool(folded)


def layers_exchanged(state: Draft, chance: random.Random) -> bool:
    """Two faces that overlap lie the other way over each other."""
    if not state["over"]:
        return False
    index = chance.randrange(len(state["over"]))
    upper, lower = state["over"][index]
    state["over"][index] = (lower, upper)
    return True


def side_mirrored(state: Draft, chance: random.Random) -> bool:
    """The other side of the paper was folded over: the model lies turned over about a crease."""
    folded = [
        edge
        for edge, letter in zip(state["edges_vertices"], state["edges_assignment"], strict=True)
        if letter in "MV"
    ]
    if not folded:
        return False
    coords = np.array(state["folded_coords"]) @ [1, 1j]
    a, b = (coords[v] for v in chance.choice(folded))
    mirrored = a + ((coords - a) / (b - a)).conj() * (b - a)
    state["folded_coords"] = [(float(z.real), float(z.imag)) for z in mirrored]
    state["over"] = [(lower, upper) for upper, lower in state["over"]]
    return True


def vertex_moved(state: Draft, chance: random.Random) -> bool:
    """A vertex is somewhere else, on the sheet and folded; one on the outline stays on it."""
    movable = [
        index
        for index, point in enumerate(state["vertices_coords"])
        if sum(min(c, 1 - c) < INSIDE for c in point) < 2
    ]
    if not movable:
        return False
    vertex = chance.choice(movable)
    x, y = state["vertices_coords"][vertex]
    step = chance.uniform(LEAST_MOVE, MOST_MOVE) * chance.choice((-1, 1))
    along_x = min(y, 1 - y) < INSIDE or (min(x, 1 - x) >= INSIDE and chance.random() < 0.5)
    moved = (x + step, y) if along_x else (x, y + step)
    if not all(0 < c < 1 for c in (moved[0] if along_x else moved[1],)):
        return False
    face = next(cycle for cycle in state["faces_vertices"] if vertex in cycle)
    state["folded_coords"][vertex] = _carried(state, face, moved)
    state["vertices_coords"][vertex] = moved
    return True


MISTAKES: Mapping[str, Callable[[Draft, random.Random], bool]] = {
    "crease dropped": crease_dropped,
    "letter swapped": letter_swapped,
    "layers exchanged": layers_exchanged,
    "side mirrored": side_mirrored,
    "vertex moved": vertex_moved,
}
"""Each spoils a state and says whether it could."""


def _has_side(cycle: Sequence[int], u: int, v: int) -> bool:
    return any({a, b} == {u, v} for a, b in zip(cycle, (*cycle[1:], cycle[0]), strict=True))


def _from_side(cycle: Sequence[int], u: int, v: int) -> list[int]:
    """The cycle, begun so that the side between u and v closes it."""
    for index, vertex in enumerate(cycle):
        if {cycle[index - 1], vertex} == {u, v}:
            return [*cycle[index:], *cycle[:index]]
    raise ValueError(cycle)


def _without(face: int, kept: int, gone: int) -> int:
    """The number of a face after one of two that became one is gone."""
    face = kept if face == gone else face
    return face - (face > gone)


def _carried(state: Draft, face: Sequence[int], point: tuple[float, float]) -> tuple[float, float]:
    """Where the motion of a face takes a point of the sheet."""
    flat = np.array([[*state["vertices_coords"][v], 1.0] for v in face])
    folded = np.array([state["folded_coords"][v] for v in face])
    matrix, *_ = np.linalg.lstsq(flat, folded, rcond=None)
    x, y = np.array([*point, 1.0]) @ matrix
    return float(x), float(y)


def fold_document(state: Draft) -> dict[str, Any]:
    """A state as a FOLD file that states it as it is, sound or not."""
    mesh = {key: state[key] for key in ("edges_vertices", "edges_assignment", "faces_vertices")}
    sheet, folded = np.array(state["vertices_coords"]), np.array(state["folded_coords"])
    turned = [
        _doubled_area(sheet[cycle]) * _doubled_area(folded[cycle]) < 0 for cycle in state["faces_vertices"]
    ]
    orders = [[upper, lower, -1 if turned[lower] else 1] for upper, lower in state["over"]]
    below = {"frame_classes": ["creasePattern"], "vertices_coords": sheet.tolist(), **mesh}
    key = {"frame_classes": ["foldedForm"], "vertices_coords": folded.tolist(), "faceOrders": orders, **mesh}
    return {"file_spec": 1.2, **key, "file_frames": [below]}


def _doubled_area(outline: np.ndarray[Any, Any]) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def true_states(files: Sequence[Path] = PROGRAMS) -> list[StateMeasures]:
    """The states that programs pass through from step FIRST_STEP on."""
    return [
        measured_paper(result.paper)
        for file in files
        for result in run_steps(load_program(file.read_text(encoding="utf-8")))
        if result.step >= FIRST_STEP
    ]


def corrupted(
    states: Sequence[StateMeasures], count: int, seed: int, mistakes: Sequence[str] = tuple(MISTAKES)
) -> Iterator[tuple[str, StateMeasures, ComparedState]]:
    """So many triples of a mistake, the truth, and the measured state with the mistake, kinds in turn."""
    chance = random.Random(seed)
    for number in range(count):
        mistake = mistakes[number % len(mistakes)]
        while True:
            truth = chance.choice(states)
            draft = json.loads(truth.model_dump_json())
            if MISTAKES[mistake](draft, chance):
                state = compared_state(measured_model(stated_model(fold_document(draft))))
                if not is_truth_turned(state, compared_state(truth)):
                    break
        yield mistake, truth, state


def is_truth_turned(state: ComparedState, truth: ComparedState) -> bool:
    """Whether a state is the truth turned in the plane: the flaps of a model that looks the same upside down, exchanged, are."""
    if state.folded is None or truth.folded is None:
        return False
    z = state.folded @ [1, 1j]
    center, wanted = _center(state), _center(truth)
    turned = [(z - center) * 1j**quarters + wanted for quarters in (1, 2, 3)]
    return any(
        state_equal(replace(state, folded=np.stack([w.real, w.imag], axis=1)), truth, CONSTANTS.equal_within)
        for w in turned
    )


def _center(state: ComparedState) -> complex:
    """The middle of the bounding box of a folded state."""
    assert state.folded is not None
    return complex(*((state.folded.min(axis=0) + state.folded.max(axis=0)) / 2))


def told_by(scored: StateScores, own: StateScores) -> set[MetricName]:
    """The metrics that tell a state from the truth, whose scores against itself are ``own``."""
    return {metric for metric in METRICS if abs(scored.scores[metric] - own.scores[metric]) > TOLD}


def measure(states: Sequence[StateMeasures], count: int, seed: int) -> dict[str, Any]:
    """How often each metric and ``state_equal`` told each mistake."""
    told: dict[str, Counter[str]] = {mistake: Counter() for mistake in MISTAKES}
    unseen = []
    for number, (mistake, truth, state) in enumerate(corrupted(states, count, seed)):
        true_state = compared_state(truth)
        scorer = StateScorer(true_state)
        scored = scorer.scored(state)
        metrics = told_by(scored, scorer.scored(true_state))
        told[mistake].update(["states", *metrics, *([] if scored.equal else ["state_equal"])])
        if scored.equal or not metrics:
            unseen.append(f"{number}: {mistake}")
    names = ("state_equal", *METRICS)
    shares = {
        mistake: {name: round(counts[name] / counts["states"], 3) for name in names}
        for mistake, counts in told.items()
    }
    return {"states": count, "seed": seed, "told": shares, "not told by anything": unseen}


def main() -> None:
    """Measure, print, and write if asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--states", type=int, default=600)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    found = measure(true_states(), given.states, given.seed)
    print(json.dumps(found, indent=1))
    if given.write:
        command = f"benchmarks/corrupted_states.py --states {given.states} --seed {given.seed} --write"
        kept = {"measured_by": command, "told": found["told"]}
        BLINDNESS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
