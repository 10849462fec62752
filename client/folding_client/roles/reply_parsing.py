"""Reading of what critics and selectors write: the form asked for, or ``ReplyUnreadable`` with the reason.

What models add is passed over: words around the JSON object, keys that nobody asked for, a verdict in lower case.
"""

import json
import re
from collections.abc import Iterator
from typing import Annotated, Any, TypeVar

from folding_schemas.results import Verdict
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from folding_client.interrupts import ReplyUnreadable
from folding_client.json_files import first_error

_LABEL = re.compile(r"\bB(\d+)\b")
_LONGEST_WORDS = 4000
"""Characters of an unreadable reply that are passed on: some 1,000 tokens."""
_SPELLINGS = {"EXACT MATCH": "MATCH"}
_DECODER = json.JSONDecoder(strict=False)
"""Takes line breaks inside strings, which models write."""


def _verdict(word: object) -> object:
    """A verdict as the prompt spells it: MATCH for ``exact_match``, EXTREME DIVERGENCE for ``Extreme_Divergence``."""
    if not isinstance(word, str):
        return word
    plain = " ".join(re.split(r"[\s_-]+", word.strip().upper()))
    return _SPELLINGS.get(plain, plain)


def _or_none_listed(value: object) -> object:
    return [] if value is None else value


def _or_no_anchor(value: object) -> object:
    return NO_ANCHOR if value is None else value


NO_ANCHOR = "no anchor provided"
"""What a critic says of an anchor where none was given."""
_Texts = Annotated[list[str], BeforeValidator(_or_none_listed)]


class CriticReply(BaseModel):
    """What a critic model writes."""

    model_config = ConfigDict(extra="ignore", strict=True)

    verdict: Annotated[Verdict, BeforeValidator(_verdict)]
    analysis: str = Field(min_length=1)
    anchor_check: Annotated[str, BeforeValidator(_or_no_anchor)] = NO_ANCHOR
    discrepancies: _Texts = []


class OverviewReply(BaseModel):
    """What an overview critic writes."""

    model_config = ConfigDict(extra="ignore", strict=True)

    last_correct_frame: int | None = None
    first_suspicious_frame: int | None = None
    per_frame_notes: _Texts = []
    recommendation: str = Field(min_length=1)


_Form = TypeVar("_Form", bound=BaseModel)


def read_form(form: type[_Form], text: str) -> _Form:
    """The last JSON object of a reply: a model that changes its mind says so last."""
    objects = list(_objects(text))
    if not objects:
        message = "there is no JSON object in it"
        raise ReplyUnreadable(message, text=text)
    try:
        return form.model_validate_json(json.dumps(objects[-1]))
    except ValidationError as error:
        raise ReplyUnreadable(first_error(error), text=text) from error


def _objects(text: str) -> Iterator[dict[str, Any]]:
    """The JSON objects of a text, in order, those inside others left out."""
    start = text.find("{")
    while start >= 0:
        try:
            value, end = _DECODER.raw_decode(text, start)
        except (ValueError, RecursionError):
            end = start + 1
        else:
            yield value
        start = text.find("{", end)


def with_words(unread: str, text: str) -> str:
    """What is said of a reply that cannot be read: that it cannot, and its words, as far as somebody would read them."""
    words = text.strip()
    return f"{unread} Its words: {words[:_LONGEST_WORDS]}" if words else unread


def read_label(text: str, count: int) -> int:
    """The one label B1..Bn that a reply names, as a number from 1."""
    labels = {int(number) for number in _LABEL.findall(text)}
    if len(labels) != 1 or not 1 <= (label := labels.pop()) <= count:
        message = f"no single label between B1 and B{count} in {json.dumps(text[:80])}"
        raise ReplyUnreadable(message, text=text)
    return label
