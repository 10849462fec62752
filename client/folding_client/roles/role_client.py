"""A model in a role: every query goes through here, within its limit and on record."""

import time
from collections.abc import Sequence
from dataclasses import replace

from folding_client.interrupts import QueriesUsedUp, ReplyUnreadable, StepFailed
from folding_client.messages import NO_USAGE, Message, Reply, ToolSpec
from folding_client.models.model import Model
from folding_client.models.prices import Pricing, as_it_came
from folding_client.record.recorder import Recorder
from folding_client.run_limits import UNLIMITED, SpendingLimits


class RoleClient:
    """Asks a model on behalf of a role: agent, critic, overview or selector."""

    def __init__(
        self,
        role: str,
        model: Model,
        recorder: Recorder,
        limit: int | None = None,
        limits: SpendingLimits = UNLIMITED,
        pricing: Pricing = as_it_came,
    ) -> None:
        self.role = role
        self.model = model
        self._recorder = recorder
        self._limit = limit
        self._limits = limits
        self._pricing = pricing

    @property
    def queries(self) -> int:
        """How many queries the role has made in this run, those before a resume included."""
        totals = self._recorder.totals.get(self.role)
        return totals.queries if totals else 0

    async def query(
        self,
        messages: Sequence[Message],
        tools: Sequence[ToolSpec] = (),
        new_from: int = 0,
        *,
        json_mode: bool = False,
    ) -> Reply:
        """The model's reply. QueriesUsedUp before a query beyond the limit of the role, LimitReached beyond the limits
        of the run; what the model raises is recorded.
        """
        if self._limit is not None and self.queries >= self._limit:
            message = (
                f"The limit of {self._limit} queries for a sequence is reached; resume with a higher "
                "--max-queries."
            )
            raise QueriesUsedUp(message)
        self._limits.check(self._recorder.totals)
        self._recorder.request(self.role, messages, new_from)
        started = time.monotonic()
        try:
            reply = await self.model.query(messages, tools, json_mode=json_mode)
        except StepFailed as failure:
            usage = self._pricing(failure.usage) if isinstance(failure, ReplyUnreadable) else NO_USAGE
            self._recorder.unreadable(self.role, str(failure), usage, time.monotonic() - started)
            raise
        reply = replace(reply, usage=self._pricing(reply.usage))
        self._recorder.reply(self.role, reply, time.monotonic() - started)
        return reply
