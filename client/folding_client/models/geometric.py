"""The default model: no key, no network. It drives the same tools as a vision-language model would, by search.

What it tries stays within the budget of attempts; when that is spent, the loop lets the selector choose.
"""

import json
from collections.abc import Callable, Sequence

from folding_client.interrupts import StepHopeless
from folding_client.messages import Message, Reply, ToolCall, ToolSpec, last_results
from folding_client.search.frame_search import Calls, FrameSearch, SearchOptions
from folding_client.search.search_state import SearchState


def _is_kept_nowhere(state: SearchState) -> None:
    """For a search that need not outlast its process."""


class GeometricModel:
    """A frame search behind the interface of a model: between two queries there is nothing but its ``state``.

    ``keep`` is handed the state before every reply. ``consults`` makes the search ask the critic before it saves.
    """

    name = "geometric"

    def __init__(
        self,
        *,
        consults: bool = False,
        state: SearchState | None = None,
        keep: Callable[[SearchState], None] = _is_kept_nowhere,
    ) -> None:
        self.state = state or SearchState()
        self._keep = keep
        self._search = FrameSearch(self.state, SearchOptions(consults=consults))

    async def query(
        self,
        messages: Sequence[Message],
        tools: Sequence[ToolSpec],  # noqa: ARG002
        *,
        json_mode: bool = False,  # noqa: ARG002
    ) -> Reply:
        """The next calls, given the results of the last ones; a context without a reply begins a step.

        StepHopeless if nothing can be done at a frame.
        """
        results = last_results(messages)
        try:
            calls = self._search.begin() if results is None else self._search.go_on(results)
        except StepHopeless:
            self._begin_anew()
            raise
        reply = self._reply(calls)
        self._keep(self.state)
        return reply

    def _reply(self, calls: Calls | None) -> Reply:
        if calls is None:
            return Reply("The frame could not be saved; starting on it again.")
        self.state.queries += 1
        made = tuple(
            ToolCall(f"geometric_{self.state.queries}_{index}", name, json.dumps(arguments))
            for index, (name, arguments) in enumerate(calls, start=1)
        )
        return Reply(tool_calls=made, finish_reason="tool_calls")

    def _begin_anew(self) -> None:
        self.state.step = None
        self._keep(self.state)
