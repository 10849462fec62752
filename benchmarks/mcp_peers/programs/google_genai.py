"""google-genai: ``python google_genai.py JSON`` converts every tool for Gemini and prints what becomes of it as JSON."""

import asyncio
import importlib
import json
import sys

from mcp import Client, StdioServerParameters


async def main() -> None:
    """List the tools, convert each, print."""
    convert = importlib.import_module("google.genai._mcp_utils").mcp_to_gemini_tool
    command, *arguments = json.loads(sys.argv[1])["command"]
    async with Client(StdioServerParameters(command=command, args=arguments)) as client:
        listed = (await client.list_tools()).tools
    declared = [
        convert(tool).function_declarations[0].model_dump(mode="json", exclude_none=True) for tool in listed
    ]
    print(json.dumps({"tools": [tool.name for tool in listed], "declared": declared}))


asyncio.run(main())
