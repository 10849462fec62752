"""What the tools for instructions compute, as functions of plain data for worker processes."""

from typing import TYPE_CHECKING

from folding_schemas.results import Instructions, ProgramTrial

from folding_server.errors import FoldingError, ProgramError

if TYPE_CHECKING:
    from folding_schemas.actions import Program

    from folding_server.frames.image_files import EncodedImage
    from folding_server.simulate import StepResult
    from folding_server.workers.job import Announce

SHEET_PIXELS = 1100
"""Width in pixels of a whole sheet: its words can be read."""
STEP_PIXELS = 640
"""Width in pixels of one step."""
TRIED_PANEL = 260
"""Side in pixels of each state of a program that is tried: vertex ids can be read."""
MOST_PANELS = 24
"""So many of the last states are drawn, four in a row."""
TRIED_COLUMNS = 4


def instruct(
    announce: "Announce", program: "Program", step: int | None
) -> "tuple[Instructions, EncodedImage]":
    """The words of a program's steps, and the picture of one or of all. ProgramError if there is no such step."""
    from folding_server.diagram.rasterise import rasterise  # noqa: PLC0415
    from folding_server.frames.image_files import decode_bytes, encode_for_model  # noqa: PLC0415
    from folding_server.instructions.moves import lesson_of  # noqa: PLC0415
    from folding_server.instructions.sheet_layout import SheetForm, lay_out  # noqa: PLC0415
    from folding_server.instructions.sheet_svg import sheet_svg, step_svg  # noqa: PLC0415
    from folding_server.wording.repeats import with_repeats  # noqa: PLC0415
    from folding_server.wording.sheet_words import lesson_words, numbered_lines  # noqa: PLC0415

    announce("drawing the steps")
    lesson, form = with_repeats(lesson_of(program)), SheetForm(endless=True)
    words = lesson_words(lesson)
    if step is not None and step > len(words):
        raise ProgramError(f"There is no step {step}; the instructions have the steps 1 to {len(words)}.")
    sheet = lay_out(lesson, words, form)
    svg = sheet_svg(sheet) if step is None else step_svg(sheet.steps[step - 1], form.column_width)
    pixels = decode_bytes(rasterise(svg, SHEET_PIXELS if step is None else STEP_PIXELS), "the instructions")
    told = Instructions(steps=numbered_lines(words).splitlines(), refusal=lesson.refusal)
    return told, encode_for_model(pixels, max(pixels.shape))


def try_whole(announce: "Announce", text: str) -> "tuple[ProgramTrial, EncodedImage | None]":
    """How far a program can be folded, with a picture of its states. A program that cannot be read has an error alone."""
    from folding_server.interchange.programs import load_program  # noqa: PLC0415
    from folding_server.simulate import run_steps  # noqa: PLC0415
    from folding_server.simulator import folded_state  # noqa: PLC0415

    announce("folding the program")
    try:
        program = load_program(text)
    except FoldingError as error:
        return ProgramTrial(complete=False, steps_done=0, steps=[], error=str(error), state=None), None
    done: list[StepResult] = []
    error_text: str | None = None
    try:
        done.extend(run_steps(program))
    except FoldingError as error:
        error_text = str(error)
    if error_text:
        whole = error_text.partition(",")[0].removeprefix("Step ")
        done = list(run_steps(program.model_copy(update={"steps": program.steps[: int(whole) - 1]})))
    tried = ProgramTrial(
        complete=error_text is None,
        steps_done=len(done) - 1,
        steps=[result.line for result in done[1:]],
        error=error_text,
        state=folded_state(done[-1].paper),
    )
    return tried, _states_drawn(program, done)


def _states_drawn(program: "Program", done: "list[StepResult]") -> "EncodedImage":
    """The states of a program that is tried, with vertex ids."""
    from folding_server.diagram import Panel, draw_panels_svg, rasterise  # noqa: PLC0415
    from folding_server.diagram.palette import colors_of  # noqa: PLC0415
    from folding_server.diagram.strip import describe_action  # noqa: PLC0415
    from folding_server.frames.image_files import decode_bytes, encode_for_model  # noqa: PLC0415

    panels = [
        Panel(each.paper, (f"step {each.step}", *map(describe_action, each.actions)))
        for each in done[-MOST_PANELS:]
    ]
    colors = colors_of(program.front_color, program.back_color)
    svg = draw_panels_svg(panels, colors, TRIED_COLUMNS, TRIED_PANEL, labels=True)
    pixels = decode_bytes(rasterise(svg), "the states")
    return encode_for_model(pixels, max(pixels.shape))
