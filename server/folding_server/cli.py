"""``foldingagent-server``: serve the protocol, or use a part of the server from the command line.

What a command needs is imported inside it, so that serving starts quickly.
"""

import json
import logging
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from folding_schemas.wrong_values import usage_sentence

from folding_server.animation.animate_command import animate
from folding_server.audit.audit_command import audit
from folding_server.command_options import (
    Allowed,
    Attempts,
    Data,
    Database,
    EveryStep,
    ForEvaluation,
    Http,
    Json,
    KnownAs,
    Limit,
    ModelSource,
    OutFolder,
    ProgramFile,
    ReadOnly,
    Sequences,
    ShowVersion,
    StepFiles,
    TokenFile,
    ToolsOffered,
    VisionQueue,
    VisionWorkers,
    file_to_write,
)
from folding_server.data_folder import folder_for_runs
from folding_server.derivation.derive_command import derive
from folding_server.errors import FoldingError
from folding_server.http_options import check_names, check_tokens_are_meant
from folding_server.install.command import install
from folding_server.instructions.instructions_command import instructions
from folding_server.instructions.practicality_command import practicality
from folding_server.pattern_commands import check, convert
from folding_server.progress_line import ProgressLine
from folding_server.store.limits import BUDGET
from folding_server.typed_path import require_folders, typed_path
from folding_server.typed_text import text_in
from folding_server.wording.refold_command import refold
from folding_server.workers.job_queue import WAITING

if TYPE_CHECKING:
    from folding_schemas.actions import Program
    from folding_schemas.results import ExportFormat

    from folding_server.mcp.context import AppContext
    from folding_server.simulator import Paper


app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="An MCP server that folds paper and compares it with photos; without a command, over stdio.",
)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line. Mistakes end in one line on stderr and a non-zero exit."""
    try:
        code = app(args=arguments, standalone_mode=False)
    except typer.TyperException as error:
        code = _complain(usage_sentence(error), error.exit_code)
    except FoldingError as error:
        code = _complain(str(error), 1)
    except (KeyboardInterrupt, typer.Abort):
        code = 130
    sys.exit(code if isinstance(code, int) else 0)


def _complain(message: str, code: int) -> int:
    """One line on stderr; the exit code that goes with it."""
    sys.stderr.write(f"foldingagent-server: {' '.join(message.split())}\n")
    return code


@app.callback(invoke_without_command=True)
def serve(
    context: typer.Context,
    http: Http = None,
    sequences: Sequences = None,
    allow: Allowed = None,
    data: Data = None,
    database: Database = None,
    known_as: KnownAs = None,
    token_file: TokenFile = None,
    tools: ToolsOffered = "all",
    read_only: ReadOnly = False,
    for_evaluation: ForEvaluation = False,
    attempts: Attempts = BUDGET,
    limit: Limit = None,
    vision_workers: VisionWorkers = None,
    vision_queue: VisionQueue = WAITING,
    _version: ShowVersion = False,
) -> None:
    """Serve the protocol over stdio, or over HTTP with --http."""
    if context.invoked_subcommand is not None:
        return
    from folding_server.mcp.context import AppContext, ServerSettings
    from folding_server.store.limits import parse_limits

    require_folders(sequences or ())
    require_folders(allow or (), "allow")
    check_tokens_are_meant(http, token_file, limit)
    check_names(http, known_as or ())
    logging.basicConfig(level="WARNING", format="%(levelname)s %(name)s: %(message)s")
    settings = ServerSettings(
        folder_for_runs(data, database),
        database,
        tuple(sequences or ()),
        tuple(each.resolve() for each in allow or ()),
        shared=http is not None,
        tool_set=tools,
        read_only=read_only,
        for_evaluation=for_evaluation,
        limits=parse_limits(limit or ()),
        vision_workers=_workers(vision_workers),
        vision_queue=vision_queue,
        attempts=attempts,
    )
    with AppContext(settings) as app:
        if http is None:
            _serve_stdio(app)
        else:
            _serve_http(app, http, known_as or (), token_file)


def _workers(given: int | None) -> int:
    """How many worker processes a server has."""
    from folding_server.workers.worker_pool import usual_workers

    return usual_workers() if given is None else given


def _serve_stdio(app: "AppContext") -> None:
    """Answer the host on stdin and stdout until it hangs up.

    An interrupt ends the process at once, even while it waits for input: what was answered is stored.
    """
    from folding_server.mcp.server import FoldingServer

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    FoldingServer(app).run("stdio")


def _serve_http(app: "AppContext", address: str, known_as: Sequence[str], token_file: Path | None) -> None:
    """Answer hosts over HTTP until interrupted."""
    from folding_server.mcp.auth import read_tokens
    from folding_server.mcp.http.address import parse_address
    from folding_server.mcp.http.serving import serve as serve_http

    tokens = read_tokens(token_file) if token_file else None
    serve_http(app, parse_address(address), known_as, tokens)


app.command()(install)
app.command()(instructions)
app.command()(animate)
app.command()(practicality)
app.command()(refold)
app.command()(check)
app.command()(convert)


@app.command()
def simulate(
    program: ProgramFile,
    state: Annotated[Path | None, file_to_write("the final state as JSON")] = None,
    fold: Annotated[Path | None, file_to_write("the final state as FOLD")] = None,
    cp: Annotated[
        Path | None, file_to_write("the crease pattern: as FOLD, or by the ending of FILE as .svg or .cp")
    ] = None,
    steps: Annotated[Path | None, file_to_write("all states as the frames of one FOLD file")] = None,
    obj: Annotated[Path | None, file_to_write("the folded sheet as a mesh, OBJ")] = None,
    svg: Annotated[Path | None, file_to_write("the diagram as SVG")] = None,
    png: Annotated[Path | None, file_to_write("the diagram as PNG")] = None,
    every_step: EveryStep = None,
    step_files: StepFiles = None,
    as_json: Json = False,
) -> None:
    """Run a folding program and write what it leads to."""
    from folding_server.interchange.pattern_files import pattern_text
    from folding_server.interchange.step_files import write_step_files
    from folding_server.simulate import simulate as run
    from folding_server.simulator import folded_state

    folding = _program(program)
    paper = run(folding, every_step, say=None if as_json else typer.echo)
    wanted: dict[ExportFormat, Path | None] = {
        "fold": fold,
        "steps": steps,
        "obj": obj,
        "svg": svg,
        "png": png,
    }
    written: dict[str, str] = {
        kind: _write(file, _exported(paper, kind, folding)) for kind, file in wanted.items() if file
    }
    if cp:
        written["crease-pattern"] = _write(cp, pattern_text(paper, cp.suffix, folding.name))
    if state:
        written["state"] = _write(state, folded_state(paper).model_dump_json(indent=1) + "\n")
    if every_step:
        written["every-step"] = str(every_step)
    if step_files:
        write_step_files(folding, step_files)
        written["step-files"] = str(step_files)
    if as_json:
        report = {"name": folding.name, "steps": len(folding.steps), "written": written}
        _print_json({**report, "state": folded_state(paper).model_dump(mode="json")})
    else:
        for file in written.values():
            typer.echo(f"wrote {file}")


@app.command()
def photograph(
    program: ProgramFile,
    out: OutFolder,
    seed: Annotated[int, typer.Option(metavar="N", help="The same seed gives the same photos.")] = 0,
    level: Annotated[
        int,
        typer.Option(
            metavar="L", help="1 plain, 2 uneven, 3 hands and textured tables, 4 a camera for each photo."
        ),
    ] = 1,
    between: Annotated[
        int, typer.Option(metavar="N", help="Images of the paper on its way after each keyframe.")
    ] = 0,
    as_json: Json = False,
) -> None:
    """Render photo-like keyframes of a folding program, with ground truth."""
    from folding_server.photographer.photographing import photograph as render

    told = ProgressLine("photographing")
    made = render(
        _program(program),
        out,
        seed,
        level,
        progress=lambda done, frames: told.tell(done / frames),
        between=between,
    )
    if as_json:
        _print_json({"folder": str(made.folder), "name": made.name, "frames": made.frames})
    else:
        typer.echo(f"wrote {made.frames} frames to {made.folder}")


@app.command()
def keyframes(
    video: Annotated[
        Path,
        typer.Argument(
            metavar="VIDEO", parser=typed_path, help="A video or animated picture of one sheet being folded."
        ),
    ],
    out: OutFolder,
    still: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="The shortest rest of a keyframe; left out, 0.4."),
    ] = None,
    front_color: Annotated[str | None, typer.Option(metavar="COLOR", help="Of the paper's front.")] = None,
    back_color: Annotated[str | None, typer.Option(metavar="COLOR", help="Of the paper's back.")] = None,
    as_json: Json = False,
) -> None:
    """Propose the keyframes of a video and write them as a sequence."""
    from folding_server.frames.keyframes import STILL_SECONDS
    from folding_server.frames.sequence_folder import DeclaredSheet
    from folding_server.frames.sequence_writer import keyframes_command

    told = DeclaredSheet(front_color=front_color, back_color=back_color)
    seconds = STILL_SECONDS if still is None else still
    tell = ProgressLine("watching").tell
    report = keyframes_command(video, out, still_seconds=seconds, paper=told, progress=tell)
    if as_json:
        _print_json(
            {
                "folder": str(report.folder),
                "keyframes": list(report.keyframes),
                "seconds": [round(second, 3) for second in report.seconds],
                "contact_sheet": str(report.contact_sheet),
                "moving": list(report.moving),
            }
        )
    else:
        typer.echo(f"wrote {len(report.keyframes)} keyframes to {report.folder}")
        if report.moving:
            typer.echo(
                f"nothing rests for {seconds:g} seconds: these are the stillest moments, look at each",
                err=True,
            )
        typer.echo(f"look them over in {report.contact_sheet}")


app.command()(derive)
app.command()(audit)


@app.command()
def view(
    source: ModelSource,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", parser=typed_path, help="Write one HTML file instead."),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="0 lets the system choose one.")
    ] = 0,
    data: Data = None,
    database: Database = None,
    sequences: Sequences = None,
) -> None:
    """Show a program or a run step by step in the browser; folds tried there are kept nowhere."""
    from folding_server.view.model_source import asked_model

    model = asked_model(source, data, database, sequences or ())
    if out:
        from folding_server.view.page import page_html

        typer.echo(f"wrote {_write(out, page_html(model.view()))}")
    else:
        from folding_server.view.local_server import serve_page

        model.view()
        serve_page(model, port, lambda address: typer.echo(f"The model is shown at {address} until Ctrl-C."))


def _program(path: Path) -> "Program":
    """The program in a file, which may be one of a published figure or a recorded result."""
    from folding_server.interchange.program_files import program_in

    return program_in(text_in(path, "give the path of a JSON file"))


def _exported(paper: "Paper", kind: "ExportFormat", program: "Program") -> str | bytes:
    """The final state in one of the export formats."""
    from folding_server.diagram.palette import colors_of
    from folding_server.interchange.export import export

    return export(paper, kind, colors_of(program.front_color, program.back_color), program).content


def _write(path: Path, content: str | bytes) -> str:
    """Write a file and give its path as text. FoldingError if it cannot be written."""
    try:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise FoldingError(f"{path} cannot be written ({error.strerror}); give another file.") from error
    return str(path)


def _print_json(document: Any) -> None:  # noqa: ANN401 - any JSON
    """The one document of ``--json``."""
    typer.echo(json.dumps(document, ensure_ascii=False))
