"""Libraries for agents and models that take MCP tools: what they hand to their model."""

from collections.abc import Iterator
from typing import Any

from providers.base import Says
from providers.openai_responses import OpenAIResponses, outputs_of

from mcp_peers import versions
from mcp_peers.answers import CALLS, check_answers, first_object, said
from mcp_peers.checks import Check, Peer, Place, prefixed
from mcp_peers.clients import PROGRAMS, check_tools, told_by
from mcp_peers.environments import python_environment
from mcp_peers.our_server import stdio_command

LAST_WORDS = "The paper is folded."


def _langchain(place: Place) -> Iterator[Check]:
    """A session for all calls, and a call in a process of its own, which has no run that was opened last."""
    python = python_environment(
        place.cache, "langchain-mcp-adapters", f"langchain-mcp-adapters=={versions.LANGCHAIN_ADAPTERS}"
    )
    wanted = {"command": stdio_command(place.scratch / "data"), "calls": CALLS}
    told = told_by([python, PROGRAMS / "langchain_adapters.py"], wanted, place)
    yield check_tools(told["tools"])
    yield from check_answers(told["answers"])
    alone = told["alone"]
    refused = alone["is_error"] and "run_id" in said(alone) and "Traceback" not in said(alone)
    yield Check("in a new process, a call without run_id is refused with what to do", refused, said(alone))


def _google_genai(place: Place) -> Iterator[Check]:
    """Every tool as a declaration for Gemini."""
    python = python_environment(
        place.cache,
        "google-genai",
        f"google-genai=={versions.GOOGLE_GENAI}",
        f"mcp=={versions.PYTHON_SDK_2}",
    )
    told = told_by(
        [python, PROGRAMS / "google_genai.py"], {"command": stdio_command(place.scratch / "data")}, place
    )
    yield check_tools(told["tools"])
    declared = {each["name"]: each for each in told["declared"]}
    yield Check("mcp_to_gemini_tool takes every tool", list(declared) == told["tools"], str(list(declared)))
    fold = declared.get("fold", {}).get("parameters", {})
    kept = fold.get("properties", {}).get("edge", {}).get("items", {}).get("type") == "INTEGER"
    yield Check(
        "it keeps types and what is required",
        kept and set(fold["required"]) == {"edge", "direction"},
        str(fold),
    )


TAKING_ANY_OBJECT = {"try_program"}
"""Tools with an argument that may be any object, which strict schemas have no words for: they stay as they are."""


def _openai_agents(place: Place) -> Iterator[Check]:
    """An agent with plain and with strict schemas."""
    for strict in (False, True):
        yield from prefixed("strict" if strict else "plain", _agent(place, strict))


def _agent(place: Place, strict: bool) -> Iterator[Check]:
    """An agent whose model makes the calls. A tool without arguments stays as it is in strict mode: its object is open."""
    python = python_environment(place.cache, "openai-agents", f"openai-agents=={versions.OPENAI_AGENTS}")
    with OpenAIResponses(*[Says(calls=[call]) for call in CALLS], Says(LAST_WORDS)) as model:
        command = stdio_command(place.scratch / f"data-{strict}")
        given = {"command": command, "provider": model.url, "strict": strict}
        told = told_by([python, PROGRAMS / "openai_agents.py"], given, place)
    yield check_tools([tool["name"] for tool in model.received[0]["tools"]])
    tools = {tool["name"]: tool for tool in model.received[0]["tools"]}
    loose = {name for name, tool in tools.items() if not tool.get("strict")}
    without_arguments = {name for name, tool in tools.items() if not tool["parameters"]["properties"]}
    wanted = (without_arguments | TAKING_ANY_OBJECT) if strict else tools.keys()
    yield Check("tools with arguments are strict if they are to be", loose == wanted, str(sorted(loose)))
    yield from check_answers(received_answers(model))
    yield Check("the agent ends with the model's words", told["said"] == LAST_WORDS, str(told))


def received_answers(model: OpenAIResponses) -> list[dict[str, Any]]:
    """What a scripted model was told of its calls of CALLS, as answers."""
    parts_by_call = list(outputs_of(model.received[-1]).values())[-len(CALLS) :]
    return [_answer(tool, parts) for (tool, _), parts in zip(CALLS, parts_by_call, strict=False)]


def _answer(tool: str, parts: list[dict[str, Any]]) -> dict[str, Any]:
    """An answer as a model of OpenAI's gets it: its errors are texts like others."""
    texts = [part["text"] for part in parts if part["type"] == "input_text"]
    urls = [part["image_url"] for part in parts if part["type"] == "input_image"]
    images = [
        {"mime": url.partition(";")[0].removeprefix("data:"), "data": url.partition(",")[2]} for url in urls
    ]
    is_error = not first_object("\n".join(texts))
    return {"tool": tool, "is_error": is_error, "texts": texts, "images": images, "structured": None}


PEERS = (
    Peer(
        "openai-agents",
        versions.OPENAI_AGENTS,
        "an agent of the OpenAI Agents SDK with a scripted model",
        _openai_agents,
    ),
    Peer("langchain-mcp-adapters", versions.LANGCHAIN_ADAPTERS, "the tools as LangChain's", _langchain),
    Peer("google-genai", versions.GOOGLE_GENAI, "the tools as Gemini's", _google_genai),
)
