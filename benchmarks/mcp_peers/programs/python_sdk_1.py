"""A client of the Python SDK 1: ``python python_sdk_1.py JSON`` makes the calls and prints what arrived as JSON."""

import asyncio
import json
import sys
from typing import Any

from mcp import ClientSession, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp.client.streamable_http import streamablehttp_client


def told(tool: str, result: Any) -> dict[str, Any]:
    """An answer as JSON."""
    return {
        "tool": tool,
        "is_error": bool(result.isError),
        "texts": [block.text for block in result.content if block.type == "text"],
        "images": [{"mime": b.mimeType, "data": b.data} for b in result.content if b.type == "image"],
        "structured": result.structuredContent,
    }


async def main() -> None:
    """List the tools, make the calls, print."""
    wanted = json.loads(sys.argv[1])
    if "url" in wanted:
        transport: Any = streamablehttp_client(wanted["url"])
    else:
        command, *arguments = wanted["command"]
        transport = stdio_client(StdioServerParameters(command=command, args=arguments))
    async with transport as (incoming, outgoing, *_), ClientSession(incoming, outgoing) as session:
        await session.initialize()
        listed = await session.list_tools()
        run: dict[str, Any] = {}
        answers = []
        for tool, arguments in wanted["calls"]:
            result = await session.call_tool(tool, {**arguments, **run})
            answers.append(told(tool, result))
            if tool == "open_run" and "url" in wanted:
                run = {"run_id": result.structuredContent["run_id"]}
    print(json.dumps({"tools": [tool.name for tool in listed.tools], "answers": answers}))


asyncio.run(main())
