"""The English words of a lesson read back: sentences to sayings, and these to a program."""

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, cast

from folding_schemas.actions import Actions, FlipAxis, Program

from folding_server.errors import FoldingError, ProgramError
from folding_server.simulator import new_paper
from folding_server.wording.landmarks import COMPASS, SLANTS
from folding_server.wording.refolding import refold
from folding_server.wording.said import (
    InBox,
    MarkedPoint,
    OnLine,
    OnSheet,
    Said,
    SaidFold,
    SaidMarks,
    SaidTurn,
    SaidTurnOver,
    SaidUnfold,
)
from folding_server.wording.sentences import Sentences, messages

Found = Mapping[str, str]
LETTER_KEYS = tuple(f"letter.{letter}" for letter in "ABCDEFGH")
IGNORED = ("check", "finished")
"""What is only looked at: it says nothing of what to do."""


def program_in_words(text: str, name: str = "untitled", sheet: tuple[float, float] = (1.0, 1.0)) -> Program:
    """The program that numbered lines of words say, one step a line. ProgramError names the line that cannot be done."""
    paper = new_paper(sheet)
    steps: list[Actions] = []
    for number, line in enumerate(filter(str.strip, text.splitlines()), 1):
        try:
            said = read_line(line)
            actions, paper = refold(paper, said) if said else ((), paper)
        except FoldingError as error:
            raise ProgramError(f"Line {number} ({line.strip():.60}): {error}") from error
        steps += [actions] if said else []
    return Program(name=name, sheet=sheet, steps=tuple(steps))


def read_line(line: str) -> Said | None:
    """The saying of a line, with or without its number; None if it only tells what to look at."""
    sentences = re.split(r"(?<=\.)\s+", re.sub(r"^\s*\d+\.\s+", "", line.strip()))
    marks: list[MarkedPoint] = []
    said: Said | None = None
    for sentence in filter(None, sentences):
        mark = _mark(sentence)
        if mark is not None:
            marks.append(mark)
        elif sentence == messages("en")["unfold"] and isinstance(said, SaidFold):
            said = _with(said, unfold=True)
        elif sentence == messages("en")["repeat"] and isinstance(said, SaidFold):
            said = _with(said, repeat=True)
        elif not any(_found(messages("en")[kind], sentence) is not None for kind in IGNORED):
            said = _said(sentence)
    if marks and said is None:
        return SaidMarks(tuple(marks))
    return _with(said, marks=tuple(marks)) if marks and isinstance(said, (SaidFold, SaidUnfold)) else said


def _with(said: SaidFold | SaidUnfold, **changes: Any) -> Said:  # noqa: ANN401 - values of any of their fields
    from dataclasses import replace

    return replace(said, **changes)


def _said(sentence: str) -> Said:
    words = messages("en")
    for axis, template in words["turn-over"].items():
        if sentence == template:
            return SaidTurnOver(cast("FlipAxis", axis))
    for sign, way in ((1, "clockwise"), (-1, "counter")):
        found = _found(words["turn"][way], sentence)
        if found:
            return SaidTurn(sign * float(found["angle"]))
    if sentence == words["unfold-newest"]:
        return SaidUnfold()
    if sentence == words["nothing"]:
        return SaidMarks()
    found = _found(words["unfold-crease"], sentence)
    if found and {found["place1"], found["place2"]} <= _places().keys():
        return SaidUnfold((_places()[found["place1"]], _places()[found["place2"]]))
    for fold in _folds(sentence):
        return fold
    raise ProgramError(
        f"{sentence!r:.120} is no sentence that is known; say it as a sheet of instructions does."
    )


def _folds(sentence: str) -> Iterator[SaidFold]:
    """The fold of a sentence, taken apart from the outside in."""
    words = messages("en")
    outer = _found(words["axiom"], sentence)
    if not outer:
        return
    how, inner = next((how, found) for how, found in _by_template(words["layers"], outer["fold"]))
    layers = 2 if how == "both" else int(inner.get("layers", 1))
    of = layers if how in {"all", "both", "single"} else layers + 1
    behind = _found(words["behind"], inner["fold"])
    clause = behind["fold"] if behind else inner["fold"]
    for kind, found in _by_template(words["folds"], clause):
        said = _fold(kind, found)
        if said and str(said.axiom) == outer["axiom"]:
            yield _with(said, layers=layers, of=of, behind=behind is not None)  # type: ignore[misc]


def _by_template(templates: Mapping[str, str], text: str) -> Iterator[tuple[str, Found]]:
    """The templates that fit a text, the longest first, with what fills their places."""
    for kind, template in sorted(templates.items(), key=lambda item: -len(item[1])):
        found = _found(template, text)
        if found is not None:
            yield kind, found


def _fold(kind: str, found: Found) -> SaidFold | None:
    """A fold of which every phrase is known; None if one is not."""
    places = [_places().get(found[name]) for name in ("place1", "place2") if name in found]
    lines = [_lines().get(found[name]) for name in ("line1", "line2") if name in found]
    flap = _places().get(found["flap"]) if "flap" in found else None
    sides = {text: side for side, text in messages("en")["sides"].items()}
    side = sides.get(found["side"]) if "side" in found else None
    if None in places or None in lines or ("flap" in found and not flap) or ("side" in found and not side):
        return None
    axiom = int(kind.partition("-")[0])
    return SaidFold(axiom, tuple(filter(None, places)), tuple(filter(None, lines)), flap, side)


def _mark(sentence: str) -> MarkedPoint | None:
    for kind, found in _by_template(messages("en")["marks"], sentence):
        letter = found["letter"]
        if kind == "sheet":
            return OnSheet(letter, float(found["x"]), float(found["y"]))
        if kind == "box":
            return InBox(letter, _number(found["across"]), _number(found["up"]))
        if found["line"] in _lines():
            return OnLine(letter, _lines()[found["line"]], _number(found["part"]), kind == "upright")
    return None


def _number(text: str) -> float:
    """A part of a length: a fraction, a number, or the number in brackets after a fraction that is near."""
    exact = re.fullmatch(r".*\((\S+)\)", text)
    above, _, below = (exact[1] if exact else text).partition("/")
    try:
        return float(above) / float(below or 1)
    except (ValueError, ZeroDivisionError):
        raise ProgramError(
            f"{text!r:.40} is no part of a length; say a fraction such as 1/2 or a number such as 0.65."
        ) from None


@cache
def _pattern(template: str) -> re.Pattern[str]:
    parts = re.split(r"\{(\w+)\}", template)
    texts = [re.escape(part) if i % 2 == 0 else f"(?P<{part}>.+?)" for i, part in enumerate(parts)]
    return re.compile("".join(texts))


def _found(template: str, text: str) -> Found | None:
    """What fills the places of a template in a text; None if it does not fit."""
    found = _pattern(template).fullmatch(text)
    return found.groupdict() if found else None


@cache
def _lines() -> Mapping[str, str]:
    """The phrases of all lines, each with its key."""
    keys = [
        *(f"edge.{side}" for side in COMPASS),
        *(f"crease.{c}{slant}" for slant in SLANTS for c in ("", "centre-")),
    ]
    return {str(Sentences("en").line(key)): key for key in keys}


@cache
def _places() -> Mapping[str, str]:
    """The phrases of all places, each with its key."""
    ends = ("middle", "end-left", "end-right", "end-lower", "end-upper")
    keys = [
        *(f"corner.{side}" for side in COMPASS),
        "centre",
        *(f"{end}.edge.{side}" for side in COMPASS for end in ends),
        *LETTER_KEYS,
    ]
    return {str(Sentences("en").place(key)): key for key in keys}
