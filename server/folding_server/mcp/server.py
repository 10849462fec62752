"""The MCP server: tools, resources and prompts around one app context; here errors become answers."""

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
from mcp.types import (
    INVALID_PARAMS,
    CallToolResult,
    GetPromptResult,
    InputRequiredResult,
    LoggingLevel,
    TextContent,
)
from pydantic import AnyUrl, ValidationError

from folding_server.errors import FoldingError
from folding_server.mcp import catalogue, errors, icons, prompts, resources
from folding_server.mcp.arguments import known_arguments, unknown_arguments
from folding_server.mcp.auth import auth_settings
from folding_server.mcp.context import AppContext
from folding_server.mcp.results import readable
from folding_server.mcp.services.allowing import ALLOWING
from folding_server.mcp.services.run_addresses import SEQUENCE_LIST, changed_addresses
from folding_server.mcp.stdio import answering_stdio
from folding_server.mcp.subscriptions import ListenerBus, Subscriptions
from folding_server.mcp.tasks import PROMPT_SECONDS, CallTasks
from folding_server.mcp.tools.apps import model_app


class FoldingServer(MCPServer[AppContext]):
    """An MCP server around one app context. What a caller can mend leaves it as one plain sentence.

    Over HTTP it answers only calls with one of ``tokens``, if there are any. Long calls that have no answer after
    ``prompt_seconds`` are tasks for clients that have those.
    """

    def __init__(
        self, app: AppContext, tokens: TokenVerifier | None = None, prompt_seconds: float = PROMPT_SECONDS
    ) -> None:
        settings = app.settings
        tools = catalogue.tools(
            settings.tool_set,
            read_only=settings.read_only,
            reading_files=bool(settings.allowed),
            for_evaluation=settings.for_evaluation,
        )
        self._app = app
        bus = ListenerBus()
        self._hosts = Subscriptions(app, bus)
        self._tasks = CallTasks(catalogue.long_tools(), prompt_seconds)
        self.catalogue: Mapping[str, Tool] = {tool.name: tool for tool in tools}
        super().__init__(
            "foldingagent",
            title="FoldingAgent",
            version=version("foldingagent-mcp"),
            instructions=prompt("server/instructions"),
            icons=[icons.ACTION_ICON],
            tools=tools,
            log_level="WARNING",
            lifespan=_serving(app, self._tasks),
            token_verifier=tokens,
            auth=auth_settings() if tokens else None,
            extensions=[model_app(), self._tasks],
            subscriptions=bus,
        )
        self._hosts.register(self._lowlevel_server)
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
        """Call a tool. ToolError for an unknown tool and whatever it refuses. Arguments it does not know are ignored."""
        tool = self.catalogue.get(name)
        if tool is None:
            raise ToolError(self._not_offered(name))
        given = known_arguments(tool.parameters, arguments)
        stray = unknown_arguments(tool.parameters, arguments)
        note = errors.ignored_arguments(name, tool.parameters, stray) if stray else ""
        try:
            answer = await super().call_tool(name, given, context)
        except ToolError as error:
            refused = self._refusal(tool, given, error)
            await self._log(context, "warning" if refused else "error", f"{name}: {refused or error}")
            if refused is None:
                raise
            raise ToolError(f"{refused} {note}".rstrip()) from error.__cause__
        if isinstance(answer, CallToolResult):
            answer = readable(answer, note, context.protocol_version if context else None)
            await self._changed(tool, given, answer, context)
        return answer

    def _refusal(self, tool: Tool, given: Mapping[str, Any], error: ToolError) -> str | None:
        """A failed call as a sentence, if the caller can mend it; None for a fault of the server's own."""
        cause = error.__cause__
        if isinstance(cause, FoldingError):
            return errors.sentence(self._app.told(cause))
        if isinstance(cause, ValidationError) and not isinstance(error, UnexpectedToolError):
            return errors.sentence(errors.bad_arguments(tool.name, tool.parameters, given, cause))
        return None

    def _not_offered(self, name: str) -> str:
        """Why a tool is not there."""
        if name in ("add_sequence", "remove_sequence") and not self._app.settings.read_only:
            return ALLOWING
        return errors.unknown_tool(name, self.catalogue)

    async def _changed(
        self,
        tool: Tool,
        given: Mapping[str, Any],
        answer: CallToolResult,
        context: Context[AppContext, Any] | None,
    ) -> None:
        """Tell hosts what a call came to, and those that watch the run that it has changed."""
        if context is None or (tool.annotations and tool.annotations.read_only_hint):
            return
        first = answer.content[0]
        await self._log(
            context, "info", f"{tool.name}: {first.text if isinstance(first, TextContent) else ''}"
        )
        if not self._hosts.heard:
            return
        if "run_id" not in tool.parameters["properties"]:
            await self._hosts.changed(context, [SEQUENCE_LIST])
            return
        told = answer.structured_content or {}
        run_id = told.get("run_id") or given.get("run_id") or self._app.newest
        frames = [told["frame"]] if "frame" in given else []
        await self._hosts.changed(context, changed_addresses(str(run_id), frames))

    async def _log(self, context: Context[AppContext, Any] | None, level: LoggingLevel, text: str) -> None:
        """Send the caller a log message, if it wants such."""
        if context is not None:
            await self._hosts.log(context.request_context, level, text)

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
                raise ResourceNotFoundError(errors.sentence(self._app.told(cause))) from cause
            if isinstance(cause, ValidationError):
                raise ResourceNotFoundError(errors.bad_address(str(uri), cause)) from cause
            if isinstance(error, ResourceNotFoundError):
                raise ResourceNotFoundError(errors.unknown_address(str(uri))) from error
            raise

    async def get_prompt(
        self,
        name: str,
        arguments: dict[str, Any] | None = None,
        context: Context[AppContext, Any] | None = None,
    ) -> GetPromptResult | InputRequiredResult:
        """Get a prompt.

        MCPError (invalid params) for an unknown prompt, an argument that it does not take, and a sequence that is not there.
        """
        known = {each.name: each for each in await self.list_prompts()}
        if name not in known:
            raise MCPError(INVALID_PARAMS, errors.unknown_prompt(name, known))
        taken = [argument.name for argument in known[name].arguments or ()]
        if stray := [given for given in arguments or () if given not in taken]:
            raise MCPError(INVALID_PARAMS, errors.unknown_prompt_argument(name, stray[0], taken))
        try:
            return await super().get_prompt(name, arguments, context)
        except ValueError as error:
            if (cause := _mistake_behind(error)) is not None:
                raise MCPError(INVALID_PARAMS, errors.sentence(self._app.told(cause))) from error
            raise


def _mistake_behind(error: BaseException) -> FoldingError | None:
    """The caller's mistake that an error of the SDK's was raised for, however often it was wrapped."""
    cause = error.__cause__
    return cause if cause is None or isinstance(cause, FoldingError) else _mistake_behind(cause)


def _serving(
    app: AppContext, tasks: CallTasks
) -> Callable[[MCPServer[AppContext]], AbstractAsyncContextManager[AppContext]]:
    """A lifespan that hands every call the one app context, and lets tasks go on. Whoever made the context closes it."""

    @asynccontextmanager
    async def lifespan(_server: MCPServer[AppContext]) -> AsyncIterator[AppContext]:
        """Hand over the app context."""
        async with tasks.running():
            yield app

    return lifespan
