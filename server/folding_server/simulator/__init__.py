"""The folding simulator: pure geometry, no I/O. Every function takes a paper and returns a new one."""

from folding_server.simulator.paper import Paper, new_paper
from folding_server.simulator.plane_geometry import TOLERANCE

__all__ = ["TOLERANCE", "Paper", "new_paper"]
