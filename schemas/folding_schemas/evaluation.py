"""What ``foldingagent evaluate --json`` prints: how recorded runs compare with the truth, and with which constants.

Versions of format 1 may add members, so readers leave alone what they do not know.
"""

from typing import Any, Literal

from folding_schemas.run_record import RecordPart

MetricName = Literal["CV", "TSS", "GS", "CS", "FFS", "CPD", "SIM"]
"""The paper's metrics; SIM is the mean of TSS, GS, CS and FFS, its "average similarity"."""
METRICS: tuple[MetricName, ...] = ("CV", "TSS", "GS", "CS", "FFS", "CPD", "SIM")
LOWER_IS_BETTER: frozenset[MetricName] = frozenset({"CPD"})
"""All others are from 0 to 1, the higher the better."""
StepClass = Literal["rotate", "flip", "fold", "unfold", "none", "compound", "unknown"]
"""What the truth does in a step: one kind of action, nothing, several kinds, or not stated."""
Scores = dict[MetricName, float]
RunEnding = Literal["complete", "stopped", "interrupted", "running", "not run"]
"""``not run``: the sequence was planned and no run of it was found."""


class Summary(RecordPart):
    """A figure over sequences: how many, mean, standard deviation (n - 1; 0 of one), and the bootstrap interval of the
    mean. All None without any.
    """

    count: int
    mean: float | None
    deviation: float | None
    low: float | None
    high: float | None


class StepScores(RecordPart):
    """One frame from 2 on against the truth. ``parts`` are the terms of the metrics by metric and term,
    such as ``TSS.NV``; ``equal`` says that the state is the truth. ``problem`` says why it does not compile, empty if it does.
    """

    frame: int
    action_class: StepClass
    saved: bool
    equal: bool
    problem: str
    scores: Scores
    parts: dict[str, float]


class RunEvaluation(RecordPart):
    """A planned sequence and what became of it. ``run`` is the run folder below the folder that was evaluated, None if
    there is none. ``complete`` says that every frame of the truth is saved. ``cost`` in US dollars, None if not known.
    """

    sequence: str
    run: str | None
    status: RunEnding
    reason: str
    frames: int
    frames_saved: int
    complete: bool
    queries: int
    input_tokens: int
    output_tokens: int
    cost: float | None
    seconds: float
    steps: list[StepScores]


class ProgressPoint(RecordPart):
    """The curves at one share of the sequence: the mean of each metric over all planned sequences there."""

    progress: float
    means: Scores


class ClassScores(RecordPart):
    """All steps of one class of action, over all planned sequences."""

    action_class: StepClass
    steps: int
    scores: dict[MetricName, Summary]


class Spending(RecordPart):
    """What a sequence took, over the sequences with a run."""

    queries: Summary
    input_tokens: Summary
    output_tokens: Summary
    cost: Summary
    seconds: Summary


class EndingCount(RecordPart):
    """How many sequences ended so; ``reason`` is as the run says it, empty if it is complete."""

    status: RunEnding
    reason: str
    sequences: int


class GroupEvaluation(RecordPart):
    """All runs of one model and variant: a row of the table.

    ``last`` has the last frame of every planned sequence, whether it was reached or not; ``last_completed`` that of the
    completed sequences alone, as the paper has it; ``steps`` the mean over the steps of each planned sequence.
    """

    label: str
    model: str
    variant: str
    planned: int
    completed: int
    last: dict[MetricName, Summary]
    last_completed: dict[MetricName, Summary]
    steps: dict[MetricName, Summary]
    progress: list[ProgressPoint]
    by_class: list[ClassScores]
    spending: Spending
    endings: list[EndingCount]
    runs: list[RunEvaluation]


class EvaluationReport(RecordPart):
    """The whole document. ``configuration`` holds every weight and constant; ``blindness`` how often each metric told a state
    with one mistake from the truth, by the kind of mistake (``docs/evaluation.md``).
    """

    format: Literal[1]
    version: str
    configuration: dict[str, Any]
    sequences: list[str]
    groups: list[GroupEvaluation]
    blindness: dict[str, dict[str, float]]
