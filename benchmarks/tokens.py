"""Count the input tokens of one reconstruction with and without each saving: ``python benchmarks/tokens.py``
prints one JSON document.

The 140 queries of ``token_trace.py`` (and the critic's, which come on top) are recorded once on the real server,
then sent through litellm to a provider on a local port once for each choice of savings, and counted there by the
rules of ``token_counting.py``. The savings:

summary             every step starts from a fresh context with a text summary; without it, the conversation goes on
repeated_pictures   a picture that the step has shown before is replaced by a line, and so is the film once the paper
                    has moved; once it is drawn as it is now, pictures of it as it was are half as wide and high; a
                    critic's match is told without the pictures that it was given
old_states          of all that tells the paper's current state in the step, only the last does
brief_answers       the data of an answer is left out where its short text says the same
brief_descriptions  tools are described by the first paragraph of their descriptions
standard_tools      only the paper's tools, ``undo`` and ``compare_to_frame`` are on offer
paper_tools         the paper's tools, no more (an option, and not among those that are always on)

``cacheable`` counts the tokens of each request that repeat the beginning of the same role's request before it:
the most that a provider's cache can find again, caches having lifetimes and least lengths. ``paid`` weighs those by
the cache's share of the price in litellm's price list, and the rest by the price of writing to the cache where that
has one: it is comparable with plain input tokens.
"""

import argparse
import asyncio
import json
import os
import sys
import tempfile
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from folding_client.agent import tool_selection
from folding_client.agent.context_compaction import compacted, without_old_states, without_repeated_pictures
from folding_client.messages import (
    Message,
    Reply,
    ToolResult,
    ToolSpec,
    answered,
    system,
    tool_answer,
    user,
)
from folding_client.models.chat_format import chat_messages, chat_tools, dialect_of
from folding_client.models.litellm_model import LitellmModel, entry_of, litellm
from folding_client.settings import Settings
from folding_prompts import prompt
from providers.base import Says, Turn
from providers.openai import OpenAI
from token_counting import RULES, Piece, pieces
from token_trace import Query, record

SAVINGS = (
    "summary",
    "repeated_pictures",
    "old_states",
    "brief_answers",
    "brief_descriptions",
    "standard_tools",
)
ALL = frozenset(SAVINGS)
CHOICES = (
    frozenset[str](),
    *(frozenset({each}) for each in SAVINGS),
    *(ALL - {each} for each in SAVINGS),
    ALL,
    ALL | {"paper_tools"},
)
PRICED = {
    "openai": "openai/gpt-4o",
    "anthropic": "anthropic/claude-sonnet-4-5",
    "gemini": "gemini/gemini-3.1-pro-preview",
}
PAPER = 4_000_000
"""Input tokens of a sequence in the paper, 140 queries on average."""


@dataclass
class Count:
    """Sums over the requests of one replay, by provider; ``critic`` is the critic's part of ``input``."""

    input: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))
    cacheable: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))
    critic: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))

    def add(
        self, role: str, sent: Sequence[Piece], before: Sequence[Piece], providers: Collection[str]
    ) -> None:
        """Count a request for some providers, given the one before it of the same role."""
        repeated = _common_length(sent, before)
        for index, (_, tokens) in enumerate(sent):
            for provider in providers:
                count = tokens[provider]
                self.input[provider] += count
                self.cacheable[provider] += count if index < repeated else 0
                self.critic[provider] += count if role == "critic" else 0


class CountingProvider(OpenAI):
    """A provider that counts what it is sent, checks it, and keeps nothing of it but the last request's pieces."""

    def __init__(self) -> None:
        super().__init__()
        self.count = Count()
        self.role = "agent"
        self.told_to_gemini: list[Piece] = []
        """The query that comes next as it goes to Gemini, which takes pictures in resolutions that others do not know."""
        self._before: dict[str, list[Piece]] = {}

    def next_turn(self, path: str, body: dict[str, Any], headers: dict[str, str]) -> Turn:  # noqa: ARG002
        """Any reply does, since what follows is on record."""
        self.check(path, body)
        for to, sent in (("others", list(pieces(body))), ("gemini", self.told_to_gemini)):
            counted = {"gemini"} if to == "gemini" else RULES.keys() - {"gemini"}
            known = f"{self.role} {to}"
            self.count.add(self.role, sent, self._before.get(known, []), counted)
            self._before[known] = sent
        return Says("Noted.")


def _common_length(one: Sequence[Piece], other: Sequence[Piece]) -> int:
    """How many pieces two requests share from the start."""
    differ = (index for index, (a, b) in enumerate(zip(one, other, strict=False)) if a[0] != b[0])
    return next(differ, min(len(one), len(other)))


def sent_with(savings: frozenset[str], queries: Sequence[Query]) -> Iterator[Query]:
    """The queries as they go out with these savings."""
    told = queries if "summary" in savings else _one_conversation(queries)
    for query in told:
        tools = _offered(query.tools, savings)
        messages = list(query.messages)
        if query.role == "agent":
            listed = tool_selection.tool_list(query.tools), tool_selection.tool_list(tools)
            messages[0] = system(messages[0].text.replace(*listed))
        yield replace(query, messages=tuple(_saved(messages, savings)), tools=tools)


def _saved(messages: list[Message], savings: frozenset[str]) -> list[Message]:
    if "brief_answers" in savings:
        messages = [_compacted(each) for each in messages]
    if "old_states" in savings:
        messages = without_old_states(messages)
    return without_repeated_pictures(messages) if "repeated_pictures" in savings else messages


def _compacted(message: Message) -> Message:
    return replace(message, result=message.result and compacted(message.tool or "", message.result))


def _offered(tools: tuple[ToolSpec, ...], savings: frozenset[str]) -> tuple[ToolSpec, ...]:
    kept = {tool.name for tool in tools}
    if "standard_tools" in savings:
        kept = {*tool_selection.STANDARD_TOOLS, "ask_critic"}
    if "paper_tools" in savings:
        kept = {*tool_selection.PAPER_TOOLS, "ask_critic"}
    chosen = [tool for tool in tools if tool.name in kept]
    return tuple(map(tool_selection.summarised, chosen) if "brief_descriptions" in savings else chosen)


def _one_conversation(queries: Sequence[Query]) -> Iterator[Query]:
    """The queries as they would be if no step began afresh: what was said before comes first, and no summary."""
    frames = sum(query.role == "agent" and query.opens_a_step for query in queries)
    frame = 0
    said: list[Message] = []
    step: list[Message] = []
    for query in queries:
        if query.role != "agent":
            yield query
            continue
        about, opening, *rest = query.messages
        if query.opens_a_step:
            frame += 1
            said = [*said, *step]
            begun = _without_summary(opening, frame, frames)
        yield replace(query, messages=(about, *said, begun, *rest))
        step = [begun, *rest, *_carried_out(query.reply)]


def _without_summary(opening: Message, frame: int, frames: int) -> Message:
    """The opening of a step where all that came before is in view anyway."""
    if frame == 1:
        return opening
    said = opening.said.partition("The current state:")
    numbers = {"frames": frames, "before": frame - 1, "frame": frame, "remaining": frames - frame + 1}
    told = prompt("agent/later_step", history="(as above)", state="", **numbers)
    return user(told.partition("The current state:")[0] + said[1] + said[2], opening.shown)


def _carried_out(reply: Reply) -> list[Message]:
    """A reply that ended a step, with its results in brief."""
    done = ToolResult("Saved.")
    return [answered(reply), *(tool_answer(call, done) for call in reply.tool_calls)]


async def replayed(queries: Iterator[Query]) -> Count:
    """Send queries to the local provider, and what it counted."""
    with CountingProvider() as provider:
        settings = Settings(api_base=provider.url)
        model = LitellmModel(f"litellm/{PRICED['openai']}", settings, lambda *_: None)
        gemini = dialect_of(entry_of(PRICED["gemini"]))
        for query in queries:
            provider.role = query.role
            provider.told_to_gemini = list(
                pieces({"messages": chat_messages(query.messages, gemini), "tools": chat_tools(query.tools)})
            )
            await model.query(query.messages, query.tools)
        return provider.count


def measure(folder: Path, again: bool) -> dict[str, Any]:
    """All figures; those of the default alone where the agent does not ask ``again`` for what it has been shown."""
    queries = record(folder, again)
    choices = CHOICES if again else (ALL,)
    counts = {chosen: asyncio.run(replayed(sent_with(chosen, queries))) for chosen in choices}
    every = counts[ALL]
    return {
        "queries": {"agent": sum(query.role == "agent" for query in queries), "all": len(queries)},
        "prices": {provider: prices(model) for provider, model in PRICED.items()},
        "paper": PAPER,
        "savings": [
            {"on": [each for each in (*SAVINGS, "paper_tools") if each in chosen], **figures(count)}
            for chosen, count in counts.items()
        ],
        "share of the paper's": {
            provider: {
                "input": round(every.input[provider] / PAPER, 3),
                "paid": round(paid(every, provider) / PAPER, 3),
            }
            for provider in RULES
        },
    }


def figures(count: Count) -> dict[str, dict[str, int]]:
    """One variant's sums by provider."""
    return {
        "input": count.input,
        "of which critic": count.critic,
        "cacheable": count.cacheable,
        "paid": {provider: paid(count, provider) for provider in RULES},
    }


def paid(count: Count, provider: str) -> int:
    """The input tokens that would cost as much as these do with a cache."""
    weights = prices(PRICED[provider])
    again = count.cacheable[provider]
    return round(again * weights["read"] + (count.input[provider] - again) * weights["write"])


@cache
def prices(model: str) -> dict[str, float]:
    """What reading from a cache and writing to it cost, as shares of the price of plain input."""
    info = litellm().get_model_info(model)
    plain = info["input_cost_per_token"]
    return {
        "read": round(info["cache_read_input_token_cost"] / plain, 3),
        "write": round((info.get("cache_creation_input_token_cost") or plain) / plain, 3),
    }


def main() -> None:
    """Measure, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--once", action="store_true", help="do not ask again for what a step opens with; the default alone"
    )
    given = parser.parse_args()
    os.environ.setdefault("OPENAI_API_KEY", "none is needed")
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        found = measure(Path(folder), not given.once)
    json.dump({**found, "seconds": round(time.monotonic() - started, 1)}, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
