"""How much a model is asked to think, in the words of its family.

A budget of tokens is what people give. Older Claude and Gemini models take it as it is, within bounds; newer ones, OpenAI's
and most others take a level instead. Bounds and levels are those of the providers' documentation (Anthropic, "Extended
thinking" and "Effort"; Gemini API, "Thinking"; OpenAI, "Reasoning models"; OpenRouter, "Reasoning tokens"), and of
litellm's table of models where that says more.
"""

import re
from dataclasses import dataclass

from folding_client.messages import JsonObject
from folding_client.models.model_entry import ModelEntry

THINKING_LEVELS = ("none", "minimal", "low", "medium", "high", "xhigh", "max")
"""From no thinking to the most."""
_LEVEL_UP_TO = ((0, "none"), (2048, "low"), (8192, "medium"), (32768, "high"))
"""The level that stands for a budget of so many tokens; more is ``xhigh``."""
_USUAL = frozenset({"low", "medium", "high"})
_LEAST_CLAUDE = 1024
_GEMINI_VERSION = re.compile(r"gemini-(\d+)")
_GEMINI_BUDGETS = (
    ("gemini-2.5-flash-lite", 512, 24576, True),
    ("gemini-2.5-flash", 1, 24576, True),
    ("gemini-2.5", 128, 32768, False),
)
"""What a Gemini 2.5 is called, the least and the most it may think in tokens, and whether it can leave it."""
_FIXED_LEVELS = (("gpt-5-pro", {"high"}), ("-deep-research", {"medium"}), ("gemini-3-pro", {"low", "high"}))
"""Models that take fewer levels than the table says, by a part of the name."""


@dataclass(frozen=True)
class Budgets:
    """A model that is told how many tokens it may think."""

    least: int
    most: int
    can_be_off: bool

    def nearest(self, budget: int) -> int:
        """The budget that the model takes; 0 leaves thinking off."""
        if budget == 0 and self.can_be_off:
            return 0
        return min(max(budget, self.least), self.most)


def thinking_request(entry: ModelEntry, budget: int, longest_reply: int) -> JsonObject:
    """What is sent for a budget of thinking tokens, as litellm's parameters; nothing for a model that cannot think.

    Thinking counts towards the reply: a budget that would leave nothing of it is half of it instead.
    """
    if not entry.reasons:
        return {}
    if budget >= longest_reply:
        budget = longest_reply // 2
    budgets = _budgets(entry, longest_reply)
    if budgets is not None:
        return _as_budget(entry, budgets.nearest(budget))
    levels = _levels(entry)
    return _as_level(entry, _nearest(_level(budget), levels)) if levels else {}


def _budgets(entry: ModelEntry, longest_reply: int) -> Budgets | None:
    """The bounds of a model that takes a budget at this provider; None for one that takes a level."""
    if "thinking" not in entry.parameters:
        return None
    if entry.is_claude and not entry.facts.get("supports_adaptive_thinking"):
        return (
            Budgets(_LEAST_CLAUDE, longest_reply - 1, True)
            if longest_reply > _LEAST_CLAUDE
            else Budgets(0, 0, True)
        )
    for part, least, most, can_be_off in _GEMINI_BUDGETS:
        if part in entry.name:
            return Budgets(least, most, can_be_off)
    return None


def _levels(entry: ModelEntry) -> frozenset[str]:
    """The levels that a model takes, none if it cannot be told how much to think."""
    if entry.provider != "openrouter" and "reasoning_effort" not in entry.parameters:
        return frozenset()
    for part, fixed in _FIXED_LEVELS:
        if part in entry.name:
            return frozenset(fixed)
    stated = entry.facts.get("reasoning_effort_levels")
    if stated is not None:
        return frozenset(stated)
    if entry.is_claude:
        off = frozenset() if entry.facts.get("thinking_always_on") else frozenset({"none"})
        return _USUAL | off | _flagged(entry, "xhigh")
    if version := _GEMINI_VERSION.search(entry.name):
        least = {"minimal"} if int(version.group(1)) >= 3 and "flash" in entry.name else set()
        return (_USUAL | least) - _denied(entry)
    return (_USUAL | _flagged(entry, "none", "minimal", "xhigh")) - _denied(entry)


def _flagged(entry: ModelEntry, *levels: str) -> frozenset[str]:
    return frozenset(
        level for level in levels if entry.facts.get(f"supports_{level}_reasoning_effort") is True
    )


def _denied(entry: ModelEntry) -> frozenset[str]:
    return frozenset(
        level for level in THINKING_LEVELS if entry.facts.get(f"supports_{level}_reasoning_effort") is False
    )


def _level(budget: int) -> str:
    return next((level for most, level in _LEVEL_UP_TO if budget <= most), "xhigh")


def _nearest(wanted: str, levels: frozenset[str]) -> str:
    """The level nearest to the one wanted, the lower of two that are as near."""
    rank = THINKING_LEVELS.index(wanted)
    return min(
        sorted(levels, key=THINKING_LEVELS.index), key=lambda level: abs(THINKING_LEVELS.index(level) - rank)
    )


def _as_budget(entry: ModelEntry, budget: int) -> JsonObject:
    if entry.provider == "openrouter":
        return {"extra_body": {"reasoning": {"max_tokens": budget} if budget else {"effort": "none"}}}
    if budget:
        return {"thinking": {"type": "enabled", "budget_tokens": budget}}
    off: JsonObject = {"type": "disabled"}
    return {"thinking": off if entry.is_claude else {**off, "budget_tokens": 0}}


def _as_level(entry: ModelEntry, level: str) -> JsonObject:
    if entry.provider == "openrouter":
        return {"extra_body": {"reasoning": {"effort": level}}}
    if entry.is_claude and level == "none" and "thinking" in entry.parameters:
        return {"thinking": {"type": "disabled"}}
    return {"reasoning_effort": level}
