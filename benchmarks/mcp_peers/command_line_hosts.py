"""Codex, Gemini CLI and opencode with scripted models: what their model is told of our answers.

Each finds the server in its own configuration, into which ``install`` entered it where it knows the host, calls what its
model asks for, and sends the model text, data and pictures of the answers.
"""

import json
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from providers.base import Body, Says, Turn
from providers.gemini_stream import GeminiStream, declared_functions
from providers.openai_responses import OpenAIResponses, declared_tools

from mcp_peers import versions
from mcp_peers.answers import CALLS, check_answers, said
from mcp_peers.checks import Check, Peer, Place
from mcp_peers.clients import check_tools
from mcp_peers.environments import node_environment, node_path
from mcp_peers.frameworks import LAST_WORDS, received_answers
from mcp_peers.our_server import enter, environment, finished, stdio_command

SECONDS = 180
"""How long a host may take for the whole conversation."""
START_SECONDS = 30
"""How long a host may take until it offers the server's tools: Codex starts servers beside its first turn."""
ASKED = "Fold the paper."
ADDED_BY_GEMINI = "wait_for_previous"
"""An argument that Gemini CLI adds to every tool, and that its model may give."""


class PatientResponses(OpenAIResponses):
    """A model of Codex's. Until our tools are offered it makes a plan instead of the script's next turn."""

    def next_turn(self, path: str, body: Body, headers: dict[str, str]) -> Turn:
        """The next turn, or a call of Codex's own that passes the time."""
        names = dict(declared_tools(body.get("tools", [])))
        waited = len(self.times) and time.monotonic() - self.times[0]
        if CALLS[0][0] in names or waited > START_SECONDS:
            return super().next_turn(path, body, headers)
        self.turns.insert(0, Says(calls=[("update_plan", {"plan": []})], meanwhile=_one_second))
        return super().next_turn(path, body, headers)


def _one_second() -> None:
    time.sleep(1)


def _codex(place: Place) -> Iterator[Check]:
    """``codex exec`` with a provider on a local port."""
    commands = node_environment(place.cache, "codex", {"@openai/codex": versions.CODEX})
    home = place.scratch / "home"
    file = home / ".codex" / "config.toml"
    with PatientResponses(*[Says(calls=[call]) for call in CALLS], Says(LAST_WORDS)) as model:
        file.parent.mkdir(parents=True)
        file.write_text(_codex_settings(model.url), encoding="utf-8")
        enter("codex", file, place.scratch / "data")
        env = environment(home, PATH=node_path(commands), CODEX_HOME=str(file.parent), LOCAL_KEY="none")
        words = ["exec", "--skip-git-repo-check", "--dangerously-bypass-approvals-and-sandbox", ASKED]
        done = finished([commands / "codex", *words], env, _empty(place), SECONDS)
    yield Check("codex exec ends well", done.returncode == 0, done.stderr)
    offered = dict(declared_tools(model.received[-1]["tools"]))
    yield check_tools([name for name, call in offered.items() if "folding" in json.dumps(call)])
    yield from check_answers(received_answers(model))


def _codex_settings(url: str) -> str:
    """Codex's configuration before our entry: a provider of its own, nothing that is sent elsewhere."""
    return f"""model = "gpt-5"
model_provider = "scripted"
check_for_update_on_startup = false

[analytics]
enabled = false

[model_providers.scripted]
name = "scripted"
base_url = "{url}"
wire_api = "responses"
env_key = "LOCAL_KEY"
request_max_retries = 0
stream_max_retries = 0
"""


GEMINI_SETTINGS: Mapping[str, Any] = {
    "security": {"auth": {"selectedType": "gemini-api-key"}, "folderTrust": {"enabled": False}},
    "privacy": {"usageStatisticsEnabled": False},
    "telemetry": {"enabled": False},
    "general": {"enableAutoUpdate": False, "enableAutoUpdateNotification": False},
}
"""Gemini CLI's settings before our entry: a key, nothing that is sent elsewhere."""


def _gemini(place: Place) -> Iterator[Check]:
    """``gemini`` without a terminal, with the API on a local port."""
    commands = node_environment(place.cache, "gemini-cli", {"@google/gemini-cli": versions.GEMINI_CLI})
    home = place.scratch / "home"
    file = home / ".gemini" / "settings.json"
    file.parent.mkdir(parents=True)
    file.write_text(json.dumps(GEMINI_SETTINGS), encoding="utf-8")
    enter("gemini-cli", file, place.scratch / "data")
    calls = [(tool, {**given, ADDED_BY_GEMINI: True}) for tool, given in CALLS]
    with GeminiStream(*[Says(calls=[call]) for call in calls], Says(LAST_WORDS)) as model:
        keys = {"GEMINI_API_KEY": "none", "GOOGLE_GEMINI_BASE_URL": model.url}
        env = environment(home, PATH=node_path(commands), GEMINI_CLI_TRUST_WORKSPACE="true", **keys)
        words = ["--model", "gemini-2.5-pro", "--approval-mode", "yolo", "--prompt", ASKED]
        done = finished([commands / "gemini", *words], env, _empty(place), SECONDS)
    yield Check("gemini ends well", done.returncode == 0 and LAST_WORDS in done.stdout, done.stderr)
    declared = dict(declared_functions(model.received[-1]))
    yield check_tools([name for name, called in declared.items() if called.startswith("mcp_folding")])
    answers = _gemini_answers(model.received[-1])
    yield from check_answers(answers)
    named = all(ADDED_BY_GEMINI in said(answer) for answer in answers)
    yield Check(
        "its own argument is ignored and named", named, str([said(answer)[:80] for answer in answers])
    )


def _gemini_answers(body: Body) -> list[dict[str, Any]]:
    """What a scripted model was told of its calls, as answers. Pictures come in the response or beside it."""
    answers: list[dict[str, Any]] = []
    for content in body["contents"]:
        responses = [part for part in content["parts"] if "functionResponse" in part]
        if not responses:
            continue
        inner = [part for each in responses for part in each["functionResponse"].get("parts", ())]
        blobs = [part["inlineData"] for part in [*content["parts"], *inner] if "inlineData" in part]
        told = responses[0]["functionResponse"]["response"]
        answers.append(
            {
                "tool": CALLS[len(answers)][0],
                "is_error": "error" in told,
                "texts": [str(told.get("output", told.get("error", "")))],
                "images": [{"mime": blob["mimeType"], "data": blob["data"]} for blob in blobs],
                "structured": None,
            }
        )
    return answers


class OpencodeResponses(OpenAIResponses):
    """A model of opencode's, which is also asked for a title of the conversation, without tools."""

    def next_turn(self, path: str, body: Body, headers: dict[str, str]) -> Turn:
        """The next turn of the conversation; a title where there are no tools."""
        return super().next_turn(path, body, headers) if body.get("tools") else Says("A title")


def _opencode(place: Place) -> Iterator[Check]:
    """``opencode run`` with OpenAI's API on a local port. It is no host of ``install``."""
    commands = node_environment(place.cache, "opencode", {"opencode-ai": versions.OPENCODE})
    project = _empty(place)
    with OpencodeResponses(*[Says(calls=[call]) for call in CALLS], Says(LAST_WORDS)) as model:
        server = {"type": "local", "command": stdio_command(place.scratch / "data"), "timeout": 60_000}
        settings = {
            "autoupdate": False,
            "share": "disabled",
            "provider": {"openai": {"options": {"baseURL": model.url, "apiKey": "none"}}},
            "mcp": {"folding": server},
        }
        (project / "opencode.json").write_text(json.dumps(settings), encoding="utf-8")
        quiet = dict.fromkeys(OPENCODE_QUIET, "1")
        env = environment(place.scratch / "home", PATH=node_path(commands), **quiet)
        done = finished(
            [commands / "opencode", "run", "--model", "openai/gpt-5", ASKED], env, project, SECONDS
        )
    yield Check("opencode run ends well", done.returncode == 0 and LAST_WORDS in done.stdout, done.stderr)
    offered = dict(declared_tools(model.received[-1]["tools"]))
    yield check_tools([name for name, call in offered.items() if call["name"].startswith("folding_")])
    yield from check_answers(received_answers(model))


OPENCODE_QUIET = (
    "OPENCODE_DISABLE_AUTOUPDATE",
    "OPENCODE_DISABLE_DEFAULT_PLUGINS",
    "OPENCODE_DISABLE_LSP_DOWNLOAD",
    "OPENCODE_DISABLE_MODELS_FETCH",
)
"""What keeps opencode from loading things from elsewhere."""


def _empty(place: Place) -> Path:
    """An empty folder to work in."""
    folder = place.scratch / "project"
    folder.mkdir()
    return folder


PEERS = (
    Peer("codex", versions.CODEX, "Codex CLI with a scripted model", _codex),
    Peer("opencode", versions.OPENCODE, "opencode with a scripted model", _opencode),
    Peer("gemini-cli", versions.GEMINI_CLI, "Gemini CLI with a scripted model", _gemini),
)
