"""Messages of the protocol that no host should send, for ``benchmarks/fuzz.py``."""

import json
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from hostile_values import DEEP, DIGITS, LONG_NAME, TEXTS, arguments_for, hostile
from kept_connections import META

REQUEST_ID = "foldingagent/request-id"
PROGRESS = "progressToken"
_LISTS = ("tools/list", "resources/list", "resources/templates/list", "prompts/list")
_METHODS = (
    "initialize",
    "ping",
    "server/discover",
    "logging/setLevel",
    "resources/subscribe",
    "resources/unsubscribe",
    "completion/complete",
    "prompts/get",
    "resources/read",
    "tools/call",
    "sampling/createMessage",
    "roots/list",
    "tasks/get",
    "tasks/cancel",
    "rpc.discover",
    "",
    "../tools/list",
    "tools/call\0",
    "__init__",
)
_NOTIFICATIONS = (
    "notifications/cancelled",
    "notifications/progress",
    "notifications/initialized",
    "notifications/roots/list_changed",
    "notifications/nothing",
)
_PROMPTS = ("reconstruct", "judge_step", "find_mistake")


@dataclass(frozen=True)
class Subject:
    """What a message may speak of: the server's tools by name with their schemas, addresses, run ids of every sort."""

    tools: Mapping[str, Mapping[str, Any]]
    addresses: tuple[str, ...]
    run_ids: list[str]


@dataclass(frozen=True)
class Message:
    """A message: its kind for the report, its text, and what the headers have to repeat of it."""

    kind: str
    text: bytes
    method: str = ""
    name: str = ""


def hostile_message(rng: random.Random, subject: Subject, number: int, modern: bool) -> Message:
    """A message of any kind, with a number as its id; ``modern`` for the protocol that says everything with each request."""
    kinds = (
        _call,
        _call,
        _call,
        _call,
        _address,
        _odd_call,
        _prompt,
        _completion,
        _cursor,
        _method,
        _envelope,
        _text,
    )
    kind, method, parameters, envelope = rng.choice(kinds)(rng, subject)
    if isinstance(parameters, str):
        return Message(kind, parameters.encode(errors="surrogatepass"))
    if modern and isinstance(parameters, dict):
        parameters["_meta"] = {**META, **_meta(rng)}
    elif isinstance(parameters, dict) and rng.random() < 0.3:
        parameters["_meta"] = _meta(rng)
    message = {"jsonrpc": "2.0", "id": number, "method": method, "params": parameters, **envelope}
    text = json.dumps(message, ensure_ascii=rng.random() < 0.8).encode(errors="surrogatepass")
    named = parameters.get("name", parameters.get("uri", "")) if isinstance(parameters, dict) else ""
    return Message(kind, text, str(method), str(named))


_Draft = tuple[str, Any, Any, dict[str, Any]]
"""The kind, the method, the parameters (or the whole message as text) and what else the envelope says."""


def _call(rng: random.Random, subject: Subject) -> _Draft:
    name = rng.choice(list(subject.tools))
    arguments = arguments_for(rng, subject.tools[name], subject.run_ids)
    return "tool", "tools/call", {"name": name, "arguments": arguments}, {}


def _odd_call(rng: random.Random, subject: Subject) -> _Draft:
    name = rng.choice([hostile(rng), rng.choice(list(subject.tools)), rng.choice(TEXTS)])
    if rng.random() < 0.01:
        name = LONG_NAME
    return "odd call", "tools/call", {"name": name, "arguments": hostile(rng)}, {}


def _address(rng: random.Random, subject: Subject) -> _Draft:
    form = rng.choice(subject.addresses)
    run_id = rng.choice([*subject.run_ids, *map(str, TEXTS)])
    parts = {"run_id": run_id, "name": rng.choice([*TEXTS, "cat"])}
    parts |= {name: str(rng.choice([1, 2, 99, -1, 10**30, *TEXTS])) for name in ("frame", "vertex")}
    for name, part in parts.items():
        form = form.replace("{" + name + "}", part)
    uri = rng.choice([form, form, form + rng.choice(TEXTS), rng.choice(TEXTS), hostile(rng)])
    return (
        "resource",
        rng.choice(["resources/read", "resources/read", "resources/subscribe"]),
        {"uri": uri},
        {},
    )


def _prompt(rng: random.Random, _subject: Subject) -> _Draft:
    name = rng.choice([*_PROMPTS, *_PROMPTS, hostile(rng)])
    arguments = rng.choice(
        [{rng.choice(["sequence", "frame"]): hostile(rng)}, hostile(rng), {"frame": rng.choice(TEXTS)}]
    )
    return "prompt", "prompts/get", {"name": name, "arguments": arguments}, {}


def _completion(rng: random.Random, subject: Subject) -> _Draft:
    address, prompt = rng.choice(subject.addresses), rng.choice(_PROMPTS)
    ref = rng.choice(
        [{"type": "ref/resource", "uri": address}, {"type": "ref/prompt", "name": prompt}, hostile(rng)]
    )
    name = rng.choice(["run_id", "frame", "vertex", "sequence", "name", hostile(rng)])
    argument = rng.choice([{"name": name, "value": rng.choice([*TEXTS, hostile(rng)])}, hostile(rng)])
    chosen = {"run_id": rng.choice(subject.run_ids), rng.choice(TEXTS): rng.choice(TEXTS)}
    context = rng.choice([{"arguments": chosen}, {"arguments": hostile(rng)}, hostile(rng)])
    return "completion", "completion/complete", {"ref": ref, "argument": argument, "context": context}, {}


def _cursor(rng: random.Random, _subject: Subject) -> _Draft:
    return "cursor", rng.choice(_LISTS), {"cursor": rng.choice([hostile(rng), rng.choice(TEXTS)])}, {}


def _method(rng: random.Random, _subject: Subject) -> _Draft:
    method = rng.choice([*_METHODS, rng.choice(TEXTS), hostile(rng)])
    return "method", method, rng.choice([hostile(rng), {rng.choice(TEXTS): hostile(rng)}, {}]), {}


def _envelope(rng: random.Random, subject: Subject) -> _Draft:
    odd = rng.choice(
        [
            {"jsonrpc": hostile(rng)},
            {"id": hostile(rng)},
            {"params": hostile(rng)},
            {"method": hostile(rng)},
            {"result": hostile(rng)},
            {"error": hostile(rng)},
            {"id": 1},
        ]
    )
    _, method, parameters, _ = _call(rng, subject)
    return "envelope", method, parameters, odd


def _text(rng: random.Random, subject: Subject) -> _Draft:
    _, method, parameters, _ = _call(rng, subject)
    whole = json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": {**parameters, "_meta": META}})
    texts: list[Callable[[], str]] = [
        lambda: whole[: rng.randrange(len(whole))],
        lambda: whole + rng.choice(["}", "]", ",", whole, "\0", "//"]),
        lambda: f"[{whole}, {whole}]",
        lambda: "[]",
        lambda: whole.replace('"id": 1', f'"id": {"9" * DIGITS}'),
        lambda: "[" * DEEP + "]" * DEEP,
        lambda: '{"params":' * DEEP + "1" + "}" * DEEP,
        lambda: whole.replace(":", rng.choice(["=", ": NaN,", ": -Infinity //"]), 1),
        lambda: whole.replace('"', "'"),
        lambda: "\ufeff" + whole,
        lambda: whole[:50] + "\udcff" + whole[50:],
        lambda: rng.choice(TEXTS),
        lambda: json.dumps({"jsonrpc": "2.0", "method": rng.choice(_NOTIFICATIONS), "params": hostile(rng)}),
        lambda: json.dumps({"jsonrpc": "2.0", "id": hostile(rng), "result": hostile(rng)}),
    ]
    return "text", "", rng.choice(texts)(), {}


def _meta(rng: random.Random) -> dict[str, Any]:
    """What else a request may say of itself."""
    odd: dict[str, Any] = {}
    if rng.random() < 0.3:
        odd[REQUEST_ID] = rng.choice(
            [hostile(rng), "00000000-0000-4000-8000-000000000001", rng.choice(TEXTS)]
        )
    if rng.random() < 0.2:
        odd[PROGRESS] = hostile(rng)
    if rng.random() < 0.1:
        odd[rng.choice([*META, "io.modelcontextprotocol/logLevel", "traceparent"])] = hostile(rng)
    return odd
