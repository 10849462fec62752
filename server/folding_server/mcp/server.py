"""The MCP server: tools, resources and prompts around one desk; here errors become answers."""

from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from importlib.metadata import version
from typing import Any

from folding_prompts import prompt
from mcp.server.auth.provider import TokenVerifier
from mcp.server.lowlevel.helper_types import ReadResourceContents
from mcp.server.mcpserver import Context, MCPServer
from mcp.server.mcpserver.exceptions import (
    ResourceError,
    ResourceNotFoundError,
    ToolError,
    UnexpectedToolError,
)
from mcp.server.mcpserver.tools import Tool
from mcp.shared.exceptions import MCPError
from mcp.types import INVALID_PARAMS, CallToolResult, GetPromptResult, InputRequiredResult
from pydantic import AnyUrl, ValidationError

from folding_server.errors import FoldingError
from folding_server.mcp import catalogue, errors, prompts, resources
from folding_server.mcp.auth import auth_settings
from folding_server.mcp.context import AppContext
from folding_server.mcp.stdio import answering_stdio
from folding_server.mcp.tools.apps import model_app


class FoldingServer(MCPServer[AppContext]):
    """An MCP server around one desk. What a caller can mend leaves it as one plain sentence.

    Over HTTP it answers only calls with one of ``tokens``, if there are any.
    """

    def __init__(self, app: AppContext, tokens: TokenVerifier | None = None) -> None:
        tools = catalogue.tools()
        self.catalogue: Mapping[str, Tool] = {tool.name: tool for tool in tools}
        super().__init__(
            "foldingagent",
            title="FoldingAgent",
            version=version("foldingagent-mcp"),
            instructions=prompt("server/instructions"),
            tools=tools,
            log_level="WARNING",
            lifespan=_serving(app),
            token_verifier=tokens,
            auth=auth_settings() if tokens else None,
            extensions=[model_app()],
        )
        resources.register(self, app)
        prompts.register(self, app)

    async def run_stdio_async(self) -> None:
        """Serve over stdio until the input ends and all that it asked is answered."""
        async with answering_stdio() as (incoming, outgoing):
            await self._lowlevel_server.run(
                incoming, outgoing, self._lowlevel_server.create_initialization_options()
            )

    async def call_tool(
        self, name: str, arguments: dict[str, Any], context: Context[AppContext, Any] | None = None
    ) -> CallToolResult | InputRequiredResult:
        """Call a tool. ToolError for an unknown tool, arguments it does not take, and whatever it refuses."""
        tool = self.catalogue.get(name)
        if tool is None:
            raise ToolError(errors.unknown_tool(name, self.catalogue))
        if refusal := errors.unknown_arguments(name, tool.parameters, arguments):
            raise ToolError(refusal)
        try:
            return await super().call_tool(name, arguments, context)
        except ToolError as error:
            cause = error.__cause__
            if isinstance(cause, FoldingError):
                raise ToolError(str(cause)) from cause
            if isinstance(cause, ValidationError) and not isinstance(error, UnexpectedToolError):
                raise ToolError(errors.bad_arguments(name, tool.parameters, arguments, cause)) from cause
            raise

    async def read_resource(
        self, uri: AnyUrl | str, context: Context[AppContext, Any] | None = None
    ) -> Iterable[ReadResourceContents] | InputRequiredResult:
        """Read a resource.

        ResourceNotFoundError with the reason where a run, sequence or frame is not there.
        """
        try:
            return await super().read_resource(uri, context)
        except ResourceError as error:
            cause = error.__cause__
            if isinstance(cause, FoldingError):
                raise ResourceNotFoundError(str(cause)) from cause
            if isinstance(cause, ValidationError):
                raise ResourceNotFoundError(errors.bad_address(str(uri), cause)) from cause
            raise

    async def get_prompt(
        self,
        name: str,
        arguments: dict[str, Any] | None = None,
        context: Context[AppContext, Any] | None = None,
    ) -> GetPromptResult | InputRequiredResult:
        """Get a prompt.

        MCPError (invalid params) for an unknown prompt or an argument that it does not take.
        """
        known = {each.name: each for each in await self.list_prompts()}
        if name not in known:
            raise MCPError(
                INVALID_PARAMS, f"There is no prompt {name!r}; the prompts are {', '.join(known)}."
            )
        taken = [argument.name for argument in known[name].arguments or ()]
        if stray := [given for given in arguments or () if given not in taken]:
            raise MCPError(
                INVALID_PARAMS, f"{name} takes no argument {stray[0]!r}; it takes {', '.join(taken)}."
            )
        return await super().get_prompt(name, arguments, context)


def _serving(app: AppContext) -> Callable[[MCPServer[AppContext]], AbstractAsyncContextManager[AppContext]]:
    """A lifespan that hands every call the one desk. Whoever made the desk closes it."""

    @asynccontextmanager
    async def lifespan(_server: MCPServer[AppContext]) -> AsyncIterator[AppContext]:
        """Hand over the desk."""
        yield app

    return lifespan
