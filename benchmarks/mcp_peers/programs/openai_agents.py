"""The OpenAI Agents SDK: ``python openai_agents.py JSON`` lets an agent run until its model calls no more tools.

The model is whatever answers at ``provider``; what the agent sent it is for that one to judge.
"""

import asyncio
import json
import sys

from agents import Agent, OpenAIResponsesModel, Runner, set_tracing_disabled
from agents.mcp import MCPServerStdio
from openai import AsyncOpenAI


async def main() -> None:
    """Run the agent and print its last words."""
    wanted = json.loads(sys.argv[1])
    command, *arguments = wanted["command"]
    set_tracing_disabled(disabled=True)
    async with MCPServerStdio(
        {"command": command, "args": arguments}, client_session_timeout_seconds=60
    ) as server:
        agent = Agent(
            name="folder",
            model=OpenAIResponsesModel("gpt-5", AsyncOpenAI(base_url=wanted["provider"], api_key="none")),
            mcp_servers=[server],
            mcp_config={"convert_schemas_to_strict": wanted["strict"]},
        )
        result = await Runner.run(agent, "Fold the paper.", max_turns=20)
    print(json.dumps({"said": result.final_output}))


asyncio.run(main())
