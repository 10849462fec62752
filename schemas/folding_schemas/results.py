"""What the server's tools answer, one model per tool result. Images travel beside these as image content."""

from typing import Literal

from pydantic import Field

from folding_schemas.actions import Action, Program
from folding_schemas.state import FoldedState
from folding_schemas.wire import Wire

Verdict = Literal["MATCH", "MISMATCH", "EXTREME DIVERGENCE"]
ActionClass = Literal["rotate", "flip", "fold", "unfold", "none", "compound"]
AttemptOutcome = Literal["open", "restored", "saved", "committed"]
ExportFormat = Literal[
    "fold", "crease-pattern", "crease-pattern-svg", "cp", "svg", "png", "obj", "program", "steps"
]
SequenceOutcome = Literal["added", "replaced", "unchanged"]
Images = Literal["none", "small", "full"]
"""Whether an answer has its pictures, and how large: ``small`` is half as wide and high."""


class SequenceInfo(Wire):
    """One sequence of keyframes that the server can open."""

    name: str
    frames: int
    front_color: str | None
    back_color: str | None


class SequenceList(Wire):
    """Answer of ``list_sequences``; ``problems`` has one sentence for each folder that cannot be served."""

    sequences: list[SequenceInfo]
    problems: list[str] = []


class AddedKeyframe(Wire):
    """A keyframe of an added sequence: its frame, from 1; the number of its image, and its time in a film.

    ``moving`` says that something moves in it: where nothing rests, the stillest moments are taken.
    """

    frame: int
    image: int
    seconds: float | None
    moving: bool = False


class SequenceAdded(Wire):
    """Answer of ``add_sequence``.

    ``frames`` counts the keyframes, ``images`` all images of the film, or the photos. A sequence is ``unchanged`` where it
    was there like this already. Images of a film are numbered from 0, photos from 1. ``warnings`` has a sentence for each thing
    that speaks against the photos.
    """

    name: str
    outcome: SequenceOutcome
    images: int
    frames: int
    keyframes: list[AddedKeyframe]
    front_color: str | None
    back_color: str | None
    warnings: list[str] = []


class SequenceRemoved(Wire):
    """Answer of ``remove_sequence``."""

    name: str


class RunInfo(Wire):
    """Answer of ``open_run`` and ``get_run``: where a run stands.

    ``frames`` is 0 for a free fold. ``saved`` lists the frames that hold a checkpoint; ``next_frame`` is the frame
    that comes after the checkpoint the current state grew from, None when all frames are saved. ``attempts`` and
    ``restores`` count by frame; frames up to ``locked_to`` are closed for restore and save. ``budget`` is how many
    attempts a frame has from one state of the frame before; ``attempts_used`` counts by frame those from the state that
    is saved now, ``attempts_left`` those that can still be made towards ``next_frame``, the one under way
    included: at 0, one has to be committed. It is None where there are no attempts.
    """

    run_id: str
    sequence: str | None
    frames: int
    front_color: str
    back_color: str
    saved: list[int]
    next_frame: int | None
    pending: list[Action]
    attempts: dict[int, int]
    restores: dict[int, int]
    budget: int
    locked_to: int
    complete: bool
    program: Program
    attempts_used: dict[int, int] = {}
    attempts_left: int | None = None


class RunLine(Wire):
    """One run in ``list_runs``: ``saved`` counts its checkpoints, ``changed`` is when it changed last (ISO 8601, UTC).

    ``frames`` is 0 for a free fold.
    """

    run_id: str
    sequence: str | None
    frames: int
    saved: int
    changed: str
    complete: bool


class RunList(Wire):
    """Answer of ``list_runs``, newest first; ``more`` says that there are older ones."""

    runs: list[RunLine]
    more: bool


class ActionResult(Wire):
    """Answer of every folding action and of ``undo``: the new state and what the action did.

    ``attempt`` counts from 1 within the transition to ``frame``; both are None in a free fold.
    """

    run_id: str
    summary: str
    new_vertices: list[int]
    new_faces: list[int]
    moved_faces: list[int]
    frame: int | None
    attempt: int | None
    state: FoldedState


class FrameView(Wire):
    """Answer of ``view_frame``: the size in pixels of the photo that comes with it in full."""

    frame: int
    width: int
    height: int


class MovementView(Wire):
    """Answer of ``observe_movement``: which video images the filmstrip shows, left to right."""

    frame: int
    images: list[int]


class StateView(Wire):
    """Answer of ``get_current_state``."""

    run_id: str
    state: FoldedState


class RenderView(Wire):
    """Answer of ``render_current``: the size in pixels of the diagram that comes with it in full."""

    run_id: str
    width: int
    height: int
    labels: bool


class CheckpointSaved(Wire):
    """Answer of ``save_checkpoint``."""

    frame: int
    actions: list[Action]
    next_frame: int | None
    remaining: int
    complete: bool


class CheckpointRestored(Wire):
    """Answer of ``restore_checkpoint``.

    ``next_attempt`` is the number that the next action's attempt will have; None in a free fold and at the last
    frame. ``attempts_used`` and ``attempts_left`` are those of the next frame from here, as in ``RunInfo``.
    """

    frame: int
    next_attempt: int | None
    restore_count: int
    state: FoldedState
    attempts_used: int = 0
    attempts_left: int | None = None


class CheckpointState(Wire):
    """Answer of ``get_checkpoint_state``: the saved state and the actions that lead to it from the one before."""

    frame: int
    actions: list[Action]
    notes: str | None
    state: FoldedState


class OverviewFrame(Wire):
    """One column of the checkpoint overview."""

    frame: int
    saved: bool
    notes: str | None
    restores: int
    attempts: int


class CheckpointOverview(Wire):
    """Answer of ``generate_checkpoint_overview``; the picture has photos above and diagrams below."""

    frames: list[OverviewFrame]


class AttemptInfo(Wire):
    """One explored transition: its actions and how it ended."""

    attempt: int
    label: str
    actions: list[Action]
    outcome: AttemptOutcome


class AttemptState(Wire):
    """A state that an attempt came to: the number of both, and the actions to it from the frame before.

    ``last`` marks the attempt's last state. ``on_path`` says that the attempt grew from what is saved for the frame
    before; ``rewrites`` lists the saved frames that become others if this is committed. What is not ``committable``
    grew from frames that a later commitment replaced.
    """

    attempt: int
    state: int
    actions: list[Action]
    last: bool
    on_path: bool
    committable: bool
    rewrites: list[int]


class AttemptList(Wire):
    """Answer of ``list_attempts``: one diagram follows for each attempt, in this order, then one for each earlier state.

    ``states`` are what the diagrams show, in their order: the last state of each attempt, then the others, of which so many
    that are older are ``left_out``. ``used`` counts the attempts at the frame from what is saved for the frame before.
    """

    frame: int
    budget: int
    attempts: list[AttemptInfo]
    states: list[AttemptState] = []
    used: int = 0
    left_out: int = 0


class AttemptCommitted(Wire):
    """Answer of ``commit_attempt``: the chosen attempt is saved and frames up to ``locked_to`` are closed.

    ``rewritten`` lists the earlier frames that are others now, ``dropped`` the later ones that went.
    """

    frame: int
    attempt: int
    locked_to: int
    next_frame: int | None
    complete: bool
    state: FoldedState
    rewritten: list[int] = []
    dropped: list[int] = []


class CriticGrid(Wire):
    """Answer of ``critic_grid``: four images follow, source photo, target photo, source and candidate diagram."""

    frame: int
    source_state: FoldedState
    candidate_state: FoldedState
    candidate_actions: list[Action]


class SeenOutline(Wire):
    """One piece of paper in a photo: its corners clockwise; ``hidden`` numbers the sides under something, from 0."""

    corners: list[tuple[float, float]]
    hidden: list[int]


class Comparison(Wire):
    """Answer of ``compare_to_frame``: how well the current state explains a photo.

    ``iou`` is intersection over union by class (front, back, paper) after the best small rigid motion;
    ``agreement`` the share of the pixels showing paper, in the photo or the diagram, whose class agrees;
    ``shift`` that motion as (dx, dy in sheet units, degrees clockwise). ``outline_distance`` is the mean distance
    of the silhouettes, ``outline_worst`` its 95 % quantile, in sheet units. ``lines`` says how well the state
    explains the creases and layer edges that the photo shows inside the paper: 1 all, 0 none seen or no better
    than chance, below 0 worse. ``confidence`` says how clearly the photo shows what is paper and which side of it.
    ``outlines`` is the paper that it shows, largest piece first, where frame 1's sheet is the unit square. ``warnings`` has a
    sentence for each thing that speaks against the photos; where it is one that spoils the comparison, nothing is a MATCH.
    The last four but ``warnings`` are None in answers recorded before they were measured.
    """

    frame: int
    verdict: Verdict
    agreement: float = Field(ge=0, le=1)
    iou: dict[str, float]
    outline_distance: float
    shift: tuple[float, float, float]
    discrepancies: list[str]
    outline_worst: float | None = None
    lines: float | None = Field(default=None, ge=-1, le=1)
    confidence: float | None = Field(default=None, ge=0, le=1)
    outlines: list[SeenOutline] | None = None
    warnings: list[str] = []


class Proposal(Wire):
    """One plan for a transition: primitives to apply in order, how well the result explains the photo, and why.

    ``evidence`` is what each named term adds to ``score``, in shares of the paper.
    """

    rank: int
    action_class: ActionClass
    actions: list[Action]
    agreement: float
    score: float
    explanation: str
    evidence: dict[str, float] = {}


class Proposals(Wire):
    """Answer of ``propose_actions``, best first. ``confident`` says that the best stands clear of the rest, ``confidence`` how likely
    it is, from 0 to 1, that the best leads to the state that the photo shows.

    ``warnings`` has a sentence for each thing that speaks against the photos; where it is one that spoils what is seen, nothing
    is ``confident``.
    """

    frame: int
    proposals: list[Proposal]
    confident: bool
    confidence: float | None = Field(default=None, ge=0, le=1)
    warnings: list[str] = []


class CreaseRefinement(Wire):
    """Answer of ``refine_creases``: the ``steps`` that lead to ``frame``, one for each photo, with their creases where all photos
    together show them; as they were where the photos do not tell (``told``).

    ``moved`` is how far a vertex of the sheet came to lie elsewhere, in sides of the sheet.
    """

    frame: int
    told: bool
    moved: float
    steps: list[list[Action]]


class Export(Wire):
    """Answer of ``export_state``: the file's text, or None for a PNG, which comes as image content."""

    format: ExportFormat
    media_type: str
    filename: str
    text: str | None


class Instructions(Wire):
    """Answer of ``get_instructions``: the words of each step, numbered; ``refusal`` says why they end early, if they do."""

    steps: list[str]
    refusal: str | None


class ProgramTrial(Wire):
    """Answer of ``try_program``: how many steps can be folded, what each does, and the state after the last of them.

    ``error`` says what is wrong with the step that comes next, None if the whole program can be folded.
    """

    complete: bool
    steps_done: int
    steps: list[str]
    error: str | None
    state: FoldedState | None
