"""The one interface behind which every model stands."""

from collections.abc import Sequence
from typing import Protocol

from folding_client.messages import Message, Reply, ToolSpec


class Model(Protocol):
    """A conversation partner: a provider's model, a script, or a search.

    ``name`` is the id it was asked for by. ``query`` raises ``ProviderDown`` or ``ProviderRefused`` if there
    is no reply to be had, ``ReplyUnreadable`` if there is one that cannot be read.
    """

    name: str

    async def query(
        self, messages: Sequence[Message], tools: Sequence[ToolSpec], *, json_mode: bool = False
    ) -> Reply:
        """The reply to a conversation, given the tools on offer; JSON alone with ``json_mode``, if the model can be held
        to it.
        """
        ...
