"""Trying again when a provider fails for a while, within limits, as slowly as the provider asks."""

import random
from collections.abc import Awaitable, Callable
from functools import partial
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, Field
from tenacity import AsyncRetrying, RetryCallState, retry_if_exception_type

from folding_client.interrupts import ProviderDown

_Answer = TypeVar("_Answer")


class RetryPolicy(BaseModel):
    """How often and how patiently a query is sent again; waits are in seconds and double from ``first_wait``
    on.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    tries: int = Field(default=6, ge=1)
    first_wait: float = Field(default=2.0, ge=0)
    longest_wait: float = Field(default=120.0, ge=0)


class Transient(Exception):
    """A failure that may pass; ``retry_after`` is how many seconds the provider asks to wait, if it does."""

    def __init__(self, reason: str, retry_after: float | None = None) -> None:
        super().__init__(reason)
        self.retry_after = retry_after


async def with_retries(
    policy: RetryPolicy, send: Callable[[], Awaitable[_Answer]], note: Callable[[str, float], None]
) -> _Answer:
    """The answer of ``send``, which is called again after a ``Transient``; ``note`` is told of each wait.

    ProviderDown after the last try, or if the provider asks to wait longer than the policy allows.
    """
    try:
        async for attempt in AsyncRetrying(
            stop=_gives_up(policy),
            wait=partial(_wait, policy),
            retry=retry_if_exception_type(Transient),
            before_sleep=partial(_report, note),
            reraise=True,
        ):
            with attempt:
                return await send()
    except Transient as failure:
        often = "once" if policy.tries == 1 else f"{policy.tries} times, the last time"
        message = f"The provider failed {often}: {failure}; resume when it is back."
        if failure.retry_after is not None and failure.retry_after > policy.longest_wait:
            message = f"The provider asks to wait {failure.retry_after:.0f} s ({failure}); resume after that."
        raise ProviderDown(message) from failure
    raise AssertionError("unreachable: the last failure is raised again")


def _wait(policy: RetryPolicy, state: RetryCallState) -> float:
    """Twice as long each time, with jitter; never shorter than the provider asks."""
    doubled = min(policy.first_wait * 2.0 ** (state.attempt_number - 1), policy.longest_wait)
    asked = _failure(state).retry_after or 0.0
    return max(asked, doubled * random.uniform(0.5, 1.0))  # noqa: S311


def _report(note: Callable[[str, float], None], state: RetryCallState) -> None:
    note(str(_failure(state)), state.upcoming_sleep)


def _gives_up(policy: RetryPolicy) -> Callable[[RetryCallState], bool]:
    """After the last try, or when the provider asks to wait longer than the policy allows."""
    return lambda state: (
        state.attempt_number >= policy.tries or ((_failure(state).retry_after or 0.0) > policy.longest_wait)
    )


def _failure(state: RetryCallState) -> Transient:
    error = state.outcome.exception() if state.outcome else None
    return error if isinstance(error, Transient) else Transient(str(error))
