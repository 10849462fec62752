"""What is known of the models that settings name: keys, what they take, their prices."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from folding_client.models.prices import LITELLM, ModelPrice, listed_facts, listed_price, read_prices
from folding_client.models.requirements import KEY_SUFFIX, missing_keys, require_known
from folding_client.settings import ROLES, Settings


@dataclass(frozen=True)
class ModelRow:
    """One model. What is not known is None; ``missing_keys`` are the variables of which one has to be set, or all,
    as its provider wants it. Prices are US dollars for a million tokens.
    """

    model: str
    roles: list[str]
    missing_keys: list[str]
    images: bool | None
    tools: bool | None
    context_tokens: int | None
    reply_tokens: int | None
    input_price: float | None
    cached_input_price: float | None
    output_price: float | None


@dataclass(frozen=True)
class ModelTable:
    """The models, and the names of the keys in the environment."""

    models: list[ModelRow]
    keys: list[str]


def model_table(
    settings: Settings, names: Sequence[str], environment: Mapping[str, str] = os.environ
) -> ModelTable:
    """What is known of models by id, or of those that the settings give the roles. UsageError for an id that is none."""
    chosen = {role: settings.role(role) for role in ROLES}
    prices = read_prices(settings.prices)
    rows = []
    for spec in dict.fromkeys(names or chosen.values()):
        require_known(spec)
        roles = [role for role, named in chosen.items() if named == spec]
        rows.append(_row(spec, list(map(str, roles)), prices.get(spec.removeprefix(LITELLM))))
    return ModelTable(
        rows, sorted(name for name in environment if name.endswith(KEY_SUFFIX) and environment[name])
    )


def _row(spec: str, roles: list[str], price: ModelPrice | None) -> ModelRow:
    if not spec.startswith(LITELLM):
        return ModelRow(spec, roles, [], None, None, None, None, None, None, None)
    model = spec.removeprefix(LITELLM)
    facts = listed_facts(model)
    price = price or listed_price(model)
    return ModelRow(
        spec,
        roles,
        missing_keys(model),
        facts.get("supports_vision"),
        facts.get("supports_function_calling"),
        facts.get("max_input_tokens"),
        facts.get("max_output_tokens"),
        price.input if price else None,
        price.cached_input if price else None,
        price.output if price else None,
    )


def model_lines(table: ModelTable) -> Iterator[str]:
    """The table for people."""
    for row in table.models:
        yield " ".join((row.model, *([f"({', '.join(row.roles)})"] if row.roles else [])))
        if row.model.startswith(LITELLM):
            yield f"  key: {_key(row.missing_keys)}"
            yield f"  images: {_word(row.images)}; tools: {_word(row.tools)}"
            yield f"  context: {_count(row.context_tokens)}; longest reply: {_count(row.reply_tokens)}"
            yield f"  price: {_price(row)}"
        else:
            yield "  asks no provider: no key, no tokens, no price"
    yield f"keys in the environment: {', '.join(table.keys) or 'none'}"


def _key(missing: Sequence[str]) -> str:
    return f"missing, set {' or '.join(missing)}" if missing else "there, or none needed"


def _word(answer: bool | None) -> str:
    return "not known" if answer is None else "yes" if answer else "no"


def _count(tokens: int | None) -> str:
    return "not known" if tokens is None else f"{tokens:,} tokens"


def _price(row: ModelRow) -> str:
    if row.input_price is None or row.output_price is None:
        return "not known; give it with --prices FILE"
    cached = "" if row.cached_input_price is None else f", ${row.cached_input_price:g} where cached"
    return f"${row.input_price:g} in{cached}, ${row.output_price:g} out, for a million tokens"
