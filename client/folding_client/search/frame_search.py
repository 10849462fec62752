"""The search for what was done between two photos: propose, apply, compare, save, remember.

It is a state machine: it says which tools to call, is told what they answered, and says which to call next. All that it
knows between two answers is its ``SearchState``, so that a search which was cut short goes on from that. The caller
carries the calls out, in order, and may leave out those after one that is refused::

    calls = search.begin()
    while calls is not None:
        calls = search.go_on([await call(name, arguments) for name, arguments in calls])

If no proposal matches the photo, an earlier frame may have been misread: the search goes back to one whose second best
explanation was nearly as good, takes that one, and works forward again. If there is none, it settles for the best of
what was tried. Where it only ``tries_clear`` proposals, it gives the frame up instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from folding_schemas.actions import Actions
from folding_schemas.results import Comparison, CreaseRefinement, Proposals, RunInfo
from pydantic import ValidationError

from folding_client.interrupts import StepHopeless
from folding_client.messages import ToolResult
from folding_client.search.backtracking import best_trial, open_plan, rival_choice, way_to
from folding_client.search.search_state import (
    FrameStep,
    Phase,
    Planned,
    Proposed,
    SearchState,
    Trial,
)

Calls = list[tuple[str, dict[str, object]]]
"""Tool calls by name, with their arguments."""
_Answer = TypeVar("_Answer", Proposals, Comparison, CreaseRefinement)


@dataclass(frozen=True)
class SearchOptions:
    """What is tried at a frame, and how far.

    ``proposals`` are asked for, of which those are tried whose agreement is at most ``plausible`` below the best one's:
    so many as ``first_tries`` when the frame is first reached, one whenever the search comes back to it, within the
    budget of attempts, or within ``attempts`` if that is less. With ``tries_clear``, only the best proposal is tried,
    if it is clearly the best, and nothing else is done about a frame that stays unexplained. ``consults`` makes the
    search ask the critic before it takes a match for one. ``first_notes`` are kept with the flat sheet.
    """

    proposals: int = 6
    plausible: float = 0.05
    first_tries: int = 3
    attempts: int | None = None
    tries_clear: bool = False
    consults: bool = False
    first_notes: str | None = None


class FrameSearch:
    """Explains one frame after the other. ``state`` is what it knows, and where it stands."""

    def __init__(self, state: SearchState, options: SearchOptions) -> None:
        self.state = state
        self._options = options

    def begin(self) -> Calls:
        """The first calls from wherever the run stands, whatever was under way before."""
        self._step.phase = "locating"
        return [("get_run", {})]

    def start(self, info: RunInfo) -> Calls | None:
        """The first calls towards the next frame of a run that stands so."""
        self.state.plan = open_plan(self.state.plan, info)
        self.state.step = FrameStep(info=info, candidates=self._left_from_before(info))
        if self._step.frame == 1:
            return self._save(self._options.first_notes)
        return self._restore(self._step.frame - 1, "clearing") if info.pending else self._follow_plan()

    def go_on(self, results: Sequence[ToolResult]) -> Calls | None:
        """The next calls, given what the last were answered; None once the frame is saved or given up.

        StepHopeless if nothing can be done at all.
        """
        match self._step.phase:
            case "locating":
                return self.start(RunInfo.model_validate(results[0].data))
            case "clearing" | "retrying" | "replanning" | "moving":
                return self._gone_back()
            case "proposing":
                return self._proposed(results[0])
            case "trying":
                return self._tried(results)
            case "judging":
                verdict = None if results[0].is_error else (results[0].data or {}).get("critic_verdict")
                return self._concluded(matches=verdict == "MATCH")
            case "refining":
                return self._refined(results[0])
            case "saving" | "leaving":
                self._ended()
                return None

    def _gone_back(self) -> Calls | None:
        """The next calls at the checkpoint that was gone back to."""
        match self._step.phase:
            case "clearing":
                return self._follow_plan()
            case "retrying":
                return self._try(self._candidates[0])
            case "replanning":
                return self._explain()
            case _:
                return self.begin()

    @property
    def _step(self) -> FrameStep:
        if self.state.step is None:
            self.state.step = FrameStep()
        return self.state.step

    @property
    def _candidates(self) -> list[Actions]:
        return self._step.candidates or []

    def _left_from_before(self, info: RunInfo) -> list[Actions] | None:
        """What was still to be tried at this frame, after these steps, when the work on it was cut short."""
        before, now = self._step, FrameStep(info=info)
        same = before.info is not None and (before.frame, before.lineage) == (now.frame, now.lineage)
        return before.candidates if same else None

    def _follow_plan(self) -> Calls | None:
        """Do what is planned for the frame, or go back to an earlier one for which something still is."""
        plan, frame = self.state.plan, self._step.frame
        if plan and (first := min(plan)) < frame:
            return self._restore(first - 1, "moving")
        return self._try(plan[frame].actions) if frame in plan else self._explain()

    def _explain(self) -> Calls | None:
        """Try what is left to try, or ask for proposals first if none are known."""
        if self._step.candidates is not None:
            return self._try_next()
        known = self.state.proposals_for(self._step.frame, self._step.lineage)
        if known is None:
            self._step.phase = "proposing"
            return [("propose_actions", {"frame": self._step.frame, "count": self._options.proposals})]
        return self._try_first(known)

    def _proposed(self, answer: ToolResult) -> Calls | None:
        step = self._step
        proposals = _read(Proposals, answer)
        if proposals is None and not self._options.tries_clear:
            message = f"The server proposes nothing for frame {step.frame}: {answer.summary}"
            raise StepHopeless(message)
        known = Proposed(
            frame=step.frame,
            lineage=step.lineage,
            proposals=tuple(proposals.proposals) if proposals else (),
            confident=proposals is not None and proposals.confident,
            summary=answer.summary,
        )
        self.state.proposed.append(known)
        return self._try_first(known)

    def _try_first(self, known: Proposed) -> Calls | None:
        """Draw up what is to be tried, best first, and begin."""
        info, options = self._step.run, self._options
        budget = info.budget if options.attempts is None else min(info.budget, options.attempts)
        tries = 1 if self.state.visited(self._step.frame) else options.first_tries
        budget -= info.attempts_used.get(self._step.frame, 0)
        possible = budget if info.attempts_left is None else min(budget, info.attempts_left)
        left = max(0, min(tries, possible))
        self._step.candidates = self._worth_trying(known)[:left]
        return self._try_next()

    def _worth_trying(self, known: Proposed) -> list[Actions]:
        """The proposals that come into question and were not tried yet."""
        untried = self.state.untried(known)
        if self._options.tries_clear:
            return [tuple(each.actions) for each in untried if known.confident and each == known.proposals[0]]
        best = max((proposal.agreement for proposal in known.proposals), default=0.0)
        plausible = best - self._options.plausible
        return [tuple(each.actions) for each in untried if each.agreement >= plausible]

    def _try_next(self) -> Calls | None:
        step = self._step
        if not self._candidates:
            return self._leave() if self._options.tries_clear else self._unmatched()
        if step.last is not None:
            return self._restore(step.frame - 1, "retrying")
        return self._try(self._candidates[0])

    def _try(self, actions: Actions) -> Calls:
        """Carry actions out and compare."""
        step = self._step
        step.phase, step.actions = "trying", actions
        acts: Calls = [
            (action.action, action.model_dump(mode="json", exclude_none=True, exclude={"action"}))
            for action in actions
        ]
        return [*acts, ("compare_to_frame", {"frame": step.frame})]

    def _tried(self, results: Sequence[ToolResult]) -> Calls | None:
        step = self._step
        refusal = next((result.summary for result in results if result.is_error), "")
        acted = results[: len(step.actions)]
        comparison = None if any(result.is_error for result in acted) else _read(Comparison, results[-1])
        self.state.refusal = refusal or self.state.refusal
        step.agreement = comparison.agreement if comparison else None
        step.why = refusal or _disagreement(comparison)
        matches = comparison is not None and comparison.verdict == "MATCH"
        if matches and self._options.consults:
            step.phase = "judging"
            return [("ask_critic", _question(step.frame, step.actions))]
        return self._concluded(matches=matches)

    def _concluded(self, *, matches: bool) -> Calls | None:
        """Remember how it went; save what matches, and what was planned because it was best."""
        step = self._step
        trial = Trial(
            frame=step.frame,
            lineage=step.lineage,
            actions=step.actions,
            agreement=step.agreement,
            matches=matches,
        )
        self.state.trials.append(trial)
        planned = step.frame in self.state.plan
        if matches or (planned and trial.agreement is not None):
            return self._save_trial(trial)
        if planned:
            del self.state.plan[step.frame]
            return self._restore(step.frame - 1, "replanning")
        step.candidates, step.last = self._candidates[1:], trial
        return self._try_next()

    def _unmatched(self) -> Calls:
        """Nothing matches: blame an earlier frame if it has a rival explanation, else settle for the best."""
        step, info = self._step, self._step.run
        step.candidates = None
        if rival := rival_choice(self.state, info):
            self.state.backtracks[step.frame] = self.state.backtracks.get(step.frame, 0) + 1
            self.state.plan = {rival.frame: rival}
            return self._restore(rival.frame - 1, "moving")
        best = best_trial(self.state, info)
        if best is None:
            raise StepHopeless(self._nothing_can_be_done())
        if best == step.last:
            return self._save_trial(best)
        checkpoint, self.state.plan = way_to(best, info)
        return self._restore(checkpoint, "moving")

    def _nothing_can_be_done(self) -> str:
        why = f" ({self.state.refusal})" if self.state.refusal else ""
        return (
            f"Nothing that the server proposes for frame {self._step.frame} can be done and compared{why}; "
            "check its photo."
        )

    def _leave(self) -> Calls | None:
        """Give the frame up, with the paper as it was."""
        if self._step.last is not None:
            return self._restore(self._step.frame - 1, "leaving")
        self._ended()
        return None

    def _ended(self) -> None:
        """The work on the frame is over; nothing of what was planned for it is left to do."""
        self._step.candidates = None
        self.state.plan.pop(self._step.frame, None)

    def _restore(self, frame: int, phase: Phase) -> Calls:
        self._step.phase = phase
        return [("restore_checkpoint", {"frame": frame})]

    def _refined(self, answer: ToolResult) -> Calls:
        """Go back for the steps whose creases all photos together show elsewhere; save what was tried if there are none."""
        self.state.refined = True
        step, trial, found = self._step, self.state.trials[-1], _read(CreaseRefinement, answer)
        if found is None or not found.told or len(found.steps) != step.frame - 1:
            return self._save_trial(trial)
        *before, last = (tuple(actions) for actions in found.steps)
        there = trial.model_copy(update={"lineage": tuple(before), "actions": last})
        checkpoint, plan = way_to(there, step.run)
        if (
            checkpoint < step.run.locked_to
            or step.run.attempts_used.get(checkpoint + 1, 0) >= step.run.budget
        ):
            return self._save_trial(trial)
        self.state.plan = plan
        return self._restore(checkpoint, "moving")

    def _save_trial(self, trial: Trial) -> Calls:
        """Save what was tried; until that is done it is planned, lest it be forgotten if the run ends here. Before the last frame is
        saved, it is asked where all photos together show the creases.
        """
        self.state.plan[trial.frame] = Planned(
            frame=trial.frame, lineage=trial.lineage, actions=trial.actions
        )
        if trial.frame == self._step.run.frames and not self.state.refined and not self._options.tries_clear:
            self._step.phase = "refining"
            return [("refine_creases", {"frame": trial.frame})]
        verdict = "a match" if trial.matches else "not a match, the best of what was tried"
        return self._save(f"agreement {trial.agreement:.4f}, {verdict}")

    def _save(self, notes: str | None) -> Calls:
        self._step.phase = "saving"
        arguments: dict[str, object] = {"frame": self._step.frame}
        return [("save_checkpoint", arguments if notes is None else {**arguments, "notes": notes})]


def _read(kind: type[_Answer], answer: ToolResult) -> _Answer | None:
    """What a tool answered; None if it refused, or said something else."""
    try:
        return None if answer.is_error else kind.model_validate(answer.data)
    except ValidationError:
        return None


def _disagreement(comparison: Comparison | None) -> str:
    """What a comparison found wrong, in words."""
    if comparison is None:
        return "The result cannot be compared with the photo."
    return " ".join([f"{comparison.verdict}.", *(f"{each}." for each in comparison.discrepancies)])


def _question(frame: int, actions: Actions) -> dict[str, object]:
    """What the critic is asked about a result of actions."""
    classes = list(dict.fromkeys(action.action for action in actions if action.action != "add_vertex"))
    question: dict[str, object] = {"frame": frame, "action_classes": classes or ["none"]}
    folds = [action for action in actions if action.action == "fold"]
    if not folds:
        return question
    edge = folds[-1].edge
    anchor = {
        "moving_element": f"the paper that turned over line {edge[0]}-{edge[1]}",
        "static_reference": "the paper on the other side of that line",
        "relationship": "the edge of what turned over lies where it lies in the diagram",
    }
    return {**question, "fold_anchor": anchor}
