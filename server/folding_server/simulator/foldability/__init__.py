"""Flat-foldability of crease patterns: local conditions, closing up, and layer orders by constraint solving."""

from folding_server.simulator.foldability.fault import Fault, FilePlace, said
from folding_server.simulator.foldability.local import VertexViolation
from folding_server.simulator.foldability.pattern import (
    Y_DOWN,
    Assignment,
    CreasePattern,
    FileAxes,
    JoinedEnd,
    pattern_of,
)
from folding_server.simulator.foldability.report import (
    CAP,
    Counting,
    FoldabilityReport,
    check_paper,
    check_pattern,
)

__all__ = [
    "CAP",
    "Y_DOWN",
    "Assignment",
    "Counting",
    "CreasePattern",
    "Fault",
    "FileAxes",
    "FilePlace",
    "FoldabilityReport",
    "JoinedEnd",
    "VertexViolation",
    "check_paper",
    "check_pattern",
    "pattern_of",
    "said",
]
