"""The default model: no key, no network. It drives the same tools as a vision-language model would, by
search.

For each frame it asks the server for proposals, carries the best one out and compares the result with the
photo. A match is saved. If nothing matches, an earlier frame may have been misread: the model goes back to
one whose second best explanation was nearly as good, takes that one, and works forward again. What it tries
stays within the budget of attempts; when that is spent, the loop lets the selector choose.
"""

import json
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, field

from folding_schemas.results import Comparison, Proposals, RunInfo
from pydantic import ValidationError

from folding_client.interrupts import StepHopeless
from folding_client.messages import Message, Reply, ToolCall, ToolSpec
from folding_client.models.transcript_replay import recorded_queries
from folding_client.record.event_log import Event
from folding_client.search.search_memory import Actions, Memory, Trial, common_length, lineage_of

Calls = list[tuple[str, dict[str, object]]]
Step = Generator[Calls, list[Message], None]

PROPOSALS = 6
PLAUSIBLE = 0.05
"""A proposal is tried if its agreement is at most so much below the best one's."""
FIRST_TRIES = 3
"""Proposals tried when a frame is first reached; the rest of the budget is for coming back to it."""


@dataclass
class GeometricModel:
    """A search behind the interface of a model. ``consults`` makes it ask the critic before it saves."""

    name: str = "geometric"
    consults: bool = False
    memory: Memory = field(default_factory=Memory)
    _step: Step | None = None
    _asked: int = 0
    _trouble: str = ""

    async def query(self, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> Reply:  # noqa: ARG002
        """The next calls, given the results of the last ones; a context without a reply begins a step."""
        begun = any(message.role == "assistant" for message in messages)
        return self._answer(_last_results(messages) if begun else None)

    def relive(self, events: Iterable[Event]) -> bool:
        """Go through a recorded run again, so as to know what was tried in it; False, with an empty memory,
        if the run is one that this model would not have made.
        """
        for query in recorded_queries(events):
            try:
                reply = self._answer(query.results)
            except StepHopeless:
                continue
            if query.calls not in (None, [(call.name, call.arguments) for call in reply.tool_calls]):
                self.memory, self._step = Memory(), None
                return False
        return True

    def _answer(self, results: list[Message] | None) -> Reply:
        """The next reply, given the results of the last calls, None at the beginning of a step."""
        try:
            if self._step is None or results is None:
                self._step = self._work()
                return self._reply(next(self._step))
            return self._reply(self._step.send(results))
        except StopIteration:
            self._step = None
            return Reply("The frame could not be saved; starting on it again.")
        except StepHopeless:
            self._step = None
            raise

    def _reply(self, calls: Calls) -> Reply:
        self._asked += 1
        made = tuple(
            ToolCall(f"geometric_{self._asked}_{index}", name, json.dumps(arguments))
            for index, (name, arguments) in enumerate(calls, start=1)
        )
        return Reply(tool_calls=made, finish_reason="tool_calls")

    def _work(self) -> Step:
        """From wherever the run stands to the next saved frame."""
        (answer,) = yield [("get_run", {})]
        info = RunInfo.model_validate(answer.structured)
        frame = info.next_frame or 0
        if frame == 1:
            yield [("save_checkpoint", {"frame": 1})]
            return
        if info.pending:
            yield _restore(frame - 1)
        if (planned := self.memory.planned(frame, lineage_of(info, frame))) is not None:
            trial = yield from self._try(info, planned)
            if trial.agreement >= 0:
                yield _save(trial)
                return
            yield _restore(frame - 1)
        yield from self._explain(info)

    def _explain(self, info: RunInfo) -> Step:
        """Try proposals until one matches the photo; save it, or see what else can be done."""
        frame = info.next_frame or 0
        tries = 1 if self.memory.visited(frame) else FIRST_TRIES
        candidates = yield from self._candidates(info)
        last: Trial | None = None
        for actions in candidates[: max(0, min(tries, info.budget - info.attempts.get(frame, 0)))]:
            if last is not None:
                yield _restore(frame - 1)
            last = yield from self._try(info, actions)
            if last.matches:
                yield _save(last)
                return
        yield from self._unmatched(info, last)

    def _unmatched(self, info: RunInfo, last: Trial | None) -> Step:
        """Nothing matches: blame an earlier frame if it has a rival explanation, else settle for the best."""
        if retreat := self.memory.retreat(info):
            self.memory.plan = {retreat.frame: (retreat.lineage, retreat.actions)}
            yield _restore(retreat.frame - 1)
            yield from self._work()
            return
        best = self.memory.best(info)
        if best is None:
            message = (
                f"Nothing that the server proposes for frame {info.next_frame} can be done and compared"
                f"{self._trouble}; check its photo."
            )
            raise StepHopeless(message)
        if best == last:
            yield _save(best)
            return
        shared = common_length(best.lineage, lineage_of(info, best.frame))
        steps = (*best.lineage, best.actions)
        self.memory.plan = {index + 2: (steps[:index], steps[index]) for index in range(shared, len(steps))}
        yield _restore(shared + 1)
        yield from self._work()

    def _candidates(self, info: RunInfo) -> Generator[Calls, list[Message], list[Actions]]:
        """What can still be tried for the next frame, best first."""
        frame = info.next_frame or 0
        key = (frame, lineage_of(info, frame))
        if key not in self.memory.proposals:
            (answer,) = yield [("propose_actions", {"frame": frame, "count": PROPOSALS})]
            if answer.is_error:
                message = f"The server proposes nothing for frame {frame}: {answer.text}"
                raise StepHopeless(message)
            self.memory.proposals[key] = tuple(Proposals.model_validate(answer.structured).proposals)
        best = max((proposal.agreement for proposal in self.memory.proposals[key]), default=0.0)
        return [
            tuple(proposal.actions)
            for proposal in self.memory.untried(*key)
            if proposal.agreement >= best - PLAUSIBLE
        ]

    def _try(self, info: RunInfo, actions: Actions) -> Generator[Calls, list[Message], Trial]:
        """Carry actions out, compare, and remember how it went."""
        frame = info.next_frame or 0
        calls: Calls = [
            (action.action, action.model_dump(mode="json", exclude_none=True, exclude={"action"}))
            for action in actions
        ]
        *acted, compared = yield [*calls, ("compare_to_frame", {"frame": frame})]
        refusals = [result.text for result in (*acted, compared) if result.is_error]
        self._trouble = f" ({refusals[0]})" if refusals else self._trouble
        comparison = None if any(result.is_error for result in acted) else _comparison(compared)
        matches = comparison is not None and comparison.verdict == "MATCH"
        if matches and self.consults:
            matches = yield from self._critic_agrees(frame, actions)
        agreement = -1.0 if comparison is None else comparison.agreement
        trial = Trial(frame, lineage_of(info, frame), actions, agreement, matches)
        self.memory.trials.append(trial)
        return trial

    def _critic_agrees(self, frame: int, actions: Actions) -> Generator[Calls, list[Message], bool]:
        folds = [action for action in actions if action.action == "fold"]
        arguments: dict[str, object] = {"frame": frame, "action_classes": _classes(actions)}
        if folds:
            edge = folds[-1].edge
            arguments["fold_anchor"] = {
                "moving_element": f"the paper that turned over line {edge[0]}-{edge[1]}",
                "static_reference": "the paper on the other side of that line",
                "relationship": "the edge of what turned over lies where it lies in the diagram",
            }
        (answer,) = yield [("ask_critic", arguments)]
        return not answer.is_error and (answer.structured or {}).get("critic_verdict") == "MATCH"


def _classes(actions: Actions) -> list[str]:
    return list(dict.fromkeys(action.action for action in actions if action.action != "add_vertex")) or [
        "none"
    ]


def _restore(frame: int) -> Calls:
    return [("restore_checkpoint", {"frame": frame})]


def _save(trial: Trial) -> Calls:
    verdict = "a match" if trial.matches else "not a match, the best of what was tried"
    return [
        ("save_checkpoint", {"frame": trial.frame, "notes": f"agreement {trial.agreement:.4f}, {verdict}"})
    ]


def _comparison(message: Message) -> Comparison | None:
    try:
        return None if message.is_error else Comparison.model_validate(message.structured)
    except ValidationError:
        return None


def _last_results(messages: Sequence[Message]) -> list[Message]:
    """The tool results since the last reply."""
    last = max(index for index, message in enumerate(messages) if message.role == "assistant")
    return [message for message in messages[last + 1 :] if message.role == "tool"]
