"""Where settings come from: options of the command line over ``FOLDINGAGENT_*`` variables over a file over defaults."""

import json
import os
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from folding_schemas.wrong_values import allowed_in_words
from pydantic import ValidationError

from folding_client.interrupts import UsageError
from folding_client.setting_files import read_mapping
from folding_client.settings import Settings

PREFIX = "FOLDINGAGENT_"
"""What the variables begin with that give settings; the rest is the setting's name in capital letters."""
CONFIG_VARIABLE = f"{PREFIX}CONFIG"
"""The variable that names a file of settings, if ``--config`` does not."""
_Place = Callable[[str], str]
"""Says where a setting stands, given its name."""
_ALIKE = 0.8
"""Names that are more alike than this by difflib's measure, from 0 to 1, are taken for a slip."""


def settings_from(
    options: Mapping[str, Any], config: Path | None = None, environment: Mapping[str, str] = os.environ
) -> Settings:
    """The settings that options, variables and a file give together. UsageError, which says where it stands, for a value
    that none can have, and for a name that is no setting.
    """
    named = environment.get(CONFIG_VARIABLE)
    file = config or (Path(named) if named else None)
    given: dict[str, Any] = {}
    places: dict[str, _Place] = {}
    sources: tuple[tuple[_Place, Mapping[str, Any]], ...] = (
        (lambda name: f"{name} in {file}", _in_file(file)),
        (lambda name: f"{PREFIX}{name.upper()}", _in_environment(environment)),
        (lambda name: f"--{name.replace('_', '-')}", options),
    )
    for place, values in sources:
        given |= values
        places |= dict.fromkeys(values, place)
    if isinstance(given.get("prices"), str):  # a run may be resumed from elsewhere
        given["prices"] = str(Path(given["prices"]).expanduser().resolve())
    try:
        return Settings.model_validate(given)
    except ValidationError as error:
        raise _unfit(error, places) from error


def _unfit(error: ValidationError, places: Mapping[str, _Place]) -> UsageError:
    first = error.errors()[0]
    why = allowed_in_words(first)
    if not first["loc"]:
        return UsageError(f"{why}.")
    place = places[str(first["loc"][0])]
    return UsageError(f"{place('.'.join(map(str, first['loc'])))} cannot be {first['input']!r}: {why}.")


def _in_file(file: Path | None) -> dict[str, Any]:
    if file is None:
        return {}
    found = {name.replace("-", "_"): value for name, value in read_mapping(file).items()}
    for name in found:
        if name not in Settings.model_fields:
            message = f"{file} gives {name!r}, which is no setting; the settings are {', '.join(Settings.model_fields)}."
            raise UsageError(message)
    return found


def _in_environment(environment: Mapping[str, str]) -> dict[str, Any]:
    given = {
        variable.removeprefix(PREFIX).lower(): text
        for variable, text in environment.items()
        if variable.startswith(PREFIX) and text
    }
    for name in sorted(given.keys() - Settings.model_fields.keys()):
        if near := get_close_matches(name, Settings.model_fields, n=1, cutoff=_ALIKE):
            message = f"The variable {PREFIX}{name.upper()} gives no setting; did you mean {PREFIX}{near[0].upper()}?"
            raise UsageError(message)
    return {name: _value(given[name]) for name in Settings.model_fields if name in given}


def _value(text: str) -> Any:
    """A number, a truth value or an object if the text is one in JSON, else the text."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return text if value is None or isinstance(value, str | list) else value
