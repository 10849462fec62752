"""A program as the page shows it: one stop an action, each with its whole state."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from math import hypot

from folding_schemas.actions import Action, Program
from folding_schemas.model_view import ModelColors, ModelShown, ModelStop, ModelView

from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.simulator import Paper, folded_state, moved_faces

ViewWindow = tuple[float, float, float]
"""Left, bottom and side of a square of the table plane, in sheet units."""

MARGIN = 0.1
"""Free border around all states, in parts of the sheet's diagonal: room for vertex labels."""

MOST_STATE_BYTES = 450_000
"""Most bytes of all states together. With photos they stay under the 800 kB that an answer may have."""


def model_view(
    program: Program,
    replays: ReplayCache,
    photos: Mapping[int, str] | None = None,
    run_id: str | None = None,
) -> ModelView:
    """All that the page needs to show a program. ActionRefused if the program cannot be folded."""
    papers = _papers(program, replays)
    stops = list(_stops(program, papers))
    first = _first_that_fits(stops)
    return ModelView(
        title=program.name,
        run_id=run_id,
        steps=len(program.steps),
        sheet=program.sheet,
        colors=_colors(program),
        window=window_of(papers),
        sheet_coords={str(v): _rounded(at) for paper in papers for v, at in paper.vertices_coords.items()},
        stops=stops[first:],
        photos=dict(photos or {}),
        left_out=first,
    )


def model_shown(view: ModelView) -> ModelShown:
    """The same in words."""
    lines = [_in_words(stop) for stop in view.stops]
    last = view.stops[-1].state
    layers = len(last.layers)
    summary = (
        f"{view.title}: {len(view.stops) - 1} actions in {view.steps} steps; now {len(last.vertices)} vertices, "
        f"{len(last.faces)} faces in {layers} {'layer' if layers == 1 else 'layers'}."
    )
    return ModelShown(run_id=view.run_id, title=view.title, stops=lines, summary=summary)


def program_window(program: Program, replays: ReplayCache) -> ViewWindow:
    """The square around every state of a program. ActionRefused if the program cannot be folded."""
    return window_of(_papers(program, replays))


def window_of(papers: Iterable[Paper]) -> ViewWindow:
    """A square around every vertex of the papers, with a border."""
    states = list(papers)
    xs, ys = zip(*(at for paper in states for at in paper.folded_vertices_coords.values()), strict=True)
    border = MARGIN * hypot(*states[0].sheet)
    side = max(max(xs) - min(xs), max(ys) - min(ys)) + 2 * border
    return (
        round((min(xs) + max(xs) - side) / 2, 4),
        round((min(ys) + max(ys) - side) / 2, 4),
        round(side, 4),
    )


def _papers(program: Program, replays: ReplayCache) -> list[Paper]:
    """The flat sheet and the paper after each action."""
    actions = tuple(action for step in program.steps for action in step)
    return [replays.after(program.sheet, actions[:done]) for done in range(len(actions) + 1)]


def _stops(program: Program, papers: list[Paper]) -> Iterator[ModelStop]:
    from folding_server.diagram.strip import describe_action  # loads shapely

    yield ModelStop(
        step=0, frame=1, text="the flat sheet", crease=None, moved_faces=[], state=folded_state(papers[0])
    )
    before_and_after = pairwise(papers)
    for number, step in enumerate(program.steps, 1):
        for action in step:
            before, after = next(before_and_after)
            yield ModelStop(
                step=number,
                frame=number + 1,
                text=describe_action(action),
                crease=_crease_of(action, after),
                moved_faces=list(moved_faces(before, after)),
                state=folded_state(after),
            )


def _crease_of(action: Action, after: Paper) -> tuple[int, int] | None:
    """The two vertices an action was made through; those of the new fold where it names none itself."""
    edge = getattr(action, "edge", None)
    if edge is None or action.action == "add_vertex":
        return None
    return edge if set(edge) <= after.vertices_coords.keys() else None


def _first_that_fits(stops: list[ModelStop]) -> int:
    """From which stop on all states are small enough together; the last one always counts as such."""
    left = MOST_STATE_BYTES
    for i in range(len(stops) - 1, -1, -1):
        left -= len(stops[i].model_dump_json())
        if left < 0:
            return min(i + 1, len(stops) - 1)
    return 0


def _colors(program: Program) -> ModelColors:
    from folding_server.diagram.palette import colors_of, diagram_colors  # loads shapely

    inks = diagram_colors(colors_of(program.front_color, program.back_color))
    return ModelColors(front=inks.front, back=inks.back, front_ink=inks.front_ink, back_ink=inks.back_ink)


def _in_words(stop: ModelStop) -> str:
    moved, faces = len(stop.moved_faces), len(stop.state.faces)
    layers = len(stop.state.layers)
    what = f"step {stop.step}: {stop.text}; {moved} of {faces} faces moved" if stop.step else stop.text
    return f"{what}; {layers} {'layer' if layers == 1 else 'layers'}"


def _rounded(at: tuple[float, float]) -> tuple[float, float]:
    """A place to six decimals, as in states."""
    return round(at[0], 6), round(at[1], 6)
