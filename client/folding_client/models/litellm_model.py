"""Any vision-language model that litellm reaches, by its litellm id behind ``litellm/``."""

import logging
import os
from collections.abc import Callable, Sequence
from functools import cache, partial
from types import ModuleType
from typing import Any

from folding_client.interrupts import ProviderRefused, ReplyCutOff, ReplyUnreadable, UsageError
from folding_client.messages import JsonObject, Message, Reply, ToolCall, ToolSpec, Usage
from folding_client.models.chat_format import Dialect, chat_messages, chat_tools, dialect_of
from folding_client.models.retries import Transient, with_retries
from folding_client.record.redaction import redact
from folding_client.settings import Settings

_ECHOED = ("tool_calls", "thinking_blocks", "provider_specific_fields")
_UNREADABLE = frozenset({"malformed_function_call", "MALFORMED_FUNCTION_CALL", "UNEXPECTED_TOOL_CALL"})
_EFFORTS = ((0, "none"), (2048, "low"), (8192, "medium"))
_LONGEST_REASON = 300
_GARBLED = "converting to valid response"
"""litellm's words where an answer of Gemini's is cut off; it calls that a bad request."""


@cache
def litellm() -> ModuleType:
    """litellm, imported when it is first needed, with its own copy of the price list and nothing said on
    stdout.
    """
    os.environ["LITELLM_LOCAL_MODEL_COST_MAP"] = "True"
    import litellm as module

    module.suppress_debug_info = True
    module.telemetry = False
    module.disable_aiohttp_transport = True
    logging.getLogger("LiteLLM").setLevel(logging.CRITICAL)
    return module


class LitellmModel:
    """A provider's model. ``note`` is told of each wait before a query is sent again.

    UsageError if litellm knows no such provider.
    """

    def __init__(self, name: str, settings: Settings, note: Callable[[str, float], None]) -> None:
        self.name = name
        self._id = name.removeprefix("litellm/")
        self._settings = settings
        self._note = note
        self._provider = _provider(self._id)
        self._dialect = dialect_of(self._provider, self._id)
        self._options = _options(self._id, settings, self._dialect)

    async def query(self, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> Reply:
        """The model's reply. ProviderDown when the retries are spent, ProviderRefused at once if they are
        useless, ReplyUnreadable or ReplyCutOff if the provider answers with something that is no reply.
        """
        request = {"model": self._id, "messages": chat_messages(messages, self._dialect), **self._options}
        if tools:
            request["tools"] = chat_tools(tools)
        return _reply(await with_retries(self._settings.retries, partial(_send, request), self._note))


def _provider(model: str) -> str:
    module = litellm()
    try:
        return str(module.get_llm_provider(model)[1])
    except module.exceptions.BadRequestError as error:
        message = (
            f"litellm knows no provider for the model {model!r}; write it as PROVIDER/MODEL, such as "
            "gemini/NAME."
        )
        raise UsageError(message) from error


def _options(model: str, settings: Settings, dialect: Dialect) -> JsonObject:
    """What every query of a model carries; no retries inside litellm, so that ours are the only ones."""
    options: JsonObject = {
        "timeout": settings.timeout,
        "max_tokens": settings.max_tokens,
        "num_retries": 0,
        "max_retries": 0,
        "drop_params": True,
    }
    if settings.api_base:
        options["api_base"] = settings.api_base
    if not litellm().supports_reasoning(model):
        return options
    if dialect.thinking == "budget" and settings.thinking_budget:
        options["thinking"] = {"type": "enabled", "budget_tokens": settings.thinking_budget}
    elif dialect.thinking == "effort":
        options["reasoning_effort"] = next(
            (word for limit, word in _EFFORTS if settings.thinking_budget <= limit), "high"
        )
    return options


async def _send(request: JsonObject) -> Any:  # noqa: ANN401
    """One request; what may pass is ``Transient``, what will not is raised for good."""
    module = litellm()
    errors = module.exceptions
    try:
        return await module.acompletion(**request)
    except errors.ContextWindowExceededError as error:
        message = f"the conversation is longer than the model takes ({_reason(error)})"
        raise ReplyCutOff(message) from error
    except (errors.AuthenticationError, errors.PermissionDeniedError) as error:
        message = (
            f"The provider of {request['model']} refuses the key: {_reason(error)}. Check it, then resume."
        )
        raise ProviderRefused(message) from error
    except errors.NotFoundError as error:
        message = (
            f"The provider does not know the model {request['model']}: {_reason(error)}. Check the name."
        )
        raise ProviderRefused(message) from error
    except (
        errors.RateLimitError,
        errors.InternalServerError,
        errors.ServiceUnavailableError,
        errors.Timeout,
        errors.APIConnectionError,
        errors.BadGatewayError,
    ) as error:
        _need_a_key(request["model"], error)
        raise Transient(_reason(error), _retry_after(error)) from error
    except errors.BadRequestError as error:
        if _GARBLED in str(error):
            raise Transient(_reason(error)) from error
        message = f"The provider of {request['model']} refuses the request: {_reason(error)}."
        raise ProviderRefused(message) from error
    except errors.APIError as error:
        raise Transient(_reason(error), _retry_after(error)) from error


def _need_a_key(model: str, error: Exception) -> None:
    """ProviderRefused if a key that is not set is what an error names: litellm calls that a failure of the connection."""
    missing = litellm().validate_environment(model)["missing_keys"]
    named = [name for name in missing if name in str(error)]
    if named:
        message = (
            f"The provider of {model} needs a key: set {' or '.join(named)} in the environment, then resume."
        )
        raise ProviderRefused(message) from error


def _reason(error: Exception) -> str:
    """The provider's words on one line, short, without keys."""
    words = " ".join(redact(str(error)).split()).rstrip(".")
    return words if len(words) <= _LONGEST_REASON else words[:_LONGEST_REASON] + " ..."


def _retry_after(error: Exception) -> float | None:
    """The seconds a provider asks to wait, if it does and in seconds."""
    response = getattr(error, "response", None)
    for headers in (getattr(error, "litellm_response_headers", None), getattr(response, "headers", None)):
        value = headers.get("retry-after") if headers else None
        if value is not None:
            try:
                return float(value)
            except ValueError:
                return None
    return None


def _reply(response: Any) -> Reply:  # noqa: ANN401
    if not response.choices:
        message = "the provider's answer holds no reply"
        raise ReplyUnreadable(message, _usage(response))
    choice = response.choices[0]
    reason = choice.finish_reason or "stop"
    fields = getattr(choice, "provider_specific_fields", None) or {}
    if reason in _UNREADABLE or fields.get("native_finish_reason") in _UNREADABLE:
        message = "the model wrote a tool call that its provider could not read"
        raise ReplyUnreadable(message, _usage(response))
    native = choice.message.model_dump(exclude_none=True)
    calls = tuple(
        ToolCall(call["id"], call["function"].get("name") or "", call["function"].get("arguments") or "{}")
        for call in native.get("tool_calls") or []
    )
    return Reply(
        native.get("content") or "",
        calls,
        native.get("reasoning_content") or "",
        reason,
        _usage(response),
        {name: native[name] for name in _ECHOED if native.get(name)},
    )


def _usage(response: Any) -> Usage:  # noqa: ANN401
    usage = getattr(response, "usage", None)
    if usage is None:
        return Usage()
    read = getattr(usage, "prompt_tokens_details", None)
    written = getattr(usage, "completion_tokens_details", None)
    return Usage(
        usage.prompt_tokens or 0,
        usage.completion_tokens or 0,
        getattr(read, "cached_tokens", None) or 0,
        getattr(written, "reasoning_tokens", None) or 0,
        _cost(response),
    )


def _cost(response: Any) -> float | None:  # noqa: ANN401
    """The price by litellm's list; None for a model that is not on it."""
    cost = getattr(response, "_hidden_params", {}).get("response_cost")
    return None if cost is None else float(cost)
