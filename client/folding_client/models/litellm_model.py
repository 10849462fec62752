"""Any vision-language model that litellm reaches, by its litellm id behind ``litellm/``."""

import logging
import os
from collections.abc import Callable, Sequence
from functools import cache, partial
from types import ModuleType
from typing import Any

from folding_client.interrupts import ContextExceeded, Interrupt, ProviderRefused, UsageError
from folding_client.messages import JsonObject, Message, Reply, ToolSpec
from folding_client.models.chat_format import chat_messages, chat_tools, dialect_of
from folding_client.models.model_entry import ModelEntry, facts_of
from folding_client.models.prices import LITELLM
from folding_client.models.provider_errors import RequestUnfit, content_filtered, meaning, no_pictures
from folding_client.models.reply_reading import read_reply
from folding_client.models.request_form import RequestForm
from folding_client.models.retries import Transient, with_retries
from folding_client.models.thinking import thinking_request
from folding_client.settings import ModelRole, Settings

_JSON_MODE = {"response_format": {"type": "json_object"}}
_FILTERED = "content_filter"
_SENT_NO_PICTURES = frozenset({"deepseek"})
"""Providers to which litellm sends a conversation without its pictures, and says nothing."""
_OURS = frozenset({"api_base", "num_retries", "max_retries", "drop_params"})
"""The options of a query that decide nothing about the answer."""


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

    UsageError if litellm knows no such provider, or the model takes no pictures and plays a ``role`` that has to see: every
    one but that of an agent, who can go by numbers and words.
    """

    def __init__(
        self,
        name: str,
        settings: Settings,
        note: Callable[[str, float], None],
        role: ModelRole = "agent",
    ) -> None:
        self.name = name
        self._id = name.removeprefix(LITELLM)
        self._settings = settings
        self._note = note
        self._entry = entry_of(self._id)
        self._dialect = dialect_of(self._entry)
        blind = self._entry.facts.get("supports_vision") is False or self._entry.provider in _SENT_NO_PICTURES
        self._form = RequestForm(pictures=not blind)
        if blind and (role != "agent" or settings.variant != "agent"):
            raise UsageError(
                f"{no_pictures(self._id, f'as the {role}')} As an agent it can go by numbers and words: with --critic geometric, "
                "--overview geometric and --selector geometric."
            )

    @property
    def sent(self) -> JsonObject:
        """What every query carries beside the conversation, as far as it decides how the model answers."""
        options = self._options(self._form)
        return {name: options[name] for name in options if name not in _OURS}

    async def query(
        self, messages: Sequence[Message], tools: Sequence[ToolSpec], *, json_mode: bool = False
    ) -> Reply:
        """The model's reply, in JSON alone with ``json_mode`` where the provider has it.

        ProviderDown when the retries are spent, ProviderRefused at once if they are useless, ContextExceeded if the
        conversation is too long even without its older pictures, ReplyUnreadable if the provider answers with
        something that is no reply.
        """
        form = self._form
        request = self._request(form, messages, tools, json_mode)
        while True:
            try:
                response = await with_retries(
                    self._settings.retry_policy, partial(self._ask, request), self._note
                )
            except RequestUnfit as unfit:
                again = form.changed(unfit.change)
                other = self._request(again, messages, tools, json_mode)
                if again == form or (other == request and not again.filtered):
                    raise _stop(unfit, messages) from unfit
                self._note(str(unfit), 0.0)
                form, request = again, other
            else:
                self._form = form.kept()
                return read_reply(response, messages, tools)

    def _request(
        self, form: RequestForm, messages: Sequence[Message], tools: Sequence[ToolSpec], json_mode: bool
    ) -> JsonObject:
        sent = form.messages(messages, tools)
        request = {"model": self._id, "messages": chat_messages(sent, self._dialect), **self._options(form)}
        if tools and not form.tools_in_text:
            request["tools"] = chat_tools(tools)
        if json_mode and self._entry.has_json_mode and "response_format" not in form.without:
            request |= _JSON_MODE
        if form.streams:
            request |= {"stream": True, "stream_options": {"include_usage": True}}
        return request

    def _options(self, form: RequestForm) -> JsonObject:
        """What every query of a model carries; no retries inside litellm, so that ours are the only ones."""
        longest = form.longest_reply(self._entry.longest_reply(self._settings.max_tokens))
        options: JsonObject = {
            "timeout": self._settings.timeout,
            "max_tokens": longest,
            "num_retries": 0,
            "max_retries": 0,
            "drop_params": True,
        }
        if self._settings.api_base:
            options["api_base"] = self._settings.api_base
        thinking = thinking_request(self._entry, self._settings.thinking_budget, longest)
        unwanted = form.without | ({"extra_body"} if "reasoning" in form.without else set())
        return options | {name: value for name, value in thinking.items() if name not in unwanted}

    async def _ask(self, request: JsonObject) -> Any:  # noqa: ANN401
        """One request; what may pass is ``Transient``, what another form may do about ``RequestUnfit``."""
        try:
            response = await litellm().acompletion(**request)
            if request.get("stream"):
                response = litellm().stream_chunk_builder(
                    [chunk async for chunk in response], request["messages"]
                )
        except (*litellm().LITELLM_EXCEPTION_TYPES, ImportError) as error:
            self._need_a_key(error)
            raise meaning(self._id, error) from error
        if response is None:
            message = "the provider's stream held nothing"
            raise Transient(message)
        if response.choices and response.choices[0].finish_reason == _FILTERED:
            raise content_filtered(self._id, "it withheld the reply")
        return response

    def _need_a_key(self, error: Exception) -> None:
        """ProviderRefused if a key that is not set is what an error names: litellm calls that a failure of the connection."""
        missing = litellm().validate_environment(self._id)["missing_keys"]
        named = [name for name in missing if name in str(error)]
        if named:
            message = f"The provider of {self._id} needs a key: set {' or '.join(named)} in the environment, then resume."
            raise ProviderRefused(message) from error


def _stop(unfit: RequestUnfit, messages: Sequence[Message]) -> Interrupt:
    """What ends a query that was refused in every form. A conversation that is too long before its first reply is no
    shorter if the step begins anew.
    """
    if isinstance(unfit.stop, ContextExceeded) and all(message.role != "assistant" for message in messages):
        reason = str(unfit.stop)
        message = f"{reason[:1].upper()}{reason[1:]} as it begins. Start a run with a model of more context, or --tools paper."
        return ProviderRefused(message)
    return unfit.stop


def provider_and_name(model: str) -> tuple[str, str]:
    """The provider of a litellm id, and the model's name there. UsageError if litellm knows no such provider."""
    module = litellm()
    try:
        name, provider = module.get_llm_provider(model)[:2]
    except module.exceptions.BadRequestError as error:
        message = (
            f"litellm knows no provider for the model {model!r}; write it as PROVIDER/MODEL, such as "
            "gemini/NAME."
        )
        raise UsageError(message) from error
    return str(provider), str(name)


def entry_of(model: str) -> ModelEntry:
    """What litellm's table says of a model, by its litellm id. UsageError if litellm knows no such provider."""
    module, (provider, name) = litellm(), provider_and_name(model)
    parameters = module.get_supported_openai_params(name, custom_llm_provider=provider) or ()
    facts = facts_of(model, module.model_cost)
    reasons = bool(facts.get("supports_reasoning") or module.supports_reasoning(model))
    return ModelEntry(provider, name, facts, frozenset(parameters), reasons)
