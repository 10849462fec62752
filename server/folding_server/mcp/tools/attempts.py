"""Attempts: what was tried for a frame, and settling it for good."""

from collections.abc import Iterator
from typing import Annotated

from folding_schemas.results import AttemptCommitted, AttemptInfo, AttemptList, AttemptState
from mcp.types import CallToolResult
from pydantic import Field

from folding_server.mcp import icons
from folding_server.mcp.context import AppContext, ToolContext, app_context
from folding_server.mcp.parameters import READ_WHOLE, ImageSize, LaterFrame, RunId, StateOfAttempt
from folding_server.mcp.results import AnswerPicture, call_tool_result, picture_result
from folding_server.mcp.services import picture_metas
from folding_server.mcp.services.images import SMALL_SIZE, diagram
from folding_server.mcp.services.run_status import next_step
from folding_server.mcp.tool_record import LOOKS, SETTLES, tool
from folding_server.simulator import folded_state
from folding_server.simulator.vertices import id_ranges
from folding_server.store.exploration import Attempt
from folding_server.store.views import RunView

MOST_EARLIER_STATES = 12
"""How many states are drawn beside the last of each attempt: with 15 attempts, pictures far below ``IMAGE_LIMIT``."""

Number = Annotated[
    int, Field(ge=1, description="the number of an attempt, as list_attempts shows it, from 1"), READ_WHOLE
]


@tool("List attempts", LOOKS, icons.CHECKPOINT_ICON, within="paper", pictures=True)
def list_attempts(
    ctx: ToolContext, frame: LaterFrame, images: ImageSize = "full", run_id: RunId = None
) -> Annotated[CallToolResult, AttemptList]:
    """Show the attempts made at a frame, with a diagram of each state that can be chosen."""
    app = app_context(ctx)
    run = app.run(run_id)
    app.sequence(run).require(frame)
    made = run.attempts.get(frame, ())
    earlier = _earlier_states(run, made)
    shown = _newest(earlier)
    listed = AttemptList(
        frame=frame,
        budget=run.budget or 0,
        attempts=[_info(each) for each in made],
        states=[*(_last_state(run, each) for each in made), *shown],
        used=run.used(frame),
        left_out=len(earlier) - len(shown),
    )
    drawn = (_diagram(app, run, frame, each) for each in listed.states)
    return picture_result(_in_words(run, listed), listed, drawn, images)


@tool("Commit an attempt", SETTLES, icons.CHECKPOINT_ICON, within="paper")
def commit_attempt(
    ctx: ToolContext, frame: LaterFrame, attempt: Number, state: StateOfAttempt = None, run_id: RunId = None
) -> Annotated[CallToolResult, AttemptCommitted]:
    """Settle a frame with one of its attempts."""
    app = app_context(ctx)
    with app.change(ctx, run_id) as change:
        run = change.commit(frame, attempt, state)
    chosen = run.attempts[frame][attempt - 1]
    committed = AttemptCommitted(
        frame=frame,
        attempt=attempt,
        locked_to=run.locked_to,
        next_frame=run.next_frame,
        complete=run.complete,
        state=folded_state(app.paper(run)),
        rewritten=change.view.rewritten_by(chosen),
        dropped=change.view.dropped_by(chosen),
    )
    said = f"Frame {frame} is settled with attempt {attempt}.{_changed_frames(committed)} {next_step(run)}"
    return call_tool_result(said, committed)


def _changed_frames(committed: AttemptCommitted) -> str:
    """What a commitment changed beside its own frame."""
    said = ""
    if committed.rewritten:
        said += f" It grew from other states than those saved, and rewrote frames: {id_ranges(committed.rewritten)}."
    if committed.dropped:
        said += f" Later frames that had been saved after others are gone: {id_ranges(committed.dropped)}."
    return said


def _in_words(run: RunView, listed: AttemptList) -> str:
    """How many attempts count, what the diagrams show, and what choosing one would rewrite."""
    said = [
        f"{len(listed.attempts)} attempts at frame {listed.frame}; {listed.used} of {run.budget} are used"
    ]
    if listed.attempts:
        earlier = [f"{each.attempt}, state {each.state}" for each in listed.states if not each.last]
        last = ", ".join(each.label for each in listed.attempts)
        also = f", then of attempt {'; '.join(earlier)}" if earlier else ""
        said.append(f"the diagrams are those of {last}{also}")
    if listed.left_out:
        said.append(f"{listed.left_out} older states of the attempts can be chosen too and are not drawn")
    return " ".join([f"{'; '.join(said)}.", *_other_paths(listed)])


def _other_paths(listed: AttemptList) -> Iterator[str]:
    """A sentence for each attempt that grew from other frames than those saved."""
    for each in listed.states:
        if not each.last or each.on_path:
            continue
        if not each.committable:
            yield f"B{each.attempt} grew from frames that a commitment has replaced, and cannot be chosen."
        else:
            frames = id_ranges(each.rewrites) or "none"
            yield f"B{each.attempt} grew from other frames; choosing it rewrites frames: {frames}."


def _diagram(app: AppContext, run: RunView, frame: int, shown: AttemptState) -> AnswerPicture:
    """What an attempt came to, last or earlier."""
    path = (*run.attempts[frame][shown.attempt - 1].base_path, *shown.actions)
    drawn = diagram(run, app.replays.after(run.sheet, path), size=SMALL_SIZE)
    state = None if shown.last else shown.state
    return AnswerPicture(drawn, picture_metas.diagram_of_attempt(frame, shown.attempt, state))


def _info(attempt: Attempt) -> AttemptInfo:
    """An attempt as hosts see it."""
    return AttemptInfo(
        attempt=attempt.number, label=attempt.label, actions=list(attempt.actions), outcome=attempt.outcome
    )


def _last_state(run: RunView, attempt: Attempt) -> AttemptState:
    """The state that an attempt came to last, which may be one that it is still on its way from."""
    known = attempt.actions in attempt.states
    return _state(
        run, attempt, attempt.states.index(attempt.actions) + 1 if known else len(attempt.states) + 1
    )


def _earlier_states(run: RunView, made: tuple[Attempt, ...]) -> list[AttemptState]:
    """The other states that can be chosen."""
    return [
        _state(run, attempt, number)
        for attempt in made
        for number, actions in enumerate(attempt.states, start=1)
        if actions != attempt.actions and run.committable(attempt)
    ]


def _newest(found: list[AttemptState]) -> list[AttemptState]:
    """As many of the earlier states as are drawn: those on the path before others, and of these the newest."""
    kept = sorted(found, key=lambda each: (each.on_path, each.attempt, each.state))[-MOST_EARLIER_STATES:]
    return [each for each in found if each in kept]


def _state(run: RunView, attempt: Attempt, number: int) -> AttemptState:
    """One state of an attempt as hosts see it."""
    actions = attempt.states[number - 1] if number <= len(attempt.states) else attempt.actions
    return AttemptState(
        attempt=attempt.number,
        state=number,
        actions=list(actions),
        last=actions == attempt.actions,
        on_path=run.on_path(attempt),
        committable=run.committable(attempt),
        rewrites=run.rewritten_by(attempt),
    )
