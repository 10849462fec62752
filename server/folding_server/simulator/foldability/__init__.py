"""Flat-foldability of crease patterns: local conditions, closing up, and layer orders by constraint solving."""

from folding_server.simulator.foldability.local import VertexViolation
from folding_server.simulator.foldability.pattern import Assignment, CreasePattern, pattern_of
from folding_server.simulator.foldability.report import CAP, FoldabilityReport, check_paper, check_pattern

__all__ = [
    "CAP",
    "Assignment",
    "CreasePattern",
    "FoldabilityReport",
    "VertexViolation",
    "check_paper",
    "check_pattern",
    "pattern_of",
]
