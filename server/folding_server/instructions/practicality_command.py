"""``foldingagent-server practicality``: whether people can fold a program or a run from a given paper."""

import json
import re
from typing import TYPE_CHECKING, Annotated

import typer

from folding_server.command_options import Data, Database, Json, ModelSource

if TYPE_CHECKING:
    from folding_server.instructions.practicality import CornerError, FoldDemand, PaperStock

MILLIMETRES = {"mm": 1.0, "cm": 10.0, "in": 25.4, "": 1.0}
LARGEST_MM = 100_000.0


def _length(text: str) -> float:
    """A length in millimetres. BadParameter if it is none."""
    found = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(mm|cm|in|)\s*", text)
    value = float(found[1]) * MILLIMETRES[found[2]] if found else 0.0
    if not 0 < value <= LARGEST_MM:
        raise typer.BadParameter(f"{text!r:.40} is no length above 0; give one such as 150mm, 15cm or 6in")
    return value


_Size = Annotated[
    float, typer.Option("--paper", metavar="LENGTH", parser=_length, help="The longer side of the sheet.")
]
_Thickness = Annotated[float, typer.Option(metavar="LENGTH", parser=_length, help="The paper's thickness.")]
_Off = Annotated[
    float, typer.Option("--off", metavar="LENGTH", parser=_length, help="By how much each fold may be off.")
]


def practicality(
    source: ModelSource,
    paper: _Size = "150mm",  # type: ignore[assignment]
    thickness: _Thickness = "0.1mm",  # type: ignore[assignment]
    off: _Off = "0.5mm",  # type: ignore[assignment]
    data: Data = None,
    database: Database = None,
    as_json: Json = False,
) -> None:
    """Say where a model asks more of paper and hands than they give: thick bends, small flaps, errors that add up."""
    from folding_server.errors import FoldingError
    from folding_server.instructions.moves import lesson_of
    from folding_server.instructions.practicality import PaperStock, corner_error, fold_demands
    from folding_server.view.model_source import asked_model
    from folding_server.wording.landmarks import Landmarks
    from folding_server.wording.sentences import Sentences

    lesson = lesson_of(asked_model(source, data, database).program)
    stock = PaperStock(paper, thickness, off)
    demands, error = fold_demands(lesson, stock), corner_error(lesson, stock)
    key = Landmarks(lesson.final).name_at(error.at) if error else None
    corner = str(Sentences("en").place(key)) if key else "a corner"
    if as_json:
        typer.echo(json.dumps(_report(demands, error, corner)))
    else:
        for line in _lines(demands, error, corner, stock):
            typer.echo(line)
    if lesson.refusal:
        raise FoldingError(f"Only what comes before it was looked at: {lesson.refusal}")


def _lines(
    demands: "list[FoldDemand]", error: "CornerError | None", corner: str, stock: "PaperStock"
) -> list[str]:
    lines = [
        f"Step {each.number} folds {_layers(each.layers)}: the bend takes {each.bend:.1f} mm of a flap of {each.flap:.1f} mm; "
        "take thinner or larger paper."
        for each in demands
        if each.too_thick
    ]
    lines += [
        f"Step {each.number} has a flap of {each.flap:.1f} mm, which is hard to hold; take larger paper."
        for each in demands
        if each.too_small
    ]
    if not lines:
        lines.append(f"Paper of {stock.side:g} mm that is {stock.thickness:g} mm thick does for every fold.")
    if demands:
        least, most = min(demands, key=lambda d: d.flap), max(demands, key=lambda d: d.layers)
        lines.append(f"The smallest flap has {least.flap:.1f} mm (step {least.number}).")
        lines.append(f"The most that any step folds is {_layers(most.layers)} (step {most.number}).")
    if error:
        lines.append(
            f"If each fold is {stock.off:g} mm off, {corner} of the finished model is usually {error.usual:.1f} mm off, at worst "
            f"{error.worst:.1f} mm ({error.moved} of {error.folds} lines could be moved to find out)."
        )
    return lines


def _layers(count: int) -> str:
    return f"{count} {'layer' if count == 1 else 'layers'} at once"


def _report(demands: "list[FoldDemand]", error: "CornerError | None", corner: str) -> dict[str, object]:
    folds = [
        {
            "step": each.number,
            "layers": each.layers,
            "flap_mm": round(each.flap, 2),
            "bend_mm": round(each.bend, 2),
            "too_thick": each.too_thick,
            "too_small": each.too_small,
        }
        for each in demands
    ]
    off = error and {"corner": corner, "usual_mm": round(error.usual, 2), "worst_mm": round(error.worst, 2)}
    return {"folds": folds, "error": off}
