"""The folding simulator: pure geometry, no I/O. Every action takes a paper and returns a new one."""

from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.apply import apply, replay
from folding_server.simulator.fold import fold
from folding_server.simulator.folded_state import folded_state
from folding_server.simulator.motions import flip, rotate
from folding_server.simulator.paper import Paper, new_paper
from folding_server.simulator.planes import overlapping_pairs
from folding_server.simulator.state_diff import moved_faces
from folding_server.simulator.unfold import unfold
from folding_server.simulator.vertices import add_vertex

__all__ = [
    "TOLERANCE",
    "Paper",
    "add_vertex",
    "apply",
    "flip",
    "fold",
    "folded_state",
    "moved_faces",
    "new_paper",
    "overlapping_pairs",
    "replay",
    "rotate",
    "unfold",
]
