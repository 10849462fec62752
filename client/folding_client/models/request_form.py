"""The form in which a conversation goes to a provider, as far as the provider has to be asked to know what it takes.

A request is first sent as the model's entry in litellm's table has it. What the provider refuses is changed once and sent
again: fewer pictures, no older ones, a shorter reply, streaming, tools told in text, a parameter left out.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from folding_prompts import prompt

from folding_client.messages import Message, ToolSpec
from folding_client.models.model_entry import reply_within
from folding_client.models.picture_limits import newest_pictures, pictures_at_most, without_pictures
from folding_client.models.portable_schema import portable

_LIMITS = frozenset({"most_pictures", "max_tokens", "context"})


@dataclass(frozen=True)
class RequestForm:
    """What is otherwise than a request that nobody refused.

    ``filtered`` and ``older_pictures`` hold for one query, the rest for all that follow: ``without`` are parameters
    that the provider does not take, ``pictures`` whether it takes any, ``most_pictures`` how many it does, ``max_tokens`` and ``context`` its limits.
    """

    filtered: bool = False
    older_pictures: bool = True
    pictures: bool = True
    most_pictures: int | None = None
    max_tokens: int | None = None
    context: int | None = None
    streams: bool = False
    tools_in_text: bool = False
    without: frozenset[str] = frozenset()

    def changed(self, change: Mapping[str, Any]) -> "RequestForm":
        """The form with something otherwise. ``without`` names one more parameter, and limits only get lower, so that a
        form that was refused does not come again.
        """
        new = dict(change)
        if "without" in new:
            new["without"] = self.without | {new["without"]}
        for name in _LIMITS & new.keys():
            new[name] = min(new[name], getattr(self, name) or new[name])
        return replace(self, **new)

    def kept(self) -> "RequestForm":
        """The form for the queries that follow."""
        return replace(self, filtered=False, older_pictures=True)

    def longest_reply(self, wanted: int) -> int:
        """The tokens to ask for in a reply."""
        return reply_within(wanted, self.max_tokens, self.context)

    def messages(self, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> list[Message]:
        """The conversation in this form. ProviderRefused if the model takes too few pictures for it."""
        sent = list(messages)
        if self.tools_in_text and tools:
            sent[0] = replace(sent[0], said=f"{sent[0].said}\n\n{told_tools(tools)}")
        if not self.pictures:
            return without_pictures(sent)
        if not self.older_pictures:
            sent = newest_pictures(sent)
        return sent if self.most_pictures is None else pictures_at_most(sent, self.most_pictures)


def told_tools(tools: Sequence[ToolSpec]) -> str:
    """The tools as a text that a model can call them by."""
    specs = [
        {"name": tool.name, "description": tool.description, "parameters": portable(tool.schema)}
        for tool in tools
    ]
    return prompt("agent/tools_in_text", tools="\n".join(json.dumps(spec) for spec in specs))
