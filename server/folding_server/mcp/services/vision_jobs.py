"""What tools compute that take long, as functions of plain data: a worker process has no database and no run."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from folding_schemas.foldability_results import Foldability
from folding_schemas.results import Comparison, CreaseRefinement, Proposals
from folding_schemas.state_measures import StateMeasures

from folding_server.errors import PhotoError
from folding_server.mcp.services import presenters
from folding_server.mcp.services.observer_cache import ObserverCache

if TYPE_CHECKING:
    from folding_schemas.actions import Actions, Program
    from folding_schemas.model_view import ModelView

    from folding_server.frames.image_files import EncodedImage
    from folding_server.frames.photo_cache import PhotoCache
    from folding_server.frames.sequences import Sequence
    from folding_server.mcp.services.replay_cache import ReplayCache
    from folding_server.simulator import Paper
    from folding_server.workers.job import Announce

COUNTING_SECONDS = 1.0
"""Seconds for which layer orders are counted, once one is found."""
RIVALS_LOOKED_AT = 6
"""Plans that are asked for at least: the confidence in the best is judged by those that lead elsewhere."""
SEEING = "finding the sheet in the photos"


@dataclass(frozen=True)
class SequencePlace:
    """Where a sequence is read, and the fingerprint by which its observer is kept."""

    folder: Path
    fingerprint: str

    @classmethod
    def of(cls, photos: "Sequence") -> "SequencePlace":
        """The place of a sequence that is open here."""
        return cls(photos.folder.resolve(), photos.fingerprint())

    @property
    def key(self) -> str:
        """By which a worker is found that has seen the sequence."""
        return f"{self.fingerprint} {self.folder}"

    def load(self) -> "Sequence":
        """The sequence. PhotoError if it is not what it was when its place was taken."""
        from folding_server.frames.sequences import load_sequence  # noqa: PLC0415  (loads Pillow)

        photos = load_sequence(self.folder, _photos())
        if photos.fingerprint() != self.fingerprint:
            raise PhotoError(
                f"the photos of {photos.name!r:.80} are being changed; call again when that is done"
            )
        return photos


@dataclass(frozen=True)
class KnownState:
    """The paper before a frame, and the ``steps`` that led to it from the flat sheet, one for each photo; none if that is not known."""

    paper: "Paper"
    steps: "tuple[Actions, ...]" = ()


def propose_actions_for(
    announce: "Announce", place: SequencePlace, known: KnownState, frame: int, count: int
) -> Proposals:
    """What may have been done to a paper before a frame, the likeliest first."""
    from folding_server.vision.photo_doubts import doubts_about  # noqa: PLC0415  (loads OpenCV)
    from folding_server.vision.solver import clearly_best, confidence, propose  # noqa: PLC0415

    announce(SEEING)
    with observers().on(place.key, place.load) as observer:
        announce(f"explaining frame {frame}")
        plans = propose(known.paper, observer, frame, max(count, RIVALS_LOOKED_AT), known.steps)
        doubts = doubts_about(observer, frame, observer.outlines(frame))
    shown = presenters.proposals(plans[:count])
    sure = round(confidence(plans), 3) if plans else None
    clear = clearly_best(plans) and not doubts.spoils
    return Proposals(frame=frame, proposals=shown, confident=clear, confidence=sure, warnings=doubts.words)


def refine_creases_for(
    announce: "Announce", place: SequencePlace, steps: "tuple[Actions, ...]"
) -> CreaseRefinement:
    """The steps with their creases where all photos show them."""
    from folding_server.vision.solver import refined, revised  # noqa: PLC0415  (loads OpenCV)

    announce(SEEING)
    with observers().on(place.key, place.load) as observer:
        announce("fitting the creases to all photos")
        found, kept = refined(steps, observer), revised(steps, observer)
    return CreaseRefinement(
        frame=len(steps) + 1,
        told=found.told,
        moved=round(found.moved, 4),
        steps=[list(step) for step in kept],
    )


def compare_paper(
    announce: "Announce", place: SequencePlace, paper: "Paper", frame: int, draw: bool
) -> "tuple[Comparison, EncodedImage | None]":
    """How well a paper explains a frame's photo, and the paper drawn over the photo if that is wanted."""
    from folding_server.frames.image_files import encode_for_model  # noqa: PLC0415
    from folding_server.vision.any_camera import compare_with_photo  # noqa: PLC0415  (loads OpenCV)
    from folding_server.vision.overlay import draw_overlay  # noqa: PLC0415
    from folding_server.vision.photo_doubts import doubts_about, without_match  # noqa: PLC0415

    announce(SEEING)
    with observers().on(place.key, place.load) as observer:
        announce(f"comparing with frame {frame}")
        compared = compare_with_photo(paper, observer, frame)
        outlines = compared.observer.outlines(frame)
        doubts = doubts_about(compared.observer, frame, outlines)
    seen, match = compared.seen, without_match(compared.match, doubts)
    words = [*doubts.spoils, *observer.remarks]
    found = presenters.comparison(seen, match, outlines, words)
    overlay = encode_for_model(draw_overlay(paper, seen, match, outlines=outlines)) if draw else None
    return found, overlay


@dataclass(frozen=True)
class SheetColors:
    """The colours of the sides of a sheet; None where they are not told."""

    front_color: str | None
    back_color: str | None


@dataclass(frozen=True)
class OverviewColumn:
    """One column of the overview of checkpoints: a frame, its saved paper if there is one, and what stands above."""

    frame: int
    paper: "Paper | None"
    caption: str


def draw_overview(
    announce: "Announce",
    place: SequencePlace,
    sheet: SheetColors,
    columns: list[OverviewColumn],
) -> "EncodedImage":
    """Photos above, saved states below."""
    from folding_server.mcp.services.images import SMALL_SIZE, diagram, overview  # noqa: PLC0415  (loads shapely)

    photos = place.load()
    pixels, diagrams = [], []
    for column in columns:
        announce(f"frame {column.frame}")
        pixels.append(photos.source.read(photos.index(column.frame), SMALL_SIZE))
        diagrams.append(diagram(sheet, column.paper, size=SMALL_SIZE) if column.paper else None)
    return overview(pixels, diagrams, [column.caption for column in columns])


def view_program(
    announce: "Announce", program: "Program", run_id: str | None, place: SequencePlace | None
) -> "ModelView":
    """All that the view of a model shows of a program, with the photos of its sequence if there is one."""
    from folding_server.view.photo_strip import photos_of  # noqa: PLC0415  (loads Pillow)
    from folding_server.view.stops import model_view, program_window  # noqa: PLC0415

    announce("drawing the steps")
    shown: dict[int, str] = {}
    if place is not None:
        with suppress(PhotoError):  # the model is shown without photos where they cannot be read
            frames = range(1, len(program.steps) + 2)
            shown = photos_of(place.load(), frames, program_window(program, _replays()))
    return model_view(program, _replays(), shown, run_id)


def check_folding_flat(announce: "Announce", paper: "Paper") -> Foldability:
    """Whether the crease pattern of a paper can be folded flat."""
    from folding_server.simulator.foldability import Counting, check_paper  # noqa: PLC0415  (loads shapely)

    announce("looking for an order of the layers")
    return presenters.foldability(check_paper(paper, counting=Counting(seconds=COUNTING_SECONDS)))


def check_text_folding_flat(announce: "Announce", text: str) -> Foldability:
    """Whether the crease pattern in the text of a file can be folded flat."""
    from folding_server.interchange.pattern_files import ending_of_text, read_patterns  # noqa: PLC0415
    from folding_server.simulator.foldability import Counting, check_pattern  # noqa: PLC0415

    announce("looking for an order of the layers")
    (read,) = read_patterns(text, ending_of_text(text))
    return presenters.foldability(
        check_pattern(read.pattern, counting=Counting(seconds=COUNTING_SECONDS)), read
    )


def measure_for_evaluation(announce: "Announce", measured: "Paper | str") -> StateMeasures:
    """What evaluation is told of a paper, or of the state in the text of a FOLD file. ProgramError if it cannot be read."""
    from folding_server.measuring.state_measuring import measured_model, measured_paper  # noqa: PLC0415  (loads shapely)
    from folding_server.measuring.stated_model import stated_model  # noqa: PLC0415

    announce("looking for an order of the layers")
    return measured_model(stated_model(measured)) if isinstance(measured, str) else measured_paper(measured)


@cache
def observers() -> ObserverCache:
    """The observers that this process keeps."""
    return ObserverCache()


@cache
def _replays() -> "ReplayCache":
    """The papers that this process keeps."""
    from folding_server.mcp.services.replay_cache import ReplayCache  # noqa: PLC0415

    return ReplayCache()


@cache
def _photos() -> "PhotoCache":
    """The photos that this process keeps decoded."""
    from folding_server.frames.photo_cache import PhotoCache  # noqa: PLC0415

    return PhotoCache()
