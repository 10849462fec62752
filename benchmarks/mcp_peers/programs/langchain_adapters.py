"""LangChain's MCP adapters: ``python langchain_adapters.py JSON`` makes the calls and prints what arrived as JSON.

``answers`` are those of one session; ``alone`` is what a call without ``run_id`` comes to in a process of its own.
"""

import asyncio
import json
import sys
from typing import Any

from langchain_core.tools import BaseTool
from langchain_mcp_adapters.client import MultiServerMCPClient
from langchain_mcp_adapters.tools import load_mcp_tools


async def answered(tool: BaseTool, arguments: dict[str, Any]) -> dict[str, Any]:
    """An answer as JSON."""
    call = {"name": tool.name, "args": arguments, "id": "call", "type": "tool_call"}
    try:
        message = await tool.ainvoke(call)
    except Exception as error:  # noqa: BLE001 - whatever an agent would be told
        return {"tool": tool.name, "is_error": True, "texts": [str(error)], "images": [], "structured": None}
    blocks = (
        message.content if isinstance(message.content, list) else [{"type": "text", "text": message.content}]
    )
    return {
        "tool": tool.name,
        "is_error": message.status == "error",
        "texts": [block["text"] for block in blocks if block["type"] == "text"],
        "images": [
            {"mime": block["mime_type"], "data": block["base64"]}
            for block in blocks
            if block["type"] == "image"
        ],
        "structured": (message.artifact or {}).get("structured_content") if message.artifact else None,
    }


async def main() -> None:
    """Load the tools, make the calls, print."""
    wanted = json.loads(sys.argv[1])
    command, *arguments = wanted["command"]
    client = MultiServerMCPClient({"folding": {"transport": "stdio", "command": command, "args": arguments}})
    async with client.session("folding") as session:
        tools = {tool.name: tool for tool in await load_mcp_tools(session)}
        answers = [await answered(tools[name], given) for name, given in wanted["calls"]]
    each_alone = {tool.name: tool for tool in await client.get_tools()}
    alone = await answered(each_alone["get_run"], {})
    print(json.dumps({"tools": list(tools), "answers": answers, "alone": alone}))


asyncio.run(main())
