"""Solving for the actions behind a photo, by analysis and synthesis."""

from folding_server.vision.solver.confidence import confidence
from folding_server.vision.solver.plan import Plan
from folding_server.vision.solver.propose import clearly_best, propose
from folding_server.vision.solver.refinement import refined, revised

__all__ = ["Plan", "clearly_best", "confidence", "propose", "refined", "revised"]
