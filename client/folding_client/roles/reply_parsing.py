"""Strict reading of what critics and selectors write: the form asked for, or ``ReplyUnreadable`` with the
reason.
"""

import json
import re
from typing import TypeVar

from folding_schemas.results import Verdict
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from folding_client.interrupts import ReplyUnreadable

_FENCE = re.compile(r"\A```(?:json)?\s*\n(.*)\n```\Z", re.DOTALL)
_LABEL = re.compile(r"\bB(\d+)\b")


class CriticReply(BaseModel):
    """What a critic model writes, and nothing else."""

    model_config = ConfigDict(extra="forbid", strict=True)

    verdict: Verdict
    analysis: str = Field(min_length=1)
    anchor_check: str
    discrepancies: list[str]


class OverviewReply(BaseModel):
    """What an overview critic writes, and nothing else."""

    model_config = ConfigDict(extra="forbid", strict=True)

    last_correct_frame: int | None
    first_suspicious_frame: int | None
    per_frame_notes: list[str]
    recommendation: str = Field(min_length=1)


_Form = TypeVar("_Form", bound=BaseModel)


def read_form(form: type[_Form], text: str) -> _Form:
    """The one JSON object that a reply consists of, bare or in a single fence."""
    stripped = text.strip()
    fenced = _FENCE.match(stripped)
    try:
        return form.model_validate_json(fenced.group(1) if fenced else stripped)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        message = f"{where}: {first['msg']}" if where else first["msg"]
        raise ReplyUnreadable(message) from error


def read_label(text: str, count: int) -> int:
    """The one label B1..Bn that a reply names, as a number from 1."""
    labels = {int(number) for number in _LABEL.findall(text)}
    if len(labels) != 1 or not 1 <= (label := labels.pop()) <= count:
        message = f"no single label between B1 and B{count} in {json.dumps(text[:80])}"
        raise ReplyUnreadable(message)
    return label
