"""What a geometric search knows and where it stands: plain data, kept with the run as ``search.json``."""

from typing import Literal

from folding_schemas.actions import Actions
from folding_schemas.results import Proposal, RunInfo
from folding_schemas.wire import Wire
from pydantic import BaseModel, ConfigDict

Lineage = tuple[Actions, ...]
"""The steps that lead from the flat sheet to the checkpoint something grew from."""
Phase = Literal[
    "locating",
    "clearing",
    "proposing",
    "trying",
    "judging",
    "retrying",
    "replanning",
    "moving",
    "refining",
    "saving",
    "leaving",
]
"""What the calls under way do; the results decide what comes next:

locating    read where the run stands
clearing    go back to the checkpoint of a step that was cut short
proposing   ask for proposals
trying      carry out actions and compare
judging     ask the critic about a match
retrying    go back for the next candidate
replanning  go back since what was planned could not be carried out
moving      go back to an earlier checkpoint
refining    ask, once all is explained, where all photos together show the creases
saving      save the frame
leaving     go back and give the frame up
"""


class Proposed(Wire):
    """What the server proposed for a frame after the steps of ``lineage``, best first, and how it said it."""

    frame: int
    lineage: Lineage
    proposals: tuple[Proposal, ...]
    confident: bool
    summary: str


class Trial(Wire):
    """An explanation that was carried out and compared; ``agreement`` is None if it could not be."""

    frame: int
    lineage: Lineage
    actions: Actions
    agreement: float | None
    matches: bool


class Planned(Wire):
    """Explain ``frame``, after the steps of ``lineage``, by ``actions``."""

    frame: int
    lineage: Lineage
    actions: Actions


class FrameStep(BaseModel):
    """The work on one frame between two answers of the server.

    ``info`` is the run as it stood when the work began, ``candidates`` what is still to be tried (the first of them
    now, None before the proposals are known), ``actions`` what is being tried, ``agreement`` what the comparison
    found, ``last`` the trial that the paper shows, ``why`` what was wrong with it.
    """

    model_config = ConfigDict(extra="forbid")

    phase: Phase = "locating"
    info: RunInfo | None = None
    candidates: list[Actions] | None = None
    actions: Actions = ()
    agreement: float | None = None
    last: Trial | None = None
    why: str = ""

    @property
    def run(self) -> RunInfo:
        """The run as it stood when the work began."""
        assert self.info is not None, "the search knows where the run stands"
        return self.info

    @property
    def frame(self) -> int:
        """The frame to explain."""
        return self.run.next_frame or self.run.frames

    @property
    def lineage(self) -> Lineage:
        """The steps before it."""
        return lineage_of(self.run, self.frame)


class SearchState(BaseModel):
    """All that a search has to remember: proposals, trials, the plan by frame, how often each frame sent it back,
    the last refusal in the server's words, whether the creases were ``refined``, and the step under way. ``queries`` counts
    the replies that were made.
    """

    model_config = ConfigDict(extra="forbid")

    format: Literal[1] = 1
    queries: int = 0
    proposed: list[Proposed] = []
    trials: list[Trial] = []
    plan: dict[int, Planned] = {}
    backtracks: dict[int, int] = {}
    refusal: str = ""
    refined: bool = False
    step: FrameStep | None = None

    def proposals_for(self, frame: int, lineage: Lineage) -> Proposed | None:
        """What was proposed for a frame after these steps, None if nothing was asked for yet."""
        return next((each for each in self.proposed if (each.frame, each.lineage) == (frame, lineage)), None)

    def untried(self, proposed: Proposed) -> list[Proposal]:
        """The proposals that were not carried out yet, best first."""
        place = proposed.frame, proposed.lineage
        tried = {trial.actions for trial in self.trials if (trial.frame, trial.lineage) == place}
        return [proposal for proposal in proposed.proposals if tuple(proposal.actions) not in tried]

    def visited(self, frame: int) -> bool:
        """Whether anything was tried at the frame."""
        return any(trial.frame == frame for trial in self.trials)


def lineage_of(info: RunInfo, frame: int) -> Lineage:
    """The steps of the run's program up to checkpoint ``frame - 1``."""
    return tuple(tuple(step) for step in info.program.steps[: max(frame - 2, 0)])
