"""Scoring a reconstruction against the program that was photographed."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from statistics import mean, median

from corpus import Subject
from exactness import exactness
from folding_schemas.actions import Action, Program, Rotate, action_text
from folding_server.photographer.replaying import keyframe_papers
from folding_server.simulator import Paper
from reconstructing import Reconstruction
from sheet import QUARTERS, line_error
from sheet import folded_between as creased
from silhouette import silhouette_iou

Steps = Sequence[tuple[Action, ...]]
Step = tuple[Action, ...]


@dataclass(frozen=True)
class Transition:
    """One transition to ``frame``: what was done and found, in words.

    ``exact`` is about the whole paper after it, ``line_error`` (sheet units) about the creases folded in it;
    None where nothing was folded, or was not found to be.
    """

    frame: int
    true: tuple[str, ...]
    found: tuple[str, ...] | None
    class_right: bool
    folds: bool
    line_error: float | None
    exact: bool
    seconds: float | None


@dataclass(frozen=True)
class Score:
    """How one sequence was reconstructed; ``lost_at`` is the first frame whose paper is not exact."""

    sequence: str
    frames: int
    completed: bool
    reason: str
    final_exact: bool
    lost_at: int | None
    class_right: float
    fold_line_error: float | None
    silhouette_iou: float
    opening_seconds: float
    seconds_median: float | None
    seconds_max: float | None
    memory_mb: float
    transitions: tuple[Transition, ...]


@dataclass(frozen=True)
class Overall:
    """All sequences together: shares of sequences, share of transitions, medians and worst cases."""

    sequences: int
    transitions: int
    completed: float
    final_exact: float
    class_right: float
    fold_line_error: float | None
    silhouette_iou: float
    seconds_median: float | None
    seconds_max: float | None
    memory_mb: float


def score(subject: Subject, made: Reconstruction) -> Score:
    """Score one reconstruction; what it lacks counts as wrong."""
    true = keyframe_papers(subject.truth)
    found = keyframe_papers(Program(name=subject.name, steps=made.steps))[: len(true)]
    transitions = _transitions(subject, made, true, found)
    whole = made.completed and len(found) == len(true)
    wrong = [t.frame for t in transitions if not t.exact]
    return Score(
        sequence=subject.name,
        frames=len(true),
        completed=whole,
        reason=made.reason,
        final_exact=whole and transitions[-1].exact,
        lost_at=wrong[0] if wrong else None,
        class_right=mean(t.class_right for t in transitions),
        fold_line_error=_median_error(transitions),
        silhouette_iou=silhouette_iou(true[-1], found[-1]) if whole else 0.0,
        opening_seconds=made.opening_seconds,
        seconds_median=median(made.seconds) if made.seconds else None,
        seconds_max=max(made.seconds, default=None),
        memory_mb=made.memory_mb,
        transitions=tuple(transitions),
    )


def overall(scores: Sequence[Score]) -> Overall:
    """All sequences together."""
    transitions = [t for s in scores for t in s.transitions]
    seconds = [t.seconds for t in transitions if t.seconds is not None]
    return Overall(
        sequences=len(scores),
        transitions=len(transitions),
        completed=mean(s.completed for s in scores),
        final_exact=mean(s.final_exact for s in scores),
        class_right=mean(t.class_right for t in transitions),
        fold_line_error=_median_error(transitions),
        silhouette_iou=mean(s.silhouette_iou for s in scores),
        seconds_median=median(seconds) if seconds else None,
        seconds_max=max(seconds, default=None),
        memory_mb=max(s.memory_mb for s in scores),
    )


def action_class(step: Step) -> tuple[str, ...]:
    """What a step does, in any order: folds, unfolds, and whether the model was turned or turned over.

    A flip with a turn is a flip about another axis, two flips are a turn, and a turn by 360 degrees is none.
    """
    counts = Counter(action.action for action in step)
    turned = sum(action.angle for action in step if isinstance(action, Rotate)) % 360
    moved = ["flip"] if counts["flip"] % 2 else ["rotate"] if turned or counts["flip"] else []
    return (*["fold"] * counts["fold"], *["unfold"] * counts["unfold"], *moved)


def _transitions(
    subject: Subject, made: Reconstruction, true: Sequence[Paper], found: Sequence[Paper]
) -> list[Transition]:
    errors = _line_errors(true, found)
    return [
        Transition(
            frame=index + 2,
            true=_words(step),
            found=_words(made.steps[index]) if index + 1 < len(found) else None,
            class_right=index + 1 < len(found) and action_class(step) == action_class(made.steps[index]),
            folds=bool(creased(true[index], true[index + 1])),
            line_error=errors[index],
            exact=index + 1 < len(found)
            and exactness(true[index + 1], found[index + 1], subject.tolerance).holds(subject.tolerance),
            seconds=made.seconds[index] if index < len(made.seconds) else None,
        )
        for index, step in enumerate(subject.truth.steps)
    ]


def _line_errors(true: Sequence[Paper], found: Sequence[Paper]) -> list[float | None]:
    """The fold line error of each transition under the one turn of the sheet that suits the sequence best."""
    wanted = [creased(*pair) for pair in pairwise(true)]
    got = [creased(*pair) for pair in pairwise(found)]
    got += [[] for _ in wanted[len(got) :]]
    by_turn = [[line_error(w, g, q) for w, g in zip(wanted, got, strict=True)] for q in QUARTERS]
    return min(by_turn, key=lambda errors: sum(e for e in errors if e is not None))


def _median_error(transitions: Sequence[Transition]) -> float | None:
    """The median over all transitions that fold; where no fold was found the error is beyond any other."""
    errors = [inf if t.line_error is None else t.line_error for t in transitions if t.folds]
    middle = median(errors) if errors else inf
    return middle if isfinite(middle) else None


def _words(step: Step) -> tuple[str, ...]:
    return tuple(action_text(action) for action in step)
