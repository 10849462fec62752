"""Sequences in the form of data sets: states of our programs as FOLD files, rounded, re-lettered and renumbered."""

import random
from typing import Any

from folding_schemas.actions import Flip, Program
from folding_server.interchange.fold_format import fold_document
from folding_server.simulate import run_steps
from folding_server.simulator import Paper, overlapping_pairs

DECIMALS = 3
SWAPPED = {"M": "V", "V": "M"}


def data_set_document(paper: Paper, *, flipped: bool, seed: int, posed: bool = True) -> dict[str, Any]:
    """A state as such data sets have it: crease pattern first, three decimals, the upper face first in ``faceOrders`` as
    the model is seen, mountains and valleys swapped while it is ``flipped``.
    """
    chance = random.Random(seed)
    document = fold_document(paper)
    order = list(range(len(document["vertices_coords"])))
    chance.shuffle(order)
    number = {old: new for new, old in enumerate(order)}
    folded, flat = document["vertices_coords"], document["file_frames"][0]["vertices_coords"]
    faces = {face: index for index, face in enumerate(paper.faces)}
    letters = document["edges_assignment"]
    mesh = {
        "edges_vertices": [[number[u], number[v]] for u, v in document["edges_vertices"]],
        "edges_assignment": [SWAPPED.get(letter, letter) if flipped else letter for letter in letters],
        "faces_vertices": [[number[v] for v in face] for face in document["faces_vertices"]],
        "faceOrders": [[faces[upper], faces[lower], 1] for lower, upper in overlapping_pairs(paper)],
    }
    lying = {
        "frame_classes": ["foldedForm"],
        "vertices_coords": [_rounded(folded[old]) for old in order],
        **mesh,
    }
    return {
        "file_spec": 1.1,
        "file_creator": "another program",
        "frame_classes": ["creasePattern"],
        "vertices_coords": [_rounded(flat[old]) for old in order],
        **mesh,
        "file_frames": [lying] if posed else [],
    }


def _rounded(point: list[float]) -> list[float]:
    return [round(c, DECIMALS) for c in point]


def data_set_states(program: Program, *, posed: bool = True) -> list[dict[str, Any]]:
    """The states of a program, the flat sheet first."""
    flips = 0
    found = []
    for result in run_steps(program):
        flips += sum(isinstance(action, Flip) for action in result.actions)
        found.append(data_set_document(result.paper, flipped=flips % 2 == 1, seed=result.step, posed=posed))
    return found
