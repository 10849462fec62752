"""One model is reached through many providers: how much it thinks, what goes back to it and what is cached is the same."""

import asyncio
import itertools
import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from case_names import case_name
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from folding_client.models.litellm_model import LitellmModel
from folding_client.settings import Settings
from providers.anthropic import Anthropic
from providers.base import Provider, Says
from providers.bedrock import Bedrock
from providers.compatible import CompatibleGemini, OpenRouter, ThinkingAloud
from providers.gemini import Gemini
from providers.openai import OpenAI
from providers.responses import Responses
from test_agent_providers import LOOK_AGAIN, LOOK_TWICE, converse, keys, pictures_in

__all__ = ["keys"]
PATIENT: dict[str, Any] = {"timeout": 30}
ROUTES: list[tuple[type[Provider], str]] = [
    (Anthropic, "anthropic/claude-opus-4-7"),
    (Anthropic, "anthropic/claude-sonnet-4-5"),
    (Anthropic, "azure_ai/claude-opus-4-7"),
    (Bedrock, "bedrock/us.anthropic.claude-opus-4-7"),
    (Bedrock, "bedrock/us.anthropic.claude-sonnet-4-5-20250929-v1:0"),
    (OpenRouter, "openrouter/anthropic/claude-opus-4.7"),
    (OpenRouter, "openrouter/google/gemini-3.1-pro-preview"),
    (CompatibleGemini, "openai/gemini-3.1-pro-preview"),
    (ThinkingAloud, "moonshot/kimi-k3"),
    (Responses, "openai/gpt-5.4"),
    (Responses, "openai/gpt-5-pro"),
    (Responses, "azure/gpt-5.4"),
    (Anthropic, "vertex_ai/claude-opus-4-7"),
    (Gemini, "vertex_ai/gemini-3.1-pro-preview"),
]


class Tokens(BaseHTTPRequestHandler):
    """Google's server for tokens, which takes any assertion."""

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["content-length"]))
        data = json.dumps({"access_token": "planted", "expires_in": 3600, "token_type": "Bearer"}).encode()
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, *_: object) -> None:
        """Nothing."""


@pytest.fixture(scope="module")
def google_account(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A service account, with a local server that gives it tokens."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), Tokens)
    threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
    key = rsa.generate_private_key(65537, 2048)
    pem = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).decode()
    account = {
        "type": "service_account",
        "project_id": "planted",
        "private_key_id": "planted",
        "private_key": pem,
        "client_email": "folding@planted.iam.gserviceaccount.com",
        "token_uri": f"http://127.0.0.1:{server.server_address[1]}/token",
    }
    file = tmp_path_factory.mktemp("google") / "account.json"
    file.write_text(json.dumps(account))
    yield file
    server.shutdown()
    server.server_close()


@pytest.fixture(autouse=True)
def more_keys(monkeypatch: pytest.MonkeyPatch, google_account: Path) -> None:
    """Keys of the providers that serve others' models."""
    monkeypatch.setenv("GOOGLE_APPLICATION_CREDENTIALS", str(google_account))
    monkeypatch.setenv("VERTEXAI_PROJECT", "planted")
    monkeypatch.setenv("VERTEXAI_LOCATION", "us-east5")
    for name in ("OPENROUTER", "AZURE_AI", "AZURE", "MOONSHOT", "DEEPSEEK", "XAI"):
        monkeypatch.setenv(f"{name}_API_KEY", "planted-key-0123456789")
    monkeypatch.setenv("AWS_BEARER_TOKEN_BEDROCK", "planted-key-0123456789")
    monkeypatch.setenv("AWS_REGION_NAME", "us-east-1")
    monkeypatch.setenv("AZURE_API_VERSION", "2025-04-01-preview")


@pytest.mark.parametrize(("kind", "model"), ROUTES, ids=[model for _, model in ROUTES])
def test_a_conversation_goes_on_through_every_provider_with_all_that_its_replies_held(
    kind: type[Provider], model: str
) -> None:
    with kind(LOOK_TWICE, LOOK_AGAIN, Says("A corner was folded.")) as provider:
        said, _ = asyncio.run(converse(provider, model, 3, **PATIENT))
    assert said[2].text == "A corner was folded."
    assert said[0].thinking in ("What changed?", "")
    assert len(said[0].tool_calls) == 2


@pytest.mark.parametrize(
    ("kind", "model"), [route for route in ROUTES if "claude" in route[1]], ids=case_name
)
def test_claude_s_cache_is_asked_for_wherever_it_is_served(kind: type[Provider], model: str) -> None:
    with kind(LOOK_TWICE, Says("I see.")) as provider:
        asyncio.run(converse(provider, model, 2, **PATIENT))
    marks = [
        str(body).count("'cache_control'") + str(body).count("'cachePoint'") for body in provider.received
    ]
    assert marks == [2, 3]


def test_no_other_model_s_cache_is_asked_for() -> None:
    with OpenRouter(Says("I see.")) as provider:
        asyncio.run(converse(provider, "openrouter/google/gemini-3.1-pro-preview", 1, **PATIENT))
    assert "cache_control" not in str(provider.received)


def test_reasoning_items_are_returned_in_every_later_query() -> None:
    turns = [Says(calls=[("view_frame", {"frame": 1})], thinking=f"Thought {number}.") for number in range(4)]
    with Responses(*turns, Says("Done.")) as provider:
        asyncio.run(converse(provider, "openai/gpt-5.4", 5, **PATIENT))
    returned = [
        [item["id"] for item in body["input"] if item["type"] == "reasoning"] for body in provider.received
    ]
    assert returned == [[f"rs_{number}" for number in range(1, count + 1)] for count in range(5)]


THINKING = [
    (Gemini, "gemini/gemini-3.1-pro-preview", {0: "low", 1024: "low", 8192: "medium", 16000: "high"}),
    (Gemini, "gemini/gemini-3-flash-preview", {0: "minimal", 1024: "low", 8192: "medium", 16000: "high"}),
    (Gemini, "gemini/gemini-2.5-pro", {0: 128, 1024: 1024, 8192: 8192, 16000: 16000}),
    (Gemini, "gemini/gemini-2.5-flash", {0: 0, 1024: 1024, 8192: 8192, 30000: 24576}),
    (
        Anthropic,
        "anthropic/claude-opus-4-7",
        {0: None, 1024: "low", 8192: "medium", 16000: "high", 33000: "xhigh"},
    ),
    (
        Anthropic,
        "anthropic/claude-sonnet-4-6",
        {0: None, 1024: "low", 8192: "medium", 16000: "high", 33000: "high"},
    ),
    (Anthropic, "anthropic/claude-fable-5", {0: "low", 1024: "low", 8192: "medium"}),
    (Anthropic, "anthropic/claude-sonnet-4-5", {0: None, 1024: 1024, 8192: 8192, 16000: 16000}),
    (Anthropic, "azure_ai/claude-opus-4-7", {0: None, 1024: "low", 8192: "medium"}),
    (Bedrock, "bedrock/us.anthropic.claude-opus-4-7", {0: None, 1024: "low", 8192: "medium"}),
    (Bedrock, "bedrock/us.anthropic.claude-sonnet-4-5-20250929-v1:0", {0: None, 1024: 1024, 8192: 8192}),
    (Anthropic, "vertex_ai/claude-opus-4-7", {0: None, 8192: "medium"}),
    (Gemini, "vertex_ai/gemini-3.1-pro-preview", {1024: "low", 16000: "high"}),
    (OpenAI, "openai/o3", {0: "low", 1024: "low", 8192: "medium", 16000: "high", 33000: "high"}),
    (OpenAI, "openai/gpt-5", {0: "minimal", 1024: "low", 8192: "medium", 16000: "high", 33000: "high"}),
    (OpenAI, "openai/gpt-5.2", {0: "none", 1024: "low", 8192: "medium", 33000: "xhigh"}),
    (Responses, "openai/gpt-5.4", {1024: "low", 8192: "medium", 33000: "xhigh"}),
    (Responses, "openai/gpt-5-pro", {0: "high", 1024: "high", 8192: "high"}),
    (OpenRouter, "openrouter/anthropic/claude-opus-4.7", {0: "none", 1024: "low", 8192: "medium"}),
    (OpenRouter, "openrouter/anthropic/claude-sonnet-4.5", {0: "none", 1024: 1024, 8192: 8192}),
    (OpenRouter, "openrouter/google/gemini-3.1-pro-preview", {0: "low", 1024: "low", 16000: "high"}),
    (OpenRouter, "openrouter/google/gemini-2.5-pro", {0: 128, 8192: 8192}),
    (CompatibleGemini, "openai/gemini-3.1-pro-preview", {0: "low", 1024: "low", 16000: "high"}),
    (OpenAI, "openai/gpt-4o", {0: None, 8192: None}),
    (OpenAI, "openai/a-model-of-my-own", {0: None, 8192: None}),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "model", "budget", "wanted"),
    [(kind, model, *pair) for kind, model, pairs in THINKING for pair in pairs.items()],
    ids=[f"{model} {budget}" for _, model, pairs in THINKING for budget in pairs],
)
def test_a_budget_arrives_as_the_model_s_family_takes_it(
    kind: type[Provider], model: str, budget: int, wanted: str | int | None
) -> None:
    with kind(Says("I see.")) as provider:
        asyncio.run(converse(provider, model, 1, **PATIENT, thinking_budget=budget, max_tokens=64000))
    assert thinking_in(provider.received[0]) == wanted


def thinking_in(body: dict[str, Any]) -> str | int | None:
    """The level or the budget that a request asks for, None if it asks for no thinking."""
    body = {**body, **body.get("additionalModelRequestFields", {})}
    config = body.get("generationConfig", {}).get("thinkingConfig", {})
    reasoning = body.get("reasoning", {})
    found = [
        config.get("thinkingLevel"),
        config.get("thinkingBudget"),
        body.get("output_config", {}).get("effort"),
        body.get("thinking", {}).get("budget_tokens"),
        body.get("reasoning_effort"),
        reasoning.get("effort"),
        reasoning.get("max_tokens"),
    ]
    stated = [each for each in found if each is not None]
    assert len(stated) <= 1, f"asked for {stated}"
    return stated[0] if stated else None


@pytest.mark.parametrize(
    ("model", "budgets"), [(model, pairs) for _, model, pairs in THINKING], ids=[each[1] for each in THINKING]
)
def test_more_budget_never_means_less_thinking(model: str, budgets: dict[int, Any]) -> None:
    order = ("none", "minimal", "low", "medium", "high", "xhigh")
    asked = [order.index(each) if isinstance(each, str) else each or 0 for _, each in sorted(budgets.items())]
    assert all(less <= more for less, more in itertools.pairwise(asked)), model


@pytest.mark.parametrize(
    ("model", "wanted", "asked"),
    [
        ("openai/gpt-4o", None, 16384),
        ("openai/gpt-4o", 4000, 4000),
        ("openai/gpt-4-turbo", None, 4096),
        ("openai/gpt-3.5-turbo-16k", None, 4096),
        ("openai/a-model-of-my-own", None, 32768),
        ("anthropic/claude-opus-4-7", None, 32768),
    ],
)
def test_a_reply_may_be_as_long_as_the_model_s_entry_says(model: str, wanted: int | None, asked: int) -> None:
    given = {} if wanted is None else {"max_tokens": wanted}
    partner = LitellmModel(f"litellm/{model}", Settings(**given), lambda *_: None)
    assert partner.sent["max_tokens"] == asked


def test_thinking_leaves_room_for_the_answer() -> None:
    partner = LitellmModel("litellm/anthropic/claude-sonnet-4-5", Settings(max_tokens=4096), lambda *_: None)
    assert partner.sent["thinking"]["budget_tokens"] == 2048


@pytest.mark.parametrize("model", ["gemini/gemini-3.1-pro-preview", "openai/gpt-4o"])
def test_pictures_arrive(model: str) -> None:
    kind = Gemini if "gemini" in model else OpenAI
    with kind(LOOK_TWICE, Says("I see.")) as provider:
        asyncio.run(converse(provider, model, 2, **PATIENT))
    assert pictures_in(provider.received[1]) == 2
