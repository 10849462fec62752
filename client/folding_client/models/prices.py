"""What tokens cost: by a price file of the user's, else by litellm's list. A price that is not known is None."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_client.interrupts import ReplyUnreadable, UsageError
from folding_client.messages import Message, Reply, ToolSpec, Usage
from folding_client.models.model import Model
from folding_client.setting_files import read_mapping

_MILLION = 1_000_000
LITELLM = "litellm/"
"""What the ids of models begin with that litellm reaches."""


class ModelPrice(BaseModel):
    """US dollars for a million tokens. ``cached_input`` is for those that the provider's cache held; left out, they
    cost what others do.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    input: float = Field(ge=0)
    output: float = Field(ge=0)
    cached_input: float | None = Field(default=None, ge=0)

    def cost(self, usage: Usage) -> float:
        """The price of a reply in US dollars."""
        cached = self.input if self.cached_input is None else self.cached_input
        fresh = usage.input_tokens - usage.cached_tokens
        paid = fresh * self.input + usage.cached_tokens * cached + usage.output_tokens * self.output
        return paid / _MILLION


Prices = Mapping[str, ModelPrice]
"""Prices by the id of a model, without ``litellm/``."""


def read_prices(path: str | None) -> dict[str, ModelPrice]:
    """The prices that a file gives: by the id of each model, ``input``, ``output`` and perhaps ``cached_input``.
    UsageError if it gives something else.
    """
    if path is None:
        return {}
    found = {}
    for model, price in read_mapping(Path(path)).items():
        try:
            found[model.removeprefix(LITELLM)] = ModelPrice.model_validate(price)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, (model, *first["loc"])))
            message = (
                f"{path} gives no price at {where}: {first['msg']}; give input and output in US dollars for a million "
                "tokens."
            )
            raise UsageError(message) from error
    return found


def listed_price(model: str) -> ModelPrice | None:
    """The price by litellm's list, in which 0 stands for one that it does not know."""
    from folding_client.models.litellm_model import litellm

    try:
        entry = litellm().get_model_info(model)
    except Exception:  # noqa: BLE001 - litellm raises what comes for a model that it does not know
        return None
    read, written = entry.get("input_cost_per_token"), entry.get("output_cost_per_token")
    if not read and not written:
        return None
    cached = entry.get("cache_read_input_token_cost")
    return ModelPrice(
        input=(read or 0) * _MILLION,
        output=(written or 0) * _MILLION,
        cached_input=None if cached is None else cached * _MILLION,
    )


class PricedModel:
    """A model whose replies are priced by a user's price list; without a price on it, litellm's price holds, unless
    that is 0 because litellm knows none.
    """

    def __init__(self, model: Model, prices: Prices) -> None:
        self.name = model.name
        self._model = model
        self._price = prices.get(model.name.removeprefix(LITELLM))

    async def query(self, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> Reply:
        """The model's reply, priced; so is one that cannot be read."""
        try:
            reply = await self._model.query(messages, tools)
        except ReplyUnreadable as unreadable:
            unreadable.usage = self._priced(unreadable.usage)
            raise
        return replace(reply, usage=self._priced(reply.usage))

    def _priced(self, usage: Usage) -> Usage:
        cost = usage.cost or None if self._price is None else self._price.cost(usage)
        return replace(usage, cost=cost)
