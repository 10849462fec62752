"""What the models of a run need before it can begin: ids that are known, litellm, keys, prices to keep a limit by."""

from importlib.util import find_spec
from pathlib import Path

from folding_client.interrupts import UsageError
from folding_client.models.prices import LITELLM, listed_price, read_prices
from folding_client.models.scripted import SCRIPTED, load_script
from folding_client.settings import HYBRID, ROLES, WITHOUT_ASKING, Settings

MODEL_IDS = (
    "geometric, random, search, scripted:FILE, litellm/PROVIDER/MODEL such as litellm/gemini/gemini-3.1-pro-preview, or "
    "hybrid:PROVIDER/MODEL"
)
KEY_SUFFIX = "_API_KEY"
"""What the names of the environment variables end with that hold keys."""
_ASK_FOR_A_KEY = ("openai/", "anthropic/", "gemini/")
"""Providers whose clients need a key to be set whatever the address is."""


def require_models(settings: Settings, *, keys: bool = True) -> None:
    """UsageError if a model of the settings cannot be asked as they are: the id is none, a script, litellm or a key is missing, or
    a limit of cost cannot be kept since its price is not known. ``keys`` and scripts are looked for where this process runs.
    """
    chosen = list(dict.fromkeys(settings.role(role) for role in ROLES))
    if settings.model == HYBRID:
        message = f"There is no model {HYBRID!r}; the ids are {MODEL_IDS}."
        raise UsageError(message)
    for spec in chosen:
        require_known(spec)
    asked = [spec.removeprefix(LITELLM) for spec in chosen if spec.startswith(LITELLM)]
    for model in asked if keys else ():
        _require_key(model, settings.api_base)
    for role in ROLES if keys else ():
        if settings.role(role).startswith(SCRIPTED):
            load_script(Path(settings.role(role).removeprefix(SCRIPTED)), role)
    if asked and settings.max_cost is not None and settings.max_tokens_total is None:
        require_prices(
            settings, f"--max-cost {settings.max_cost:g}", ", or limit the tokens with --max-tokens-total"
        )
    elif settings.prices is not None:
        read_prices(settings.prices)


def require_known(spec: str) -> None:
    """UsageError if a model id is none, or needs litellm where that is not installed."""
    if spec.startswith(LITELLM) and len(spec) > len(LITELLM):
        if find_spec("litellm") is None:
            message = (
                f"The model {spec!r} needs litellm, which is not installed; install it with "
                "pip install 'foldingagent-mcp[agent]', or use the model geometric."
            )
            raise UsageError(message)
        _require_provider(spec.removeprefix(LITELLM))
    elif spec not in WITHOUT_ASKING and not (spec.startswith(SCRIPTED) and len(spec) > len(SCRIPTED)):
        message = f"There is no model {spec!r}; the ids are {MODEL_IDS}."
        raise UsageError(message)


def missing_keys(model: str) -> list[str]:
    """The environment variables with a key that litellm would need for a model, none if one of them is there."""
    from folding_client.models.litellm_model import litellm

    found = litellm().validate_environment(model)
    return [] if found["keys_in_environment"] else list(found["missing_keys"])


def _require_provider(model: str) -> None:
    from folding_client.models.litellm_model import provider_and_name

    provider_and_name(model)


def _require_key(model: str, api_base: str | None) -> None:
    """UsageError if the model's key is missing. Providers that take another proof than a key are left to say so
    themselves.
    """
    missing = missing_keys(model)
    at_another_address = api_base is not None and not model.startswith(_ASK_FOR_A_KEY)
    if missing and not at_another_address and all(name.endswith(KEY_SUFFIX) for name in missing):
        message = (
            f"The provider of {model} needs a key: set {' or '.join(missing)} in the environment, then give the same "
            "command again."
        )
        raise UsageError(message)


def require_prices(settings: Settings, limit: str, otherwise: str = "") -> None:
    """UsageError if a model of the settings has no known price, so that a ``limit`` of cost, in words, cannot be kept;
    ``otherwise`` says what else can be done.
    """
    given = read_prices(settings.prices)
    for spec in dict.fromkeys(settings.role(role) for role in ROLES):
        model = spec.removeprefix(LITELLM)
        if spec.startswith(LITELLM) and model not in given and listed_price(model) is None:
            message = f"The price of {model} is not known, so {limit} cannot be kept; give its price with --prices FILE{otherwise}."
            raise UsageError(message)
