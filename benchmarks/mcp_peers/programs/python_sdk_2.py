"""A client of the Python SDK 2: ``python python_sdk_2.py JSON`` makes the calls and prints what arrived as JSON."""

import asyncio
import json
import sys
from typing import Any

from mcp import Client, StdioServerParameters


def told(tool: str, result: Any) -> dict[str, Any]:
    """An answer as JSON."""
    return {
        "tool": tool,
        "is_error": bool(result.is_error),
        "texts": [block.text for block in result.content if block.type == "text"],
        "images": [{"mime": b.mime_type, "data": b.data} for b in result.content if b.type == "image"],
        "structured": result.structured_content,
    }


async def main() -> None:
    """List the tools, make the calls, print."""
    wanted = json.loads(sys.argv[1])
    if "url" in wanted:
        target: Any = wanted["url"]
    else:
        command, *arguments = wanted["command"]
        target = StdioServerParameters(command=command, args=arguments)
    async with Client(target) as client:
        listed = await client.list_tools()
        run: dict[str, Any] = {}
        answers = []
        for tool, arguments in wanted["calls"]:
            result = await client.call_tool(tool, {**arguments, **run})
            answers.append(told(tool, result))
            if tool == "open_run" and "url" in wanted:
                run = {"run_id": result.structured_content["run_id"]}
    print(json.dumps({"tools": [tool.name for tool in listed.tools], "answers": answers}))


asyncio.run(main())
