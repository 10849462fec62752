"""The options that commands share, each described once."""

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from folding_schemas.version_option import version_option

from folding_client.logs import LogLevel, show_logs


def path(text: str) -> Path:
    """A path as given, where ``~`` is the user's own folder although no shell has seen it."""
    if not text:
        message = "the path is empty; give one, or . for the folder you are in"
        raise typer.BadParameter(message)
    try:
        return Path(text).expanduser()
    except RuntimeError as error:
        message = f"{text!r} begins with a user who has no folder here; give the whole path"
        raise typer.BadParameter(message) from error


def _set_level(level: LogLevel | None) -> None:
    if level is not None:
        show_logs(level)


LogLevelOption = Annotated[
    LogLevel | None,
    typer.Option(
        "--log-level",
        envvar="FOLDINGAGENT_LOG_LEVEL",
        callback=_set_level,
        help="Show log messages from this level on, on stderr.",
    ),
]
VersionOption = Annotated[bool, version_option("foldingagent")]
_BY_NAME = inspect.Parameter.KEYWORD_ONLY
SETTINGS: Mapping[str, Any] = {
    "model": Annotated[
        str | None,
        typer.Option(
            help="geometric, litellm/PROVIDER/MODEL, hybrid:PROVIDER/MODEL, random, search or scripted:FILE."
        ),
    ],
    "critic": Annotated[str | None, typer.Option(help="Model of the critic; the agent's if left out.")],
    "overview": Annotated[str | None, typer.Option(help="Model of the overview critic.")],
    "selector": Annotated[str | None, typer.Option(help="Model of the selector.")],
    "variant": Annotated[str | None, typer.Option(help="agent, vlm-cp, vlm-s or vlm-s-c.")],
    "few_shot": Annotated[bool | None, typer.Option("--few-shot", help="Show the model solved examples.")],
    "seed": Annotated[
        int | None,
        typer.Option(
            help="Of what is drawn: actions of the model random, states shown to a critic; 0 if left out."
        ),
    ],
    "search_depth": Annotated[
        int | None, typer.Option(help="Moves in a row that the model search tries at a frame; 2 if left out.")
    ],
    "search_width": Annotated[
        int | None, typer.Option(help="States of each depth that it goes on from; 4 if left out.")
    ],
    "search_tries": Annotated[
        int | None, typer.Option(help="Moves that it tries at a frame; 300 if left out.")
    ],
    "search_time": Annotated[
        str | None, typer.Option(metavar="TIME", help="Most time that it takes for a frame, such as 90s.")
    ],
    "attempts": Annotated[int | None, typer.Option(help="Attempts for each frame; 5 if left out.")],
    "max_queries": Annotated[int | None, typer.Option(help="Most queries of the agent for a sequence.")],
    "max_cost": Annotated[
        float | None, typer.Option(help="Most US dollars for a sequence, over all roles; then the run stops.")
    ],
    "max_tokens_total": Annotated[
        int | None, typer.Option(help="Most tokens for a sequence, sent and received, over all roles.")
    ],
    "max_time": Annotated[
        str | None, typer.Option(metavar="TIME", help="Most time for a sequence, such as 90s, 15m or 2h.")
    ],
    "prices": Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Prices of models that are not on litellm's list: TOML, YAML or JSON."
        ),
    ],
    "thinking_budget": Annotated[int | None, typer.Option(help="Thinking tokens for one query.")],
    "max_tokens": Annotated[int | None, typer.Option(help="Most tokens of one reply, thinking included.")],
    "timeout": Annotated[float | None, typer.Option(help="Seconds to wait for one reply.")],
    "retries": Annotated[int | None, typer.Option(min=0, help="How often a query that fails is sent again.")],
    "max_wait": Annotated[
        float | None, typer.Option(help="Longest wait for the provider, in seconds; beyond it the run stops.")
    ],
    "tools": Annotated[str | None, typer.Option(help="Tools to offer: paper, standard or all.")],
    "keep_images": Annotated[
        bool | None, typer.Option("--keep-images", help="Send images again that were shown before.")
    ],
    "keep_results": Annotated[
        bool | None, typer.Option("--keep-results", help="Send old states again, and answers in full.")
    ],
    "full_descriptions": Annotated[
        bool | None, typer.Option("--full-descriptions", help="Describe tools in full.")
    ],
    "api_base": Annotated[str | None, typer.Option(help="Address of the model's provider.")],
    "server_url": Annotated[str | None, typer.Option(help="A running folding server, instead of one's own.")],
}
"""The settings that can be given on the command line, with the option of each."""
Given = Mapping[str, Any]
"""The settings that were given, by name."""
Config = Annotated[
    Path | None,
    typer.Option(
        parser=path, metavar="FILE", help="Settings in a TOML, YAML or JSON file; options win over it."
    ),
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Print all that models say and call.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress.")]
DryRunOption = Annotated[
    bool,
    typer.Option("--dry-run", help="Show the first request, its tokens and its price, and send nothing."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
SequenceFolder = Annotated[
    Path | None,
    typer.Argument(parser=path, help="Folder of a sequence, with its keyframes.json, or a video."),
]
Out = Annotated[Path | None, typer.Option(parser=path, help="Run folder; runs/NAME-TIME if left out.")]
Resume = Annotated[Path | None, typer.Option(parser=path, help="Run folder to go on with.")]

Models = Annotated[
    list[str] | None,
    typer.Option("--models", help="A model to compare; once for each. Its runs have a folder of their own."),
]
Variants = Annotated[
    list[str] | None, typer.Option("--variants", help="A variant to compare; once for each.")
]
Seeds = Annotated[
    list[int] | None, typer.Option("--seeds", help="A seed for runs of their own; once for each.")
]
Jobs = Annotated[int | None, typer.Option(min=1, help="Runs at a time; 1 if left out.")]
Tries = Annotated[
    int | None, typer.Option(min=1, help="How often a run that fails is tried in this batch; 1 if left out.")
]
MaxBatchCost = Annotated[
    float | None,
    typer.Option(help="Most US dollars for all runs of the batch together; then all stop."),
]
Dask = Annotated[str | None, typer.Option(help="Address of a Dask scheduler whose workers do it.")]
ShardOption = Annotated[
    str | None,
    typer.Option("--shard", metavar="I/N", help="Only the I-th of N parts of the corpus, by name."),
]


def with_settings(command: Callable[..., None]) -> Callable[..., None]:
    """A command with an option for each of SETTINGS in the place of its parameter ``given``, which gets those
    that were given.
    """
    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        parameters += _options() if parameter.name == "given" else [parameter.replace(kind=_BY_NAME)]

    def _gathered(**values: Any) -> None:  # noqa: ANN401 - whatever the command line holds
        given = {name: values.pop(name) for name in SETTINGS}
        command(**values, given={name: value for name, value in given.items() if value is not None})

    _gathered.__doc__ = command.__doc__
    _gathered.__name__ = command.__name__
    _gathered.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    _gathered.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return _gathered


def _options() -> list[inspect.Parameter]:
    return [
        inspect.Parameter(name, _BY_NAME, default=None, annotation=option)
        for name, option in SETTINGS.items()
    ]
