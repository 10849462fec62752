"""What a person sees while a run works, on stderr only: frames done, attempt, queries, tokens, price, the last verdict,
what the model says.
"""

import time
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, Self

from rich.console import Console
from rich.status import Status
from rich.text import Text

from folding_client.record.redaction import redact
from folding_client.record.totals import Totals, total_cost, total_tokens

_SHORT = 60
"""Characters of what a model says that are shown beside the rest."""


class Progress(Protocol):
    """Is told where a run is."""

    def step(self, frame: int, frames: int, saved: int) -> None:
        """A step towards ``frame`` begins; ``saved`` of ``frames`` are done."""
        ...

    def doing(self, what: str) -> None:
        """Something begins within the step."""
        ...

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:
        """An event is put on record; ``totals`` are the sums by role with it."""
        ...


class Silent:
    """Shows nothing."""

    def step(self, frame: int, frames: int, saved: int) -> None:
        """Nothing."""

    def doing(self, what: str) -> None:
        """Nothing."""

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:
        """Nothing."""


class Shown:
    """A live line on a terminal; elsewhere a line for each step and attempt. ``verbose`` prints all that models say and
    call besides. A context manager.
    """

    def __init__(self, console: Console, *, verbose: bool = False) -> None:
        self._console = console
        self._verbose = verbose
        self._status: Status | None = Status("starting", console=console) if console.is_terminal else None
        self._started = time.monotonic()
        self._where = ""
        self._attempt = 1
        self._frame = 0
        self._totals: Mapping[str, Totals] = {}
        self._verdict = ""
        self._said = ""
        self._warned: set[str] = set()

    def __enter__(self) -> Self:
        if self._status:
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._status:
            self._status.stop()

    def step(self, frame: int, frames: int, saved: int) -> None:
        """Show the step; off a terminal, print it."""
        self._where = f"{saved} of {frames} frames done, working on frame {frame}"
        if frame != self._frame:
            self._frame, self._attempt, self._verdict = frame, 1, ""
        self._show("thinking")

    def doing(self, what: str) -> None:
        """Show what is being done, on a terminal."""
        if self._status:
            self._show(what)

    def told(self, kind: str, data: Mapping[str, Any], totals: Mapping[str, Totals]) -> None:
        """Take from an event what is shown of it."""
        self._totals = totals
        match kind:
            case "reply":
                self._said = " ".join(data["text"].split())
                self._print_reply(data)
                self.doing("thinking")
            case "verdict":
                self._verdict = data["verdict"] or "NO VERDICT"
                self._print(f"critic on frame {data['frame']}: {self._verdict}. {data['analysis']}")
            case "retry":
                self.doing(f"waiting {data['wait']:.0f} s for the provider")
                self._print(f"{data['role']} waits {data['wait']:.0f} s: {data['reason']}")
            case "result" if not data["is_error"]:
                self._answered(data["name"], data["structured"] or {})

    def _answered(self, tool: str, answer: Mapping[str, Any]) -> None:
        self._warn(answer.get("warnings") or ())
        if tool == "compare_to_frame":
            self._verdict = f"{answer['verdict']} ({answer['agreement']:.2f})"
        elif tool == "restore_checkpoint" and self._where:
            self._begin_attempt(answer.get("next_attempt") or self._attempt)
        elif tool == "get_run" and self._where and (frame := answer.get("next_frame")) == self._frame:
            made = answer.get("attempts", {}).get(str(frame), 0)
            self._begin_attempt(made if answer.get("pending") else made + 1)

    def _warn(self, warnings: Sequence[str]) -> None:
        """Print what the server says against the photos, each sentence once."""
        for each in warnings:
            if each not in self._warned:
                self._warned.add(each)
                self._console.print(f"warning: {each}", markup=False, highlight=False, soft_wrap=True)

    def _begin_attempt(self, number: int) -> None:
        """Show that another attempt begins."""
        if number > self._attempt:
            self._attempt = number
            self._show("thinking")

    def _print_reply(self, data: Mapping[str, Any]) -> None:
        for part in ("thinking", "text"):
            if data[part].strip():
                self._print(f"{data['role']}{' thinks' if part == 'thinking' else ''}: {data[part].strip()}")
        for call in data["calls"]:
            self._print(f"{data['role']} calls {call['name']}({call['arguments']})")

    def _print(self, text: str) -> None:
        if self._verbose:
            self._console.print(redact(text), markup=False, highlight=False, soft_wrap=True)

    def _show(self, what: str) -> None:
        attempt = f", attempt {self._attempt}" if self._attempt > 1 else ""
        parts = [
            f"{self._where}{attempt}",
            spent(self._totals),
            f"last verdict {self._verdict}" if self._verdict else "",
        ]
        line = "; ".join(filter(None, parts))
        if self._status is None:
            self._console.print(f"{line} ({self._elapsed()})", markup=False, highlight=False, soft_wrap=True)
        else:
            said = f' "{redact(self._said)[:_SHORT]}"' if self._said else ""
            self._status.update(Text(f"{line}: {what} ({self._elapsed()}){said}"))

    def _elapsed(self) -> str:
        minutes, seconds = divmod(int(time.monotonic() - self._started), 60)
        return f"{minutes}:{seconds:02d}"


def spent(totals: Mapping[str, Totals]) -> str:
    """What the roles have used, in words; empty where they have used no tokens, as the geometric model, which asks nobody."""
    queries, tokens = sum(each.queries for each in totals.values()), total_tokens(totals)
    if not tokens:
        return ""
    said = f"{queries} {'query' if queries == 1 else 'queries'}"
    return f"{said}, {tokens:,} tokens, {_price(totals)}"


def _price(totals: Mapping[str, Totals]) -> str:
    """What the tokens cost, as far as their prices are known."""
    unpriced = [role for role, each in totals.items() if each.cost is None and each.input_tokens]
    cost = total_cost(totals)
    if cost is None:
        return "price not known"
    return f"${cost:.4f}" + (
        f" without the {' and '.join(unpriced)}, whose price is not known" if unpriced else ""
    )
