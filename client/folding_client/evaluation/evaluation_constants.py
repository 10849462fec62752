"""Every weight and constant of the metrics in one record, which is written into the results.

*Fixed* ones are published (FoldingAgent, section "Metrics", after ORIGAMISPACE); all others are choices of this project, said
and reasoned in ``docs/evaluation.md``.
"""

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class TopologyWeights:
    """TSS: vertices, edges, faces, letters. Fixed."""

    vertices: float = 0.2
    edges: float = 0.3
    faces: float = 0.3
    letters: float = 0.2


@dataclass(frozen=True)
class GeometryWeights:
    """GS: positions, angles, proportions. Fixed."""

    positions: float = 0.4
    angles: float = 0.3
    proportions: float = 0.3


@dataclass(frozen=True)
class ConstraintWeights:
    """CS: taco-taco, taco-tortilla, transitivity, local flat-foldability. Fixed."""

    taco_taco: float = 0.3
    taco_tortilla: float = 0.3
    transitivity: float = 0.2
    locally_flat: float = 0.2


@dataclass(frozen=True)
class FoldedWeights:
    """FFS: distance of the folded vertices, order of the layers. Fixed."""

    distance: float = 0.7
    layers: float = 0.3


@dataclass(frozen=True)
class NotCompiled:
    """Scores of a state that does not compile. Fixed."""

    geometry: float = 0.2
    constraints: float = 0.2
    folded: float = 0.3


@dataclass(frozen=True)
class PatternCosts:
    """CPD: what an unmatched crease or vertex costs, what one of another letter adds, and the factor that brings the
    figures to the order that the paper prints. ``right_angle`` in degrees is the angle between creases that costs 1.
    """

    unmatched: float = 3.0
    other_letter: float = 1.0
    right_angle: float = 90.0
    factor: float = 10.0


@dataclass(frozen=True)
class EvaluationConstants:
    """All of them.

    ``count_decay``    of exp(-d |a - b| / max(1, min(a, b))), the similarity of two counts; fixed for vertices
    ``distance_decay`` of exp(-d h), h a Hausdorff distance; fixed
    ``turn_step``      degrees between the rotations that are tried before the best are refined
    ``refined``        how many of them are
    ``layer_pairs``    pairs of sheet points whose order is compared, drawn with ``layer_seed``
    ``same_turn``      CPDs of two quarter turns that differ by less leave the turn to the layers
    ``equal_within``   sheet units: states whose vertices are nearer are equal, as published results are rounded to 1e-3
    ``resamples``      of the bootstrap, drawn with ``bootstrap_seed``; ``confidence`` of its interval
    ``progress_points`` of the curves, evenly up to the last frame
    """

    topology: TopologyWeights = field(default_factory=TopologyWeights)
    geometry: GeometryWeights = field(default_factory=GeometryWeights)
    constraints: ConstraintWeights = field(default_factory=ConstraintWeights)
    folded: FoldedWeights = field(default_factory=FoldedWeights)
    not_compiled: NotCompiled = field(default_factory=NotCompiled)
    pattern: PatternCosts = field(default_factory=PatternCosts)
    count_decay: float = 0.5
    distance_decay: float = 5.0
    turn_step: float = 1.0
    refined: int = 3
    layer_pairs: int = 1000
    layer_seed: int = 0
    same_turn: float = 1e-6
    equal_within: float = 1e-3
    resamples: int = 2000
    bootstrap_seed: int = 0
    confidence: float = 0.95
    progress_points: int = 10

    def described(self) -> dict[str, Any]:
        """As the results hold them."""
        return asdict(self)


CONSTANTS = EvaluationConstants()
