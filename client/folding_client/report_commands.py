"""The command ``foldingagent report``."""

from pathlib import Path
from typing import Annotated

import typer

from folding_client import options
from folding_client.exits import finish
from folding_client.interrupts import UsageError

DEFAULT_SITE = Path("report")


_Runs = Annotated[
    list[Path],
    typer.Argument(parser=options.path, help="Run folders, or folders of them; each one named is a batch."),
]
_Out = Annotated[Path, typer.Option("--out", "-o", parser=options.path, help="Folder of the site.")]
_Evaluation = Annotated[
    Path | None,
    typer.Option(
        parser=options.path,
        metavar="FILE",
        help="Scores, as evaluate --json printed them; evaluation.json in a folder of runs if left out.",
    ),
]
_RecordedOnly = Annotated[
    bool, typer.Option("--recorded-only", help="Show what is on record, and start no folding server.")
]
_NoOverlays = Annotated[
    bool, typer.Option("--no-overlays", help="Have no photos compared whose comparison is not on record.")
]
_Watch = Annotated[
    bool, typer.Option("--watch", help="Serve the site on this machine and keep it up to date.")
]
_Port = Annotated[int, typer.Option(min=0, max=65535, help="Port for --watch; a free one if left out.")]


def report_command(
    runs: _Runs,
    out: _Out = DEFAULT_SITE,
    evaluation: _Evaluation = None,
    recorded_only: _RecordedOnly = False,
    no_overlays: _NoOverlays = False,
    watch: _Watch = False,
    port: _Port = 0,
) -> None:
    """Make a static site of recorded runs: an overview, and a page for each."""
    from folding_client.report.site import ReportOptions, SiteBuilder

    site_options = ReportOptions(evaluation, server=not recorded_only, overlays=not no_overlays, live=watch)
    if port and not watch:
        message = "--port is for --watch, which serves the site; leave it out, or add --watch."
        raise UsageError(message)
    builder = SiteBuilder(runs, out, site_options, _say)
    if watch:
        from folding_client.report.watching import watch_site

        finish(watch_site(builder, port, _say), f"the site as it is now is in {out}")
    else:
        finish(builder.build(), "the same command goes on from here")
        typer.echo(out / "index.html")


def _say(words: str) -> None:
    typer.echo(words, err=True)
