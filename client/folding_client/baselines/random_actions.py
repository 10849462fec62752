"""The model ``random``: at every frame one action, drawn until the server finds one legal. The floor of any table."""

from random import Random
from typing import get_args

from folding_schemas.actions import FlipAxis
from folding_schemas.results import RunInfo, StateView
from folding_schemas.state import FoldedState

from folding_client.baselines.stepwise import FrameWork, compare_call, save_call

RANDOM = "random"
"""The id of the model."""
DRAWS = 200
"""The most draws at a frame; after them it is saved as it is. One draw in four or so is legal."""
_KINDS = ("add_vertex", "fold", "unfold", "rotate", "flip")
_TURNS = (45, 90, 135, 180, 225, 270, 315)
"""Degrees: the turns that people make between two steps."""


def random_frame(seed: int, _run: RunInfo, frame: int) -> FrameWork:
    """One frame by chance. The draws depend on the seed and the frame alone, so a resumed run comes to the same."""
    chance = Random(f"{seed} {frame}")
    (answer,) = yield [("get_current_state", {})]
    state = StateView.model_validate(answer.data).state
    for _ in range(DRAWS):
        tool, arguments = _drawn(state, chance)
        (answer,) = yield [(tool, arguments)]
        if answer.is_error:
            continue
        state = FoldedState.model_validate((answer.data or {})["state"])
        if tool != "add_vertex":  # which alone changes nothing that a photo shows
            break
    yield [compare_call(frame)]
    yield [save_call(frame, f"drawn with seed {seed}")]


def _drawn(state: FoldedState, chance: Random) -> tuple[str, dict[str, object]]:
    """A tool and arguments that it may take or refuse."""
    tool = chance.choice(_KINDS)
    edges = [[one, other] for one, other, _ in state.edges]
    match tool:
        case "add_vertex":
            return tool, {"edge": chance.choice(edges), "position": round(chance.uniform(0.1, 0.9), 2)}
        case "fold":
            ends = chance.sample(sorted(map(int, state.vertices)), 2)
            return tool, {"edge": ends, "direction": chance.choice((1, -1))}
        case "unfold":
            folded = [[one, other] for one, other, kind in state.edges if kind in "MV"]
            return tool, {"edge": chance.choice(folded)} if folded else {}
        case "rotate":
            return tool, {"angle": chance.choice(_TURNS)}
        case _:
            return tool, {"axis": chance.choice(get_args(FlipAxis))}
