"""The options that commands share, each described once."""

from pathlib import Path
from typing import Annotated

import typer

ModelId = Annotated[
    str | None,
    typer.Option(help="geometric, litellm/PROVIDER/MODEL, hybrid:PROVIDER/MODEL or scripted:FILE."),
]
Critic = Annotated[str | None, typer.Option(help="Model of the critic; the agent's if left out.")]
Overview = Annotated[str | None, typer.Option(help="Model of the overview critic.")]
Selector = Annotated[str | None, typer.Option(help="Model of the selector.")]
VariantName = Annotated[str | None, typer.Option(help="agent, vlm-cp, vlm-s or vlm-s-c.")]
FewShot = Annotated[bool | None, typer.Option("--few-shot", help="Show the model solved examples.")]
MaxQueries = Annotated[int | None, typer.Option(help="Most queries of the agent for a sequence.")]
ThinkingBudget = Annotated[int | None, typer.Option(help="Thinking tokens for one query.")]
Tools = Annotated[str | None, typer.Option(help="Tools to offer: paper, standard or all.")]
KeepImages = Annotated[
    bool | None, typer.Option("--keep-images", help="Send images again although newer ones follow.")
]
KeepResults = Annotated[
    bool | None, typer.Option("--keep-results", help="Send old states again, and answers in full.")
]
FullDescriptions = Annotated[bool | None, typer.Option("--full-descriptions", help="Describe tools in full.")]
ApiBase = Annotated[str | None, typer.Option(help="Address of the model's provider.")]
ServerUrl = Annotated[str | None, typer.Option(help="A running folding server, instead of one's own.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
SequenceFolder = Annotated[Path | None, typer.Argument(help="Folder of a sequence, with its keyframes.json.")]
Out = Annotated[Path | None, typer.Option(help="Run folder; runs/NAME-TIME if left out.")]
Resume = Annotated[Path | None, typer.Option(help="Run folder to go on with.")]
