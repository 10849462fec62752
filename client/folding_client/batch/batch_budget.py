"""What all runs of a batch may cost together, and what they cost so far, those under way included."""

from collections.abc import Mapping
from typing import Any

from folding_client.interrupts import LimitReached
from folding_client.record.totals import Totals, total_cost, total_tokens


class BatchBudget:
    """Sums the costs of a batch's runs. The run that makes it reach the ``most`` US dollars is paid for; every run, that
    one included, stops before its next query. None for no limit.
    """

    def __init__(self, most: float | None = None) -> None:
        self.most = most
        self._settled = 0.0
        self._under_way: dict[int, float] = {}

    @property
    def spent(self) -> float:
        """US dollars so far, as far as prices are known."""
        return self._settled + sum(self._under_way.values())

    @property
    def is_reached(self) -> bool:
        """Whether no run may ask any more."""
        return self.most is not None and self.spent >= self.most

    @property
    def reason(self) -> str:
        """Why runs stop, in a sentence."""
        return (
            f"The limit of ${self.most:g} for the whole batch is reached (${self.spent:.4f} spent by all its runs); give the "
            "same command with a higher --max-batch-cost."
        )

    def check(self) -> None:
        """LimitReached if the runs together come to the limit."""
        if self.is_reached:
            raise LimitReached(self.reason)

    def settled_before(self, cost: float) -> None:
        """What the batch had cost when it began."""
        self._settled = cost

    def costs(self, run: int, cost: float) -> None:
        """A run under way has cost so much that is not in the sum yet."""
        self._under_way[run] = cost

    def ended(self, run: int, cost: float) -> None:
        """A run ended, and had cost so much that was not in the sum."""
        self._under_way.pop(run, None)
        self._settled += cost


class RunWatch:
    """Is told where one run of a batch is, and hands on what it costs. What it says of itself is for the batch's table.

    ``tokens`` and ``cost`` are those of the run in all, ``tokens_now`` and ``cost_now`` those that the index of the batch does
    not know yet.
    """

    def __init__(self, run: int, name: str, budget: BatchBudget, known: tuple[int, float] = (0, 0.0)) -> None:
        self.run = run
        self.name = name
        self.frames = self.saved = 0
        self.tokens, self.cost = known[0], known[1] or None
        self._known = known
        self._budget = budget

    @property
    def tokens_now(self) -> int:
        """The tokens that the index does not know yet."""
        return max(self.tokens - self._known[0], 0)

    @property
    def cost_now(self) -> float:
        """The US dollars that the index does not know yet."""
        return max((self.cost or 0.0) - self._known[1], 0.0)

    def step(self, frame: int, frames: int, saved: int) -> None:  # noqa: ARG002
        """A step towards ``frame`` begins."""
        self.frames, self.saved = frames, saved

    def doing(self, what: str) -> None:
        """Something begins within the step."""

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:  # noqa: ARG002
        """An event is put on record."""
        self.spent(total_tokens(totals), total_cost(totals))

    def spent(self, tokens: int, cost: float | None) -> None:
        """The run has used so much in all."""
        self.tokens = max(tokens, self.tokens)
        self.cost = self.cost if cost is None else max(cost, self.cost or 0.0)
        self._budget.costs(self.run, self.cost_now)
