"""The first request of a run, without sending it: what it says and shows, how many tokens it has, what they cost."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from folding_client.assembly import RoleModels, make_worker
from folding_client.interrupts import RunStopped
from folding_client.messages import Message, ToolSpec, Usage
from folding_client.models.chat_format import Dialect, chat_messages, chat_tools
from folding_client.models.prices import LITELLM, listed_price, read_prices
from folding_client.progress import Silent
from folding_client.reconstruct import about_run, new_job, opened_run, run_server
from folding_client.record.recorder import Recorder
from folding_client.settings import ROLES, WITHOUT_ASKING, Settings


@dataclass(frozen=True)
class RequestMessage:
    """One message of a request: what it says, and how many pictures it shows."""

    role: str
    text: str
    pictures: int


@dataclass(frozen=True)
class DryRun:
    """The first request that a run would send to a model; no messages if it would send none.

    ``input_tokens`` are counted with one tokeniser for all models, pictures by OpenAI's rule, so they are near what
    a provider counts, not the same; ``input_cost`` in US dollars. Both are None where they cannot be known.
    """

    model: str
    messages: list[RequestMessage]
    tools: list[str]
    input_tokens: int | None
    input_cost: float | None


class _Built(RunStopped):
    """The first request is known."""

    def __init__(self, messages: Sequence[Message], tools: Sequence[ToolSpec]) -> None:
        super().__init__("the first request is known")
        self.messages = messages
        self.tools = tools


class _NeverAsked:
    """A model that takes the first request, and ends the run with it."""

    def __init__(self, name: str) -> None:
        self.name = name

    async def query(self, messages: Sequence[Message], tools: Sequence[ToolSpec], **_: object) -> NoReturn:
        """No reply: the request ends the run."""
        raise _Built(messages, tools)


async def dry_run(sequence: Path, settings: Settings) -> DryRun:
    """The first request for a sequence. The server is asked as in a run; a hybrid's solver works up to the frame that it
    leaves to the model.
    """
    model = settings.role("agent")
    if model in WITHOUT_ASKING:
        return DryRun(model, [], [], 0, None)
    try:
        await _until_asked(sequence, settings)
    except _Built as built:
        return _described(model, built, settings)
    return DryRun(model, [], [], 0, None)


async def _until_asked(sequence: Path, settings: Settings) -> None:
    """Work on a run of its own in a temporary folder, until a model would be asked."""
    chosen = {role: settings.role(role) for role in ROLES}
    models = {role: None if spec == "geometric" else _NeverAsked(spec) for role, spec in chosen.items()}
    role_models = RoleModels(
        _NeverAsked(chosen["agent"]), models["critic"], models["overview"], models["selector"]
    )
    with tempfile.TemporaryDirectory() as home:
        job = new_job(sequence, Path(home) / "run", settings)
        recorder = Recorder(job.folder, about_run(job))
        try:
            async with run_server(job, recorder) as server:
                info = await opened_run(job, server, recorder)
                colors = info.front_color, info.back_color
                await make_worker(role_models, settings, server, recorder, Silent(), colors).run()
        finally:
            recorder.close()
            job.folder.release()


def _described(model: str, built: _Built, settings: Settings) -> DryRun:
    tokens = _tokens(built) if model.startswith(LITELLM) else None
    known = model.removeprefix(LITELLM)
    price = read_prices(settings.prices).get(known) or (listed_price(known) if tokens is not None else None)
    return DryRun(
        model,
        [RequestMessage(each.role, each.text, len(each.pictures)) for each in built.messages],
        [tool.name for tool in built.tools],
        tokens,
        None if tokens is None or price is None else price.cost(Usage(tokens)),
    )


def _tokens(built: _Built) -> int | None:
    """About how many tokens a request has; None without litellm, which counts them."""
    if find_spec("litellm") is None:
        return None
    from folding_client.models.litellm_model import litellm

    chat = chat_messages(built.messages, Dialect())
    tools = chat_tools(built.tools)
    return int(
        litellm().token_counter(messages=chat, tools=tools or None, use_default_image_token_count=True)
    )


def dry_run_lines(request: DryRun) -> Iterator[str]:
    """The request for people."""
    if not request.messages:
        yield f"{request.model} would send no request."
        return
    for message in request.messages:
        shown = f" and {message.pictures} pictures" if message.pictures else ""
        yield f"--- {message.role}{shown}"
        yield message.text
    yield f"--- {len(request.tools)} tools: {', '.join(request.tools)}"
    tokens = "tokens not known" if request.input_tokens is None else f"about {request.input_tokens:,} tokens"
    cost = "price not known" if request.input_cost is None else f"${request.input_cost:.4f} to send"
    yield f"{request.model}: {tokens}, {cost}. Nothing was sent."
