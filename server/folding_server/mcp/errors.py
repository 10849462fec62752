"""What the protocol layer refuses, in one plain sentence: unknown tools, wrong values. Long values and names are cut."""

import json
from collections.abc import Iterable, Mapping, Sequence

from pydantic import ValidationError

from folding_server.mcp.schemas import Schema

_SHOWN = 80
"""How many characters of a bad value or name are repeated to the caller."""
_NAMED = 5
"""How many unknown arguments are named."""


def sentence(text: str) -> str:
    """A refusal as a sentence, whatever package of the server it comes from: with a capital and a full stop.

    A name in first place keeps its case: "Refused: photo.jpg is cut off."
    """
    text = text.strip()
    first = text.split(maxsplit=1)[0] if text else ""
    if first.rstrip(",:;").isalpha():
        text = text[0].upper() + text[1:]
    elif not first[:1].isupper():
        text = f"Refused: {text}"
    return text if text.endswith((".", "!", "?")) else f"{text}."


def unknown_tool(name: str, tools: Iterable[str]) -> str:
    """The answer to a call of a tool that does not exist."""
    return f"There is no tool {short_name(name)}; the tools are {', '.join(tools)}."


def ignored_arguments(tool: str, schema: Schema, names: Sequence[str]) -> str:
    """What an answer adds where a call had arguments that the tool does not know."""
    shown = ", ".join(map(short_name, names[:_NAMED]))
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    taken = ", ".join(schema.get("properties", {})) or "none"
    return f"Ignored: {shown}{more}; the arguments of {tool} are {taken}."


def bad_arguments(tool: str, schema: Schema, arguments: Mapping[str, object], error: ValidationError) -> str:
    """The answer to a call whose values do not fit: the first that is wrong, and what is allowed."""
    first = error.errors(include_url=False, include_context=False)[0]
    name = str(first["loc"][0]) if first["loc"] else ""
    allowed = _allowed(schema.get("properties", {}).get(name, {}), first["msg"])
    if name not in arguments:
        return f"The tool {tool} needs {name}: {allowed}."
    return f"The argument {name} {_shown(arguments[name])} is not possible: it must be {allowed}."


def _allowed(argument: Schema, otherwise: str) -> str:
    """What an argument may be, as its schema describes it, with the values of a list that the description does not name."""
    described: str = argument.get("description", otherwise)
    values = [str(value) for value in argument.get("enum", ())]
    unnamed = any(value not in described for value in values)
    return f"{described}, one of {', '.join(values)}" if unnamed else described


def unknown_address(uri: str) -> str:
    """The answer to a resource address of no known form."""
    return f"There is no resource {cut(uri)}; the lists of resources and resource templates have those there are."


def bad_address(uri: str, error: ValidationError) -> str:
    """The answer to a resource address with a part of the wrong kind."""
    first = error.errors(include_url=False, include_context=False)[0]
    part = ".".join(map(str, first["loc"]))
    return f"There is no resource {cut(uri)}: {part} {_shown(first['input'])} is not a whole number."


def unknown_prompt(name: str, prompts: Iterable[str]) -> str:
    """The answer to a request for a prompt that does not exist."""
    return f"There is no prompt {short_name(name)}; the prompts are {', '.join(prompts)}."


def unknown_prompt_argument(prompt: str, stray: str, taken: Sequence[str]) -> str:
    """The answer to a request for a prompt with an argument that it does not take."""
    takes = f"it takes {', '.join(taken)}" if taken else "it takes none"
    return f"The prompt {prompt} has no argument {short_name(stray)}; {takes}."


def short_name(name: str) -> str:
    """A name in quotes, cut where it gets long."""
    return repr(cut(name))


def cut(text: str) -> str:
    """A text, cut where it gets long."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _shown(value: object) -> str:
    """A bad value as JSON, cut where it gets long."""
    return cut(json.dumps(value, ensure_ascii=False))
