"""Under what conditions a batch reconstructs each sequence: models x variants x seeds."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from pydantic import ValidationError

from folding_client.interrupts import UsageError
from folding_client.settings import WITHOUT_ASKING, Settings

_DRAWS_NOTHING = WITHOUT_ASKING - {"random"}
"""Models that a seed makes no difference to."""


@dataclass(frozen=True)
class Condition:
    """The settings of a column of the table, and the folder of its runs within that of the batch; empty for that itself."""

    settings: Settings
    folder: str = ""

    @property
    def made_by(self) -> str:
        """What runs of different conditions differ in."""
        return f"{self.settings.model} {self.settings.variant} {self.settings.seed}"


def conditions_of(
    settings: Settings, models: Sequence[str], variants: Sequence[str], seeds: Sequence[int]
) -> list[Condition]:
    """Every model in every variant with every seed; an empty list is what the settings say. Models that ask nobody, and
    hybrids, have the one variant ``agent``; those that draw nothing have the one seed.

    UsageError for a value that none can have, or nothing left.
    """
    if not (models or variants or seeds):
        return [Condition(settings)]
    found: dict[str, Condition] = {}
    for model, variant, seed in product(
        models or [settings.model], variants or [settings.variant], seeds or [settings.seed]
    ):
        one_variant = model in WITHOUT_ASKING or model.startswith("hybrid:")
        if one_variant and variant != "agent" and (len(variants) > 1 or models):
            continue
        chosen = _chosen(settings, model=model, variant=variant, seed=0 if model in _DRAWS_NOTHING else seed)
        condition = Condition(chosen, _folder(chosen))
        if (known := found.get(condition.folder)) is not None and known.made_by != condition.made_by:
            message = f"The runs of {known.settings.model} and {model} would share the folder {condition.folder}; give one of them a batch of its own."
            raise UsageError(message)
        found[condition.folder] = condition
    if not found:
        message = f"None of the models {', '.join(models)} works in the variants {', '.join(variants)}; give agent besides."
        raise UsageError(message)
    return list(found.values())


def _chosen(settings: Settings, **values: Any) -> Settings:
    try:
        return Settings.model_validate(settings.model_dump(exclude_unset=True) | values)
    except ValidationError as error:
        first = error.errors()[0]
        where = f"{first['loc'][0]} cannot be {first['input']!r}: " if first["loc"] else ""
        message = f"{where}{first['msg'].removeprefix('Value error, ')}."
        raise UsageError(message) from error


def _folder(settings: Settings) -> str:
    """A name that stays when other conditions are added."""
    return "_".join(_parts(settings))


def _parts(settings: Settings) -> Iterator[str]:
    yield re.sub(r"[^A-Za-z0-9.]+", "-", settings.model.removeprefix("litellm/")).strip("-.") or "model"
    if settings.variant != "agent":
        yield settings.variant
    if settings.seed:
        yield f"seed-{settings.seed}"
