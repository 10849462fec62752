"""What a person sees while a batch works, on stderr only: a table on a terminal, elsewhere a line for each run that ends."""

import time
from collections import Counter, deque
from collections.abc import Callable

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from folding_client.batch.batch_budget import BatchBudget, RunWatch
from folding_client.batch.batch_entry import BatchEntry
from folding_client.batch.batch_index import BatchSums, BatchTask
from folding_client.batch.scheduling import Listener
from folding_client.record.redaction import redact

_ROWS = 12
"""Runs under way that are shown: half of a small terminal."""
_OPEN = ("running", "interrupted", "failed", "stopped", "waiting")
"""The statuses of runs that are not complete, in the order in which they are told."""
_LATELY = 200
"""Runs whose ends tell how fast the batch goes: enough to even out long and short ones."""
_A_SECOND = 4
"""Times that the table is drawn anew in a second."""


class BatchTable(Listener):
    """The batch as it goes. What it draws is as large for a million runs as for twenty."""

    def __init__(self, console: Console, clock: Callable[[], float] = time.monotonic) -> None:
        self._console = console
        self._clock = clock
        self._sums = BatchSums(Counter())
        self._budget = BatchBudget()
        self._running: dict[str, tuple[RunWatch, float]] = {}
        self._ends: deque[float] = deque(maxlen=_LATELY)
        self._skipped = 0
        self._live: Live | None = None

    def planned(self, sums: BatchSums, budget: BatchBudget) -> None:
        """Show the table, if there is a terminal to show it on."""
        self._sums, self._budget = sums, budget
        self._ends.append(self._clock())
        if self._console.is_terminal:
            self._live = Live(
                get_renderable=self.drawn, console=self._console, refresh_per_second=_A_SECOND, transient=True
            )
            self._live.start()

    def begun(self, watch: RunWatch) -> None:
        """Show one run more."""
        self._running[watch.name] = watch, self._clock()

    def ended(self, line: BatchEntry) -> None:
        """Print how a run ended."""
        self._ends.append(self._clock())
        self._console.print(redact(line.text), markup=False, highlight=False, soft_wrap=True)

    def skipped(self, task: BatchTask) -> None:  # noqa: ARG002
        """Count one run more that was complete before."""
        self._skipped += 1

    def left(self, watch: RunWatch) -> None:
        """Show a run no more."""
        self._running.pop(watch.name, None)

    def finished(self) -> None:
        """Take the table away, and print the sums."""
        if self._live is not None:
            self._live.stop()
            self._live = None
        self._console.print(self.summary, markup=False, highlight=False, soft_wrap=True)

    @property
    def summary(self) -> str:
        """How far the batch is, in a line."""
        counts = self._sums.counts
        parts = [f"{counts['complete']} of {self._sums.runs} runs complete"]
        parts += [f"{self._skipped} of them before"] if self._skipped else []
        parts += [f"{counts[each]} {each}" for each in _OPEN if counts[each]]
        return f"{', '.join(parts)}{self._spent()}{self._time_left()}"

    def drawn(self) -> Group:
        """The table with its line of sums."""
        table = Table(box=None, pad_edge=False)
        for name in ("run", "frames", "tokens", "cost", "time"):
            table.add_column(name, justify="left" if name == "run" else "right")
        for watch, since in list(self._running.values())[:_ROWS]:
            cost = "" if watch.cost is None else f"${watch.cost:.4f}"
            tokens = f"{watch.tokens:,}" if watch.tokens else ""
            frames = f"{watch.saved}/{watch.frames}" if watch.frames else ""
            table.add_row(Text(redact(watch.name)), frames, tokens, cost, _duration(self._clock() - since))
        more = len(self._running) - _ROWS
        return Group(table, *([Text(f"and {more} more")] if more > 0 else []), Text(self.summary))

    def _spent(self) -> str:
        tokens = self._sums.tokens + sum(watch.tokens_now for watch, _ in self._running.values())
        said = f"; {tokens:,} tokens" if tokens else ""
        if self._budget.spent or self._budget.most is not None:
            most = "" if self._budget.most is None else f" of ${self._budget.most:g}"
            said += f"{',' if said else ';'} ${self._budget.spent:.4f}{most}"
        return said

    def _time_left(self) -> str:
        """How long the rest takes if it goes on as lately."""
        runs = self._sums.counts["running"] + self._sums.counts["waiting"]
        if len(self._ends) < 2 or not self._running:
            return ""
        pace = (self._clock() - self._ends[0]) / (len(self._ends) - 1)
        return f"; about {_duration(pace * runs)} left"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
