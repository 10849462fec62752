"""When no proposal explains a frame: which earlier choice to change, what was best, and whether a plan still holds."""

from itertools import takewhile

from folding_schemas.results import RunInfo

from folding_client.search.search_state import Lineage, Planned, SearchState, Trial, lineage_of

RIVAL_MARGIN = 0.02
"""An explanation is a rival of another if its agreement with the photo is at most so much lower."""
LOOK_BACK = 3
"""How many frames back a mistake is looked for."""
BACKTRACKS = 2
"""How often one frame may send the search back."""


def rival_choice(state: SearchState, info: RunInfo) -> Planned | None:
    """The rival explanation of an earlier, open frame that is nearest to the one chosen; None if there is none left,
    or the frame at hand has sent the search back often enough.
    """
    frame = info.next_frame or 0
    if state.backtracks.get(frame, 0) >= BACKTRACKS:
        return None
    first = max(info.locked_to + 1, frame - LOOK_BACK, 2)
    rivals = [rival for earlier in range(frame - 1, first - 1, -1) for rival in _rivals(state, earlier, info)]
    return min(rivals, key=lambda rival: rival[0])[1] if rivals else None


def best_trial(state: SearchState, info: RunInfo) -> Trial | None:
    """The trial at the next frame that agreed best, the earliest of equals; None if none could be carried out.

    A trial that grew from other steps than those committed for good cannot be gone back to.
    """
    committed = lineage_of(info, max(info.locked_to, 1) + 1)
    done = [
        (trial.agreement, trial)
        for trial in state.trials
        if trial.frame == info.next_frame
        and trial.agreement is not None
        and trial.lineage[: len(committed)] == committed
    ]
    return max(done, key=lambda pair: pair[0])[1] if done else None


def way_to(trial: Trial, info: RunInfo) -> tuple[int, dict[int, Planned]]:
    """The checkpoint to go back to, and the plan by frame from there, to come to a trial again."""
    steps = (*trial.lineage, trial.actions)
    shared = _common_length(trial.lineage, lineage_of(info, trial.frame))
    planned = {
        index + 2: Planned(frame=index + 2, lineage=steps[:index], actions=steps[index])
        for index in range(shared, len(steps))
    }
    return shared + 1, planned


def open_plan(plan: dict[int, Planned], info: RunInfo) -> dict[int, Planned]:
    """The part of a plan that is still to be carried out: from the first frame on that is not closed and stands, after
    the steps that were planned for, as it should not.
    """
    first = min((frame for frame, planned in plan.items() if _is_open(planned, info)), default=None)
    return {frame: planned for frame, planned in plan.items() if first is not None and frame >= first}


def _is_open(planned: Planned, info: RunInfo) -> bool:
    at = info.next_frame or info.frames + 1
    if planned.frame > at:
        return True
    if planned.frame <= info.locked_to or planned.lineage != lineage_of(info, planned.frame):
        return False
    return planned.frame == at or lineage_of(info, planned.frame + 1) != (*planned.lineage, planned.actions)


def _rivals(state: SearchState, frame: int, info: RunInfo) -> list[tuple[float, Planned]]:
    """Untried explanations of a saved frame, each with how much worse it is than the one chosen."""
    *before, chosen = lineage_of(info, frame + 1)
    lineage = tuple(before)
    proposed = state.proposals_for(frame, lineage)
    if proposed is None or info.attempts_used.get(frame, 0) >= info.budget:
        return []
    known = {tuple(each.actions): each.agreement for each in proposed.proposals}
    reached = known.get(chosen, max(known.values(), default=0.0))
    return [
        (
            reached - rival.agreement,
            Planned(frame=frame, lineage=lineage, actions=tuple(rival.actions)),
        )
        for rival in state.untried(proposed)
        if reached - rival.agreement <= RIVAL_MARGIN
    ]


def _common_length(one: Lineage, other: Lineage) -> int:
    """How many steps two lineages share from the start."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))
