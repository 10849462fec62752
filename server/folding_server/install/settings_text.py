"""Putting an entry into the text of a host's configuration file, and leaving everything else in it as it is."""

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, NoReturn

import tomlkit

from folding_server.errors import FoldingError
from folding_server.install.entry import ENTRY_NAME, Entry, entry_for
from folding_server.install.hosts import Host

INDENT = "  "
"""The indentation of a file that has none yet."""


class SettingsRefused(FoldingError):
    """A configuration file that cannot be changed without breaking something; the message says why."""


def with_entry(text: str, host: Host, command: list[str]) -> str:
    """A configuration file's text with this server in it: the same text if it is there already.

    SettingsRefused if the text cannot be read, or would lose something.
    """
    read = read_toml if host.syntax == "toml" else read_json
    document = read(text)
    servers = document.get(host.section, {})
    existing = servers.get(ENTRY_NAME) if isinstance(servers, dict) else None
    if not isinstance(servers, dict) or not isinstance(existing, dict | None):
        raise SettingsRefused(f"its {host.section!r} is not the list of servers it should be")
    entry = entry_for(host, command, existing)
    if existing == entry:
        return text
    wanted = {**document, host.section: {**servers, ENTRY_NAME: entry}}
    texts = _toml_texts(text, host.section, entry) if host.syntax == "toml" else [_json_text(wanted, text)]
    for changed in texts:
        ended = re.sub(r"\r?\n", "\r\n", changed) if "\r\n" in text else changed
        if _says(ended, read, wanted):
            return ended
    raise SettingsRefused("writing it anew would lose something")


def _says(text: str, read: Callable[[str], dict[str, Any]], wanted: dict[str, Any]) -> bool:
    """Whether a text can be read and says what is wanted."""
    try:
        return read(text) == wanted
    except SettingsRefused:
        return False


def snippet(host: Host, command: list[str]) -> str:
    """The entry as a whole file of its own, to be pasted."""
    return with_entry("", host, command)


def read_json(text: str) -> dict[str, Any]:
    """The object in a JSON text, {} in an empty one. SettingsRefused if it is another value, or not plain JSON."""
    try:
        document = (
            json.loads(text, object_pairs_hook=_once, parse_constant=_no_constant) if text.strip() else {}
        )
    except ValueError as error:
        raise SettingsRefused(f"it is not plain JSON ({error}), perhaps because of comments") from error
    if not isinstance(document, dict):
        raise SettingsRefused("it does not hold a JSON object")
    return document


def read_toml(text: str) -> dict[str, Any]:
    """The table in a TOML text. SettingsRefused if it is none."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SettingsRefused(f"it is not TOML ({error})") from error


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object none of whose keys comes twice: one of the two would be lost."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = next(key for key, _ in pairs if [other for other, _ in pairs].count(key) > 1)
        raise ValueError(f"the key {twice!r} comes twice")
    return found


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")


def _json_text(document: dict[str, Any], before: str) -> str:
    """A JSON text, indented as the one before was."""
    found = re.search(r'\{\r?\n([ \t]+)"', before)
    text = json.dumps(document, ensure_ascii=False, indent=found[1] if found else INDENT)
    try:
        text.encode()
    except UnicodeEncodeError:  # half a character, which JSON can hold but a file in UTF-8 cannot
        text = json.dumps(document, indent=found[1] if found else INDENT)
    return text + "\n" if before.endswith("\n") or not before.strip() else text


def _toml_texts(text: str, section: str, entry: Entry) -> Iterator[str]:
    """TOML texts with another entry, whose comments and order stay: with a table of its own, then with one on a line.

    The second is for a list of servers that is itself on a line, or made of keys with dots.
    """
    for empty in (tomlkit.table, tomlkit.inline_table):
        with suppress(ValueError):  # a table cannot be put into one that is on a line
            yield _changed_toml(text, section, entry, empty())


def _changed_toml(text: str, section: str, entry: Entry, empty: Any) -> str:  # noqa: ANN401 - a table of either kind
    """A TOML text with another entry, new in an ``empty`` table."""
    document = tomlkit.parse(text)
    if section not in document:
        document.add(section, tomlkit.table(is_super_table=True))
    servers: Any = document[section]
    if ENTRY_NAME not in servers:
        servers[ENTRY_NAME] = empty
    for key, value in entry.items():
        if servers[ENTRY_NAME].get(key) != value:
            servers[ENTRY_NAME][key] = value
    for key in set(servers[ENTRY_NAME]) - set(entry):
        del servers[ENTRY_NAME][key]
    return tomlkit.dumps(document)
