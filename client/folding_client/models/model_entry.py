"""What litellm's table of models says of one: whose it is, what it takes, how long its replies may be."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

REPLY_SHARE = 4
"""A reply gets at most this part of a model's context: prompt, tools and two photos with their diagrams are some
7,000 tokens, and a step of the agent grows to three times that.
"""


@dataclass(frozen=True)
class ModelEntry:
    """A model by its ``provider`` and its ``name`` there; ``facts`` are the table's, none for a model it lacks.

    ``parameters`` are the names of the request parameters that litellm passes on to the provider; ``reasons`` says whether
    the model can think.
    """

    provider: str
    name: str
    facts: Mapping[str, Any]
    parameters: frozenset[str]
    reasons: bool

    @property
    def context(self) -> int | None:
        """The tokens that a conversation may have; None if nobody says."""
        return self._tokens("max_input_tokens")

    @property
    def is_claude(self) -> bool:
        """Whether the model is one of Anthropic's, whoever serves it."""
        return "claude" in self.name.lower()

    @property
    def has_json_mode(self) -> bool:
        """Whether the provider can be asked for JSON alone. Claude has none: litellm would force a tool in its place."""
        takes_it = "response_format" in self.parameters and self.facts.get("supports_response_schema") is True
        return takes_it and not self.is_claude

    def longest_reply(self, wanted: int) -> int:
        """The tokens to ask for in a reply where ``wanted`` are allowed."""
        return reply_within(wanted, self._tokens("max_output_tokens"), self.context)

    def _tokens(self, name: str) -> int | None:
        count = self.facts.get(name)
        return count if isinstance(count, int) and count > 0 else None


def reply_within(wanted: int, longest: int | None, context: int | None) -> int:
    """The tokens to ask for in a reply where ``wanted`` are allowed, ``longest`` and the ``context`` as far as they are known."""
    share = context // REPLY_SHARE if context else None
    return min(each for each in (wanted, longest, share) if each)


def facts_of(model: str, table: Mapping[str, Mapping[str, Any]]) -> Mapping[str, Any]:
    """The table's facts on a litellm id; those of the model of that name if it knows the model, but not at this
    provider.
    """
    name = model.rsplit("/", 1)[-1]
    tried = (model, model.partition("/")[2], name, name.replace(".", "-"))
    return next((table[each] for each in tried if each in table), {})
