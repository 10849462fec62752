"""What a provider refuses is changed once and sent again: older pictures, long replies, tools, streams, parameters."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from case_names import case_name
from client_runs import HASTY, act, events, program, resume, run, save
from folding_client.interrupts import ContextExceeded, ProviderRefused, UsageError
from folding_client.messages import Reply, ToolResult, answered, system, tool_answer, user
from folding_client.models.litellm_model import LitellmModel
from folding_client.models.request_form import RequestForm
from folding_client.settings import Settings
from providers.anthropic import Anthropic
from providers.base import Fails, Provider, Says
from providers.bedrock import Bedrock
from providers.gemini import Gemini
from providers.openai import OpenAI
from test_agent_providers import keys, photo, pictures_in
from test_provider_errors import ASKED, TURN, Asked
from test_provider_families import google_account, more_keys

__all__ = ["google_account", "keys", "more_keys"]


def test_limits_only_get_lower_and_parameters_only_fewer() -> None:
    form = RequestForm().changed({"max_tokens": 4096, "without": "thinking"})
    again = form.changed({"max_tokens": 8192, "without": "response_format"})
    assert again.max_tokens == 4096
    assert again.without == {"thinking", "response_format"}
    assert again.changed({"filtered": True, "older_pictures": False}).kept() == again


def test_a_provider_that_contradicts_itself_is_not_asked_without_end() -> None:
    refusals = [Fails(400, f"This model supports at most {most} completion tokens.") for most in (4096, 8192)]
    with OpenAI(*refusals) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own")
    assert isinstance(asked.raised, ProviderRefused)
    assert "Give fewer --max-tokens" in str(asked.raised)


LONG = [
    *ASKED[:1],
    user("Look.", (photo(1), photo(2), photo(3))),
    answered(Reply("I see.")),
    user("And now?", (photo(4),)),
]
TOO_LONG = [
    (OpenAI, "openai/gpt-4o", Fails(400, "Your input is too long.", "context_length_exceeded")),
    (OpenAI, "openai/gpt-4o", Fails(400, "This model's maximum context length is 128000 tokens.")),
    (
        OpenAI,
        "openai/gpt-4o",
        Fails(429, "Request too large for gpt-4o on tokens per min (TPM): Limit 30000."),
    ),
    (OpenAI, "openai/gpt-4o", Fails(413, "Payload too large")),
    (
        Anthropic,
        "anthropic/claude-sonnet-4-5",
        Fails(400, "prompt is too long: 210000 tokens > 200000 maximum"),
    ),
    (
        Gemini,
        "gemini/gemini-3.1-pro-preview",
        Fails(400, "The input token count (12) exceeds the maximum number (9)."),
    ),
    (Bedrock, "bedrock/us.anthropic.claude-opus-4-7", Fails(400, "Input is too long for requested model.")),
]


@pytest.mark.parametrize(("kind", "model", "refusal"), TOO_LONG, ids=case_name)
def test_a_conversation_that_is_too_long_is_sent_once_more_without_its_older_pictures(
    kind: type[Provider], model: str, refusal: Fails
) -> None:
    with kind(Says("I see."), refusal, Says("A square.")) as provider:
        conversation = [*LONG[:2], answered(Asked(provider, model, LONG[:2]).reply), LONG[3]]
        asked = Asked(provider, model, conversation)
        sent = [len(json.dumps(body)) for body in provider.received]
    assert asked.reply.text == "A square."
    assert len(asked.notes) == 1
    assert sent[2] < sent[1]
    assert "Left out, for the model takes no more" in json.dumps(provider.received[2])


@pytest.mark.parametrize(("kind", "model", "refusal"), TOO_LONG[:1] + TOO_LONG[4:5], ids=case_name)
def test_a_conversation_that_is_too_long_all_the_same_is_told(
    kind: type[Provider], model: str, refusal: Fails
) -> None:
    with kind(Says("I see."), refusal, refusal) as provider:
        conversation = [*LONG[:2], answered(Asked(provider, model, LONG[:2]).reply), LONG[3]]
        asked = Asked(provider, model, conversation)
    assert isinstance(asked.raised, ContextExceeded)


def test_a_conversation_that_is_too_long_as_it_begins_is_not_sent_again() -> None:
    with OpenAI(TOO_LONG[0][2]) as provider:
        asked = Asked(provider, "openai/gpt-4o")
    assert isinstance(asked.raised, ProviderRefused)
    assert "a model of more context" in str(asked.raised)


def test_a_run_whose_steps_grow_too_long_is_stopped_after_the_second(tmp_path: Path) -> None:
    look = Says(calls=[("get_current_state", {})])
    with OpenAI(save(1), look, TOO_LONG[0][2], look, TOO_LONG[0][2]) as provider:
        stopped = run(2, tmp_path / "run", model="litellm/openai/gpt-4o", api_base=provider.url)
    assert stopped.status == "stopped"
    assert "twice in a row" in stopped.reason
    assert [event["cause"] for event in events(tmp_path / "run", "rolled_back")] == ["ContextExceeded"] * 2
    with OpenAI(act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[TURN]]


@pytest.mark.parametrize(
    ("refusal", "asked_for"),
    [
        (
            Fails(400, "max_tokens is too large: 32768. This model supports at most 4096 completion tokens."),
            4096,
        ),
        (Fails(400, "max_tokens: 32768 > 8192, which is the maximum allowed number of output tokens"), 8192),
        (Fails(400, "`max_tokens` must be less than or equal to `2048`, the maximum value"), 2048),
        (
            Fails(400, "This model's maximum context length is 16384 tokens. However, you requested 33968."),
            4096,
        ),
        (
            Fails(
                400,
                "'max_tokens' is too large: 32768. This model's maximum context length is 16384 tokens and your request "
                "has 1200 input tokens (32768 > 16384 - 1200).",
            ),
            4096,
        ),
    ],
    ids=case_name,
)
def test_a_model_of_short_replies_or_little_context_is_asked_for_less(refusal: Fails, asked_for: int) -> None:
    with OpenAI(refusal, Says("A square."), Says("Still a square.")) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own")
        asked.again(ASKED)
    assert asked.reply.text == "Still a square."
    assert [body["max_tokens"] for body in provider.received] == [32768, asked_for, asked_for]


@pytest.mark.parametrize(
    "refusal",
    [
        Fails(400, "This model does not support image input."),
        Fails(404, "No endpoints found that support image input"),
    ],
)
def test_a_model_without_pictures_is_told_in_one_sentence(refusal: Fails) -> None:
    with OpenAI(refusal) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own")
    assert isinstance(asked.raised, ProviderRefused)
    assert "takes no pictures" in str(asked.raised)
    assert "choose a model that takes images" in str(asked.raised)


@pytest.mark.parametrize("model", ["openai/o3-mini", "deepseek/deepseek-chat"])
def test_a_model_that_is_known_to_take_no_pictures_is_not_begun_with(tmp_path: Path, model: str) -> None:
    with pytest.raises(UsageError, match="takes no pictures"):
        run(2, tmp_path / "run", model=f"litellm/{model}")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("model", ["openai/o3-mini", "deepseek/deepseek-chat"])
def test_a_model_that_takes_no_pictures_can_be_an_agent_that_is_told_what_it_does_not_see(
    tmp_path: Path, model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DEEPSEEK_API_KEY", "sk-none")
    seeing = dict.fromkeys(("critic", "overview", "selector"), "geometric")
    turn = Says(calls=[("rotate", {"angle": 45.0})])
    with OpenAI(save(1), turn, save(2)) as provider:
        outcome = run(2, tmp_path / "run", model=f"litellm/{model}", api_base=provider.url, **seeing)
    assert outcome.status == "complete"
    assert "image_url" not in str(provider.received)
    assert "Not shown, for you take no pictures: photo of frame 1" in str(provider.received[1]["messages"])


@pytest.mark.parametrize(
    "words",
    [
        "At most 1 image(s) may be provided in one request.",
        "Only one image is supported.",
        "multiple images are not supported",
    ],
)
def test_a_model_of_one_picture_is_shown_the_newest(words: str) -> None:
    looked = [
        system("You fold."),
        user("Look.", (photo(1),)),
        answered(Reply("I see.")),
        user("And?", (photo(2),)),
    ]
    with OpenAI(Fails(400, words), Says("A fold."), Says("A square.")) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own", looked)
        asked.again([*looked, answered(asked.reply), user("And now?", (photo(3),))])
    assert asked.reply.text == "A square."
    assert [pictures_in(body) for body in provider.received] == [2, 1, 1]
    left_out = "(Left out, for the model takes no more: photo of frame {}.)"
    assert left_out.format(1) in provider.received[1]["messages"][1]["content"]
    assert left_out.format(2) in provider.received[2]["messages"][3]["content"]


def test_a_model_that_takes_too_few_of_the_pictures_that_belong_together_is_told() -> None:
    with OpenAI(Fails(400, "This model supports up to 3 images.")) as provider:
        four = [system("Compare."), user("Look.", tuple(map(photo, range(1, 5))))]
        asked = Asked(provider, "openai/a-model-of-my-own", four)
    assert isinstance(asked.raised, ProviderRefused)
    assert "no more than 3 of the 4 pictures that belong together" in str(asked.raised)
    assert "geometric for --critic" in str(asked.raised)


class OnlyStreams(OpenAI):
    """A model that answers in a stream or not at all."""

    streams = True

    def check(self, path: str, body: dict[str, Any]) -> None:
        if body.get("stream"):
            super().check(path, body)


def test_a_model_that_only_streams_is_streamed() -> None:
    refusal = Fails(400, "This model only support stream mode, please enable the stream parameter.")
    looks = Says("I look.", [("view_frame", {"frame": 1}), ("view_frame", {"frame": 2})])
    with OnlyStreams(refusal, looks, Says("A square.")) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own")
        called = asked.reply.tool_calls
        results = [tool_answer(call, ToolResult("Seen.", None, (photo(3),))) for call in called]
        asked.again([*ASKED, answered(asked.reply), *results])
    assert [(call.name, json.loads(call.arguments)) for call in called] == [
        ("view_frame", {"frame": 1}),
        ("view_frame", {"frame": 2}),
    ]
    assert asked.reply.text == "A square."
    assert asked.reply.usage.input_tokens == 1000


def test_a_server_without_tools_gets_them_as_text_and_its_calls_are_read() -> None:
    refusal = Fails(
        400, '"auto" tool choice requires --enable-auto-tool-choice and --tool-call-parser to be set'
    )
    call = 'I look. <tool_call>{"name": "view_frame", "arguments": {"frame": 2}}</tool_call>'
    with OpenAI(refusal, Says(call), Says("A square.")) as provider:
        asked = Asked(provider, "openai/a-model-of-my-own")
        (called,) = asked.reply.tool_calls
        result = tool_answer(called, ToolResult("Frame 2.", None, (photo(2),)))
        asked.again([*ASKED, answered(asked.reply), result])
    assert (called.name, json.loads(called.arguments)) == ("view_frame", {"frame": 2})
    assert "tools" not in provider.received[1]
    assert '"name": "view_frame"' in provider.received[1]["messages"][0]["content"]
    said, shown = provider.received[2]["messages"][-2:]
    assert said == {"role": "assistant", "content": call}
    assert shown["content"][0]["text"] == "Result of view_frame:\nFrame 2."
    assert pictures_in(shown) == 1


@pytest.mark.parametrize("name", ["response_format", "reasoning_effort"])
def test_a_parameter_that_a_provider_does_not_take_is_left_out(name: str) -> None:
    refusal = Fails(400, f"Unsupported parameter: '{name}' is not supported with this model.")
    with OpenAI(refusal, Says("{}")) as provider:
        settings = Settings(api_base=provider.url, retries=HASTY, timeout=30)
        partner = LitellmModel("litellm/openai/gpt-5", settings, lambda *_: None)
        asyncio.run(partner.query(ASKED, [], json_mode=True))
    assert [name in body for body in provider.received] == [True, False]
