"""What tokens cost: by a price file of the user's, else by litellm's list. A price that is not known is None."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_client.interrupts import UsageError
from folding_client.messages import Usage
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


def listed_facts(model: str) -> dict[str, Any]:
    """What litellm's list says of a model, nothing if it lacks it."""
    from folding_client.models.litellm_model import litellm

    try:
        return dict(litellm().get_model_info(model))
    except Exception:  # noqa: BLE001 - litellm raises what comes for a model that it does not know
        return {}


def listed_price(model: str) -> ModelPrice | None:
    """The price by litellm's list, in which 0 stands for one that it does not know."""
    entry = listed_facts(model)
    read, written = entry.get("input_cost_per_token"), entry.get("output_cost_per_token")
    if not read and not written:
        return None
    cached = entry.get("cache_read_input_token_cost")
    return ModelPrice(
        input=(read or 0) * _MILLION,
        output=(written or 0) * _MILLION,
        cached_input=None if cached is None else cached * _MILLION,
    )


Pricing = Callable[[Usage], Usage]
"""Gives what a reply used its price."""


def as_it_came(usage: Usage) -> Usage:
    """The price that came with the reply."""
    return usage


def pricing_of(spec: str, prices: Prices) -> Pricing:
    """How a model's replies are priced: by the user's file; else as litellm does, unless the model is not on its list, or
    only with a price of 0.
    """
    model = spec.removeprefix(LITELLM)
    if (price := prices.get(model)) is not None:
        return lambda usage: replace(usage, cost=price.cost(usage))
    if spec.startswith(LITELLM) and listed_price(model) is None:
        return lambda usage: replace(usage, cost=None)
    return as_it_came
