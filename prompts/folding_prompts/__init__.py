"""What is said to models, as prose: one Markdown file per tool description and per prompt, and this loader.

``tools/<tool>.md`` describes a tool. Every other file is a prompt, named by its path without the suffix, such
as ``server/reconstruct``. A prompt's placeholders are written ``$name`` or ``${name}``; a dollar sign is
``$$``.
"""

from importlib.resources import files
from string import Template

_ROOT = files(__name__)


def tool_description(name: str) -> str:
    """The description of a tool, as hosts show it to their model. KeyError if there is none."""
    return _text(f"tools/{name}")


def prompt(name: str, **values: object) -> str:
    """The prompt of a name with every placeholder filled in.

    KeyError if there is no such prompt, if a placeholder has no value or a value no placeholder: a prompt and
    its caller agree, or the mistake shows at once.
    """
    template = Template(_text(name))
    wanted = set(template.get_identifiers())
    if wanted != values.keys():
        message = f"prompt {name!r} takes {sorted(wanted)} and was given {sorted(values)}"
        raise KeyError(message)
    return template.substitute(values)


def _text(name: str) -> str:
    """The text of a Markdown file of this package, without the newline at its end."""
    file = _ROOT.joinpath(f"{name}.md")
    if not file.is_file():
        message = f"no prompt file {name}.md"
        raise KeyError(message)
    return file.read_text(encoding="utf-8").strip()
