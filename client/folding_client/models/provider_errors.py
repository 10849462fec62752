"""What a provider's error means for a query: wait, ask in another form, or stop with one sentence.

litellm sorts only some errors by what they mean, and differently for each provider. So the HTTP status and the
provider's words decide here, whoever the provider is.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from folding_client.interrupts import ContextExceeded, Interrupt, ProviderRefused
from folding_client.models import error_words
from folding_client.models.retries import Transient
from folding_client.models.retry_after import seconds_asked
from folding_client.record.redaction import redact

_LONGEST_REASON = 300
_GARBLED = "converting to valid response"
"""litellm's words where an answer of Gemini's is cut off; it calls that a bad request."""
_LIMITED = 429
_UNPAID = 402
_FORBIDDEN = 403
_TOO_LARGE = 413
_UNFIT = frozenset({400, 404, 413, 415, 422, 501})
"""The statuses under which providers refuse a request for its form."""
_PASSING = frozenset({408, 409, 425, _LIMITED})
"""The statuses below 500 that may pass."""
_OPTIONAL = ("response_format", "reasoning_effort", "thinking", "reasoning")
"""The parameters that a request can do without."""


class RequestUnfit(Exception):
    """The provider refuses a request in this form, but may take another.

    ``change`` names what of the ``RequestForm`` has to be otherwise; ``stop`` is raised if that has been tried.
    """

    def __init__(self, reason: str, stop: Interrupt, **change: Any) -> None:  # noqa: ANN401
        super().__init__(reason)
        self.stop = stop
        self.change = change


@dataclass(frozen=True)
class ProviderError:
    """An error as it is read here: its HTTP ``status``, all its ``words``, the ``reason`` in short for people, and the
    seconds that the provider asks to wait.
    """

    model: str
    status: int
    words: str
    reason: str
    wait: float | None


_Reading = Callable[[ProviderError], Exception | None]


def meaning(model: str, error: Exception) -> Exception:
    """What to raise for an error of litellm's: ``Transient``, ``RequestUnfit``, or an interrupt that says what to do."""
    said = _read(model, error)
    for reading in _READINGS:
        if found := reading(said):
            return found
    return Transient(said.reason, said.wait)


def content_filtered(model: str, reason: str) -> RequestUnfit:
    """A content filter refused a request or its reply: worth one more try, since filters are not always of one mind."""
    stop = ProviderRefused(
        f"The content filter of {model} refused twice ({reason}). Resume to try again, or start a run with another model."
    )
    return RequestUnfit(f"a content filter refused: {reason}", stop, filtered=True)


def no_pictures(model: str, reason: str) -> ProviderRefused:
    """The model takes no pictures, so it cannot do what is asked."""
    message = f"{model} takes no pictures, and photos have to be seen here ({reason}): choose a model that takes images."
    return ProviderRefused(message)


def _read(model: str, error: Exception) -> ProviderError:
    response = getattr(error, "response", None)
    body = getattr(error, "body", None) or getattr(response, "text", "")
    status = getattr(error, "status_code", None)
    words = f"{error} {body}"
    wait = seconds_asked(_headers(error), words)
    return ProviderError(model, status if isinstance(status, int) else 500, words, _in_short(error), wait)


def _headers(error: Exception) -> Mapping[str, str]:
    """The headers of a provider's answer, which litellm keeps in different places."""
    response = getattr(error, "response", None)
    kept = (getattr(error, "litellm_response_headers", None), getattr(response, "headers", None))
    return {name.lower(): str(value) for headers in kept for name, value in (headers or {}).items()}


def _in_short(error: Exception) -> str:
    """The provider's words on one line, short, without keys."""
    words = " ".join(redact(str(error)).split()).rstrip(".")
    return words if len(words) <= _LONGEST_REASON else words[:_LONGEST_REASON] + " ..."


def _spent(said: ProviderError) -> Exception | None:
    """Quota or credit used up: at once, unless the provider says when to come back."""
    if said.status not in (400, _UNPAID, _FORBIDDEN, _LIMITED):
        return None
    asks_to_wait = said.wait is not None or said.status != _LIMITED
    spent = said.status == _UNPAID or error_words.says_quota_is_spent(said.words)
    if not spent and (asks_to_wait or not error_words.says_quota(said.words)):
        return None
    return ProviderRefused(
        f"The quota or the credit at the provider of {said.model} is used up: {said.reason}. Add to it, then resume."
    )


def _lacking(said: ProviderError) -> Exception | None:
    """A package that is not installed here: nothing has been sent."""
    if not error_words.says_package_is_missing(said.words):
        return None
    return ProviderRefused(
        f"{said.model} cannot be reached without another package: {said.reason}. Install it, then resume."
    )


def _garbled(said: ProviderError) -> Exception | None:
    return Transient(said.reason) if _GARBLED in said.words else None


def _filtered(said: ProviderError) -> Exception | None:
    refusing = said.status in _UNFIT or said.status == _FORBIDDEN
    return (
        content_filtered(said.model, said.reason)
        if refusing and error_words.says_filtered(said.words)
        else None
    )


def _longer_than_taken(said: ProviderError) -> Exception | None:
    """A reply, or a conversation, that is longer than the model takes."""
    if said.status not in _UNFIT and said.status != _LIMITED:
        return None
    if most := error_words.longest_reply_named(said.words):
        fewer = ProviderRefused(f"{said.reason}. Give fewer --max-tokens, then resume.")
        return RequestUnfit(f"a reply of {said.model} has {most} tokens at most", fewer, max_tokens=most)
    if said.status != _TOO_LARGE and not error_words.says_too_long(said.words):
        return None
    change: dict[str, Any] = {"older_pictures": False}
    if context := error_words.context_named(said.words):
        change["context"] = context
    reason = f"the conversation is longer than {said.model} takes"
    return RequestUnfit(
        f"{reason}: older pictures are left out", ContextExceeded(f"{reason} ({said.reason})"), **change
    )


def _other_form(said: ProviderError) -> Exception | None:
    """A request that is refused for something that can be left out or done otherwise."""
    if said.status not in _UNFIT:
        return None
    for name in _OPTIONAL:
        if error_words.says_not_taken(name, said.words):
            return RequestUnfit(f"{said.model} does not take {name}", _refused(said), without=name)
    if error_words.says_streaming_only(said.words):
        return RequestUnfit(f"{said.model} only streams", _refused(said), streams=True)
    if error_words.says_no_tools(said.words):
        return RequestUnfit(
            f"{said.model} takes no tools: they are told in text", _refused(said), tools_in_text=True
        )
    return _pictures(said) if error_words.says_pictures(said.words) else None


def _pictures(said: ProviderError) -> Exception:
    most = error_words.most_pictures_named(said.words)
    if most is None:
        return no_pictures(said.model, said.reason)
    return RequestUnfit(f"{said.model} takes {most} pictures at most", _refused(said), most_pictures=most)


def _final(said: ProviderError) -> Exception | None:
    """What no other try can mend; the rest of the errors may pass."""
    if said.status in (401, _FORBIDDEN):
        return ProviderRefused(
            f"The provider of {said.model} refuses the key: {said.reason}. Check it, then resume."
        )
    if said.status == 404:
        return ProviderRefused(
            f"The provider does not know the model {said.model}: {said.reason}. Check the name."
        )
    return _refused(said) if said.status < 500 and said.status not in _PASSING else None


def _refused(said: ProviderError) -> ProviderRefused:
    return ProviderRefused(f"The provider of {said.model} refuses the request: {said.reason}.")


_READINGS: tuple[_Reading, ...] = (
    _lacking,
    _garbled,
    _spent,
    _filtered,
    _longer_than_taken,
    _other_form,
    _final,
)
