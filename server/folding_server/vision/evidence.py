"""What speaks for and against an explanation of a photo, as named terms: the value of each was measured, its weight fitted.

The weights, their units and where they come from are in ``evidence.toml`` beside this file.
"""

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from math import fsum
from pathlib import Path

WEIGHTS_FILE = Path(__file__).with_name("evidence.toml")


@dataclass(frozen=True)
class EvidenceTerm:
    """One term: its ``weight`` in shares of the paper per ``unit``, the ``source`` of that weight, and what it says in ``words``."""

    name: str
    weight: float
    unit: str
    source: str
    words: str


@dataclass(frozen=True)
class Evidence:
    """The value of each term for one explanation, in the units of ``evidence.toml``; 0 says nothing."""

    agreement: float = 0.0
    nothing_happened: float = 0.0
    folds: float = 0.0
    unfolds: float = 0.0
    rotations: float = 0.0
    flips: float = 0.0
    diagonal_flips: float = 0.0
    added_vertices: float = 0.0
    several_creasing_actions: float = 0.0
    inner_lines: float = 0.0
    scale_change_held: float = 0.0
    scale_change_standing: float = 0.0
    drift_turn: float = 0.0
    unseen_fold: float = 0.0
    unseen_turn: float = 0.0
    new_crease: float = 0.0
    free_line: float = 0.0
    sliver: float = 0.0
    narrow_strip: float = 0.0
    moved_otherwise: float = 0.0
    explained_change: float = 0.0
    folded_beside: float = 0.0
    look_ahead: float = 0.0
    own_camera: float = 0.0
    tilt: float = 0.0
    steep_tilt: float = 0.0
    zoom: float = 0.0
    nearness: float = 0.0
    roll: float = 0.0
    own_camera_rotation: float = 0.0
    own_camera_inner_lines: float = 0.0
    own_camera_new_crease: float = 0.0
    own_camera_free_line: float = 0.0
    own_camera_lines_shown: float = 0.0
    own_camera_residual: float = 0.0

    @property
    def values(self) -> dict[str, float]:
        """The terms that say something, by name."""
        return {name: value for name, value in vars(self).items() if value}

    @property
    def contributions(self) -> dict[str, float]:
        """What each of these adds to the score, in shares of the paper."""
        known = terms()
        return {name: known[name].weight * value for name, value in self.values.items()}

    @property
    def score(self) -> float:
        """The sum of all contributions, whatever their order."""
        return fsum(self.contributions.values())

    def of(self, *names: str) -> float:
        """The sum of some contributions."""
        return fsum(terms()[name].weight * float(getattr(self, name)) for name in names)


NOTHING_NOTED = Evidence()


@cache
def terms() -> dict[str, EvidenceTerm]:
    """All terms by name, in the order in which they are told."""
    table = tomllib.loads(WEIGHTS_FILE.read_text(encoding="utf-8"))
    return {field.name: EvidenceTerm(field.name, **table[field.name]) for field in fields(Evidence)}
