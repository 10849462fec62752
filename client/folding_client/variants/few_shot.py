"""Solved transitions shown before the task (paper, section "Additional Ablation: In Context Examples").

The examples are data of the prompts package: three transitions of growing difficulty, each with the photo
before, the photo after, and the actions between.
"""

import json
from importlib.resources import files
from importlib.resources.abc import Traversable

from folding_prompts import prompt
from folding_schemas.actions import Action
from folding_schemas.state import FoldedState
from pydantic import BaseModel, ConfigDict, TypeAdapter

from folding_client.messages import Message, Picture, user
from folding_client.settings import Variant
from folding_client.variants.vlm_cp import PatternReply


class SolvedTransition(BaseModel):
    """One example: image files, the state before, the actions, and the crease patterns before and after."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    before: str
    after: str
    state: FoldedState
    actions: list[Action]
    pattern_before: PatternReply
    pattern_after: PatternReply


def solved_examples(variant: Variant) -> tuple[Message, ...]:
    """The examples as messages, in the words of a variant."""
    return tuple(_message(number, example, variant) for number, example in enumerate(_examples(), start=1))


def _message(number: int, example: SolvedTransition, variant: Variant) -> Message:
    if variant == "vlm-cp":
        given, answer = _json(example.pattern_before), _json(example.pattern_after)
    else:
        given = example.state.model_dump_json()
        answer = json.dumps(
            {"actions": [action.model_dump(mode="json", exclude_none=True) for action in example.actions]}
        )
    text = prompt("variants/example", number=number, given=given, answer=answer)
    return user(
        text,
        (
            _photo(example.before, f"example {number}, before"),
            _photo(example.after, f"example {number}, after"),
        ),
    )


def _json(pattern: PatternReply) -> str:
    return json.dumps(pattern.model_dump(mode="json"))


def _photo(name: str, subject: str) -> Picture:
    return Picture(_folder().joinpath(name).read_bytes(), "image/jpeg", subject)


def _examples() -> list[SolvedTransition]:
    text = _folder().joinpath("examples.json").read_text(encoding="utf-8")
    return TypeAdapter(list[SolvedTransition]).validate_json(text)


def _folder() -> Traversable:
    return files("folding_prompts").joinpath("few_shot")
