"""Sayings as sentences, in the words of a message file: a grammar of phrases within phrases.

A message file has one object of templates. A phrase may be a pair: the form that is acted on and the form after a preposition
or of a possessor, which a template asks for by a star, as in ``{line1*}``.
"""

import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from folding_server.wording.said import (
    InBox,
    LineKey,
    MarkedPoint,
    OnLine,
    PlaceKey,
    Said,
    SaidFold,
    SaidMarks,
    SaidTurn,
    SaidTurnOver,
    SaidUnfold,
)

Language = Literal["en", "de", "ja"]
Phrase = str | Sequence[str]
"""A phrase that has one form, or two."""

SAID_EXACTLY = 5e-7
"""A number is said as a fraction if it is nearer to it: numbers are said to six decimals."""
ROUGHLY = 0.004
"""A fraction is told beside a number that is so near to it."""
DENOMINATORS = (2, 3, 4, 5, 6, 8, 16)
ROUGH_DENOMINATORS = (2, 3, 4, 5, 6, 8)


@cache
def messages(language: Language) -> Mapping[str, Any]:
    """The templates of a language."""
    text = (
        files("folding_server.wording").joinpath("messages", f"{language}.json").read_text(encoding="utf-8")
    )
    document: Mapping[str, Any] = json.loads(text)
    return document


class Sentences:
    """What is said, in one language."""

    def __init__(self, language: Language) -> None:
        self.words = messages(language)

    def say(self, said: Said) -> str:
        """The sentences of a saying."""
        match said:
            case SaidTurnOver(axis=axis):
                return str(self.words["turn-over"][axis])
            case SaidTurn(angle=angle):
                way = "clockwise" if angle > 0 else "counter"
                return filled(self.words["turn"][way], angle=self._plain(abs(angle)))
            case SaidUnfold(places=places, marks=marks):
                kind = "unfold-crease" if places else "unfold-newest"
                return self._joined(marks, filled(self.words[kind], **self._places(places)))
            case SaidFold():
                return self._fold(said)
            case SaidMarks(marks=marks):
                return self._joined(marks, "" if marks else self.words["nothing"])

    def check(self, corners: int) -> str:
        """What to look at afterwards."""
        return filled(self.words["check"], corners=str(corners))

    def finished(self, name: str) -> str:
        """What stands under the last drawing."""
        return filled(self.words["finished"], name=name)

    def _joined(self, marks: Sequence[MarkedPoint], *rest: str) -> str:
        return self.together(*(self._mark(mark) for mark in marks), *rest)

    def together(self, *sentences: str) -> str:
        """Sentences one after the other."""
        return str(self.words["between"]).join(filter(None, sentences))

    def _fold(self, said: SaidFold) -> str:
        template = self.words["folds"][f"{said.axiom}-flap" if said.flap else str(said.axiom)]
        values = self._places(said.places) | {
            f"line{i}": self.line(key) for i, key in enumerate(said.lines, 1)
        }
        if said.flap:
            values["flap"] = self.place(said.flap)
        elif said.side:
            values["side"] = self.words["sides"][said.side]
        text = filled(template, **values)
        if said.behind:
            text = filled(self.words["behind"], fold=text)
        text = filled(self.words["layers"][_how_many(said)], fold=text, layers=str(said.layers))
        text = filled(self.words["axiom"], fold=text, axiom=str(said.axiom))
        then = self.words["unfold"] if said.unfold else self.words["repeat"] if said.repeat else ""
        return self._joined(said.marks, text, then)

    def _places(self, keys: Sequence[PlaceKey]) -> dict[str, Phrase]:
        return {f"place{i}": self.place(key) for i, key in enumerate(keys, 1)}

    def place(self, key: PlaceKey) -> Phrase:
        """The phrase of a place."""
        kind, _, rest = key.partition(".")
        template = self.words["places"][kind]
        if kind == "corner":
            return both(template, side=self.words["sides"][rest])
        if kind == "letter":
            return both(template, letter=rest)
        return both(template, line=self.line(rest)) if rest else both(template)

    def line(self, key: LineKey) -> Phrase:
        """The phrase of a line."""
        kind, _, rest = key.partition(".")
        if kind == "edge":
            return both(self.words["lines"]["edge"], side=self.words["sides"][rest])
        central = rest.startswith("centre-")
        template = self.words["lines"]["crease.centre" if central else "crease"]
        return both(template, slant=self.words["slants"][rest.removeprefix("centre-")])

    def _mark(self, mark: MarkedPoint) -> str:
        words = self.words["marks"]
        if isinstance(mark, OnLine):
            template = words["upright" if mark.upright else "line"]
            return filled(template, letter=mark.letter, line=self.line(mark.line), part=self.part(mark.part))
        if isinstance(mark, InBox):
            return filled(
                words["box"], letter=mark.letter, across=self.part(mark.across), up=self.part(mark.up)
            )
        return filled(words["sheet"], letter=mark.letter, x=self._plain(mark.x), y=self._plain(mark.y))

    def part(self, part: float) -> str:
        """A part of a length: as a fraction where it is one, else as a number, with a fraction that is near."""
        exact = _fraction(part, DENOMINATORS, SAID_EXACTLY)
        if exact:
            return exact
        near = _fraction(part, ROUGH_DENOMINATORS, ROUGHLY)
        number = self._plain(part)
        return filled(self.words["about"], fraction=near, number=number) if near else number

    def _plain(self, number: float) -> str:
        return f"{number:.12f}".rstrip("0").rstrip(".").replace(".", self.words["decimal"])


def _how_many(said: SaidFold) -> str:
    if said.of <= 1:
        return "single"
    if said.layers >= said.of:
        return "both" if said.layers == 2 else "all"
    return "one" if said.layers == 1 else "some"


def _fraction(part: float, denominators: Sequence[int], within: float) -> str | None:
    """The plainest proper fraction so near to a number."""
    for below in denominators:
        above = round(part * below)
        if 0 < above < below and abs(part - above / below) < within:
            return f"{above}/{below}"
    return None


def filled(template: str, **values: Phrase) -> str:
    """A template with its places filled: by the first form of a phrase, or where it has a star by the second."""

    def value(found: re.Match[str]) -> str:
        phrase = values[found[1]]
        return phrase if isinstance(phrase, str) else phrase[1 if found[2] else 0]

    return re.sub(r"\{(\w+)(\*?)\}", value, template)


def both(template: Phrase, **values: Phrase) -> Phrase:
    """Both forms of a phrase whose places are filled, each by the same form."""
    if isinstance(template, str):
        return filled(template, **values)
    first = {
        name: value if isinstance(value, str) else (value[0], value[1]) for name, value in values.items()
    }
    second = {
        name: value if isinstance(value, str) else (value[1], value[1]) for name, value in values.items()
    }
    return filled(template[0], **first), filled(template[1], **second)
