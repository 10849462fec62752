"""Calls that every client makes, and whether text, data and pictures of the answers arrived."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from providers.images import check_base64

from mcp_peers.checks import Check
from mcp_peers.our_server import SEQUENCE

Answer = Mapping[str, Any]
"""An answer as a client got it: ``tool``, ``is_error``, ``texts``, ``images`` with ``mime`` and ``data``, ``structured``."""

CALLS: Sequence[tuple[str, dict[str, Any]]] = (
    ("open_run", {"sequence": SEQUENCE}),
    ("save_checkpoint", {"frame": 1}),
    ("fold", {"edge": [1, 3], "direction": 1}),
    ("view_frame", {"frame": 2}),
    ("fold", {"edge": [1, 99], "direction": 1}),
)
"""A run is opened, the square saved and folded, a photo looked at; the last call is refused."""
PICTURED, WORDS = "view_frame", f"Frame 2 of 9 of {SEQUENCE}."
"""The call whose answer has a picture, and the words of it."""
REFUSED = "99"
"""What the sentence of the refusal names."""


def check_answers(
    answers: Sequence[Answer], calls: Sequence[tuple[str, dict[str, Any]]] = CALLS
) -> Iterator[Check]:
    """Whether the answers to the calls arrived whole. The last one is a refusal."""
    yield Check("every call is answered", len(answers) == len(calls), str([each["tool"] for each in answers]))
    for answer in answers[:-1]:
        yield Check(f"{answer['tool']}: done", not answer["is_error"], said(answer))
        yield Check(f"{answer['tool']}: data arrive", bool(data_of(answer)), said(answer))
    for answer in answers:
        if answer["tool"] == PICTURED:
            yield from _check_picture(answer)
    if answers:
        last = answers[-1]
        sentence = last["is_error"] and REFUSED in said(last) and "Traceback" not in said(last)
        yield Check("a refusal is an error with a sentence", bool(sentence), said(last))


def _check_picture(answer: Answer) -> Iterator[Check]:
    """Whether the answer with a picture arrived with its text, its data and its picture."""
    words = said(answer).partition("{")[0]
    yield Check(f"{answer['tool']}: text arrives", WORDS in words, said(answer))
    pictures = answer["images"]
    yield Check(
        f"{answer['tool']}: a picture arrives",
        bool(pictures) and all(map(is_picture, pictures)),
        said(answer),
    )


def said(answer: Answer) -> str:
    """The texts of an answer."""
    return "\n".join(answer["texts"])


def data_of(answer: Answer) -> Mapping[str, Any]:
    """The data of an answer: structured, or the first JSON object in its texts; {} if there is none."""
    structured = answer["structured"]
    return structured if isinstance(structured, dict) else first_object(said(answer))


def first_object(text: str) -> Mapping[str, Any]:
    """The first JSON object in a text; {} if there is none."""
    start = text.find("{")
    if start < 0:
        return {}
    try:
        found, _ = json.JSONDecoder().raw_decode(text[start:])
    except ValueError:
        return {}
    return dict(found)


def is_picture(image: Mapping[str, str]) -> bool:
    """Whether what arrived as a picture is one, of the kind it is said to be."""
    try:
        check_base64(image["data"], image["mime"])
    except (AssertionError, OSError, ValueError):
        return False
    return True
