"""Putting right and wrong states before a critic, and counting how it judges them.

A case is a frame of a sequence with truth: the true steps lead to the frame before, the last step is carried out as it
was done or with one mistake in it, and the critic is asked about the result.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Literal, cast

from folding_schemas.actions import Actions, Program
from folding_schemas.results import ActionClass, CheckpointSaved, CriticGrid, RenderView, Verdict

from folding_client.assembly import SAVING, RoleModels, make_critic, make_role_models
from folding_client.critic_accuracy.intervals import Share, share_of
from folding_client.critic_accuracy.wrong_steps import KINDS, WrongKind, carry_out_wrongly, kinds_for
from folding_client.interrupts import RunStopped, ToolRefused, UsageError
from folding_client.json_files import read_json_file
from folding_client.protocol.acting import ACTIONS, carry_out
from folding_client.protocol.connection import ServerAddress
from folding_client.protocol.server_client import ServerClient
from folding_client.reconstruct import sequence_name
from folding_client.record.folder import RunFolder
from folding_client.record.recorder import Recorder
from folding_client.record.totals import total_cost, total_tokens
from folding_client.roles.critic import Critic, CriticCase
from folding_client.settings import Settings

TRUTH = "program.json"
"""The file of a sequence's folder that holds the true program."""
_NEEDED = (
    ACTIONS | SAVING | {"open_run", "get_current_state", "render_current", "critic_grid", "compare_to_frame"}
)
CaseKind = Literal["right"] | WrongKind
LeftOut = Literal["refused", "alike"]
"""Why a state is not judged: the server refuses to make it, or it is wrong and looks like the right one."""


@dataclass(frozen=True)
class TrueSequence:
    """A sequence folder with its true steps; step k leads from frame k to frame k + 1."""

    folder: Path
    steps: tuple[Actions, ...]


@dataclass(frozen=True)
class StateToJudge:
    """A frame from 2 on, and what is made wrong on the way to it."""

    sequence: TrueSequence
    frame: int
    kind: CaseKind


@dataclass(frozen=True)
class JudgedCase:
    """What the critic said of a state; ``verdict`` is None if it gave none that can be read."""

    sequence: str
    frame: int
    kind: CaseKind
    verdict: Verdict | None

    @property
    def is_right(self) -> bool:
        """Whether the verdict is the right one."""
        return (self.verdict == "MATCH") == (self.kind == "right") and self.verdict is not None


@dataclass(frozen=True)
class CriticAccuracy:
    """How a critic judged. ``false_match`` are the wrong states that it took for a match, in all and by kind,
    ``false_mismatch`` the right ones that it took for none. ``refused`` and ``alike`` count
    what was left out, ``stopped`` says what cut it short, empty if nothing did.
    """

    critic: str
    seed: int
    accuracy: Share
    false_match: Share
    false_mismatch: Share
    no_verdict: Share
    false_match_by_kind: dict[str, Share]
    refused: int
    alike: int
    tokens: int
    cost: float | None
    stopped: str
    cases: list[JudgedCase]


def sequences_with_truth(folders: Sequence[Path]) -> list[TrueSequence]:
    """The sequences among folders that hold a true program. UsageError if none does, or one cannot be read or is not of a
    square sheet.
    """
    found = [
        TrueSequence(folder.resolve(), _steps(folder / TRUTH))
        for folder in folders
        if (folder / TRUTH).is_file()
    ]
    if not found:
        message = (
            f"None of the sequences holds the true program in a {TRUTH}; name examples, or what "
            "foldingagent-server photograph wrote."
        )
        raise UsageError(message)
    return found


def _steps(file: Path) -> tuple[Actions, ...]:
    program = read_json_file(Program, file, "a program", "sequences with the true program beside them")
    width, height = program.sheet
    if width != height:
        message = (
            f"{file} folds a sheet of {width:g} by {height:g}, and runs fold a square, so that its states cannot be made; leave "
            "this sequence out."
        )
        raise UsageError(message)
    return program.steps


def states_to_judge(sequences: Sequence[TrueSequence], *, right: bool) -> list[StateToJudge]:
    """All the states of sequences that are right, or that can be made wrong."""
    return [
        StateToJudge(sequence, frame, each)
        for sequence in sequences
        for frame, step in enumerate(sequence.steps, start=2)
        for each in _kinds(step, right=right)
    ]


def _kinds(step: Actions, *, right: bool) -> Sequence[CaseKind]:
    return ("right",) if right else kinds_for(step)


async def critic_accuracy(
    sequences: Sequence[TrueSequence],
    count: int,
    seed: int,
    settings: Settings,
    out: Path,
    say: Callable[[str], None],
) -> CriticAccuracy:
    """Have the critic of the settings judge up to ``count`` right states and as many wrong ones, drawn by ``seed``. States
    that the server refuses to make, and wrong ones that look like the right one, are counted and others taken instead.
    Everything is on record in the new folder ``out``.
    """
    folder = RunFolder(out)
    folder.create()
    recorder = Recorder(folder, {})
    measured = _Measured(settings.role("critic"), seed)
    try:
        role_models = make_role_models(settings, recorder)
        for right in (True, False):
            left = _shuffled(states_to_judge(sequences, right=right), f"{seed}/{right}")
            while left and (missing := count - measured.count(right=right)) > 0:
                drawn, left = left[:missing], left[missing:]
                for states in _by_sequence(drawn):
                    await _judge(states, settings, role_models, recorder, measured, say)
    except RunStopped as stop:
        measured.stopped = str(stop)
    except UsageError:
        folder.discard()
        raise
    finally:
        recorder.close()
        folder.release()
    found = measured.counted(recorder)
    folder.write_json("accuracy.json", asdict(found))
    return found


def _shuffled(states: list[StateToJudge], seed: str) -> list[StateToJudge]:
    return random.Random(seed).sample(states, len(states))


def _by_sequence(states: Sequence[StateToJudge]) -> Iterator[list[StateToJudge]]:
    """The states of each sequence together, so that one server makes them."""
    for folder in dict.fromkeys(state.sequence.folder for state in states):
        yield [state for state in states if state.sequence.folder == folder]


async def _judge(
    states: Sequence[StateToJudge],
    settings: Settings,
    role_models: RoleModels,
    recorder: Recorder,
    measured: "_Measured",
    say: Callable[[str], None],
) -> None:
    """Have states of one sequence judged, on a server of their own."""
    sequence = states[0].sequence.folder
    address = ServerAddress(sequence, recorder.folder.store, settings.server_url)
    with (recorder.folder.path / "server.log").open("a", encoding="utf-8") as log:
        server = ServerClient(address, recorder, log)
        try:
            await server.start()
            server.require(sorted(_NEEDED))
            critic = make_critic(role_models, server, recorder)
            for state in states:
                measured.add(await _judged(state, server, critic, recorder))
                say(measured.said)
        finally:
            await server.close()


async def _judged(
    state: StateToJudge, server: ServerClient, critic: Critic, recorder: Recorder
) -> JudgedCase | LeftOut:
    """What the critic says of a state, on a fresh run, or why it is not asked."""
    frame = state.frame
    try:
        right = None if state.kind == "right" else await _look_of(replace(state, kind="right"), server)
        async with server.another_run(sequence_name(state.sequence.folder)) as info:
            await _make(state, server)
            if right is not None and await _look(server) == right:
                return "alike"
            grid, pictures = await server.ask(CriticGrid, "critic_grid", frame=frame)
            classes = classes_of(state.sequence.steps[frame - 2])
            colors = info.front_color, info.back_color
            states = grid.source_state, grid.candidate_state
            judgement = await critic.judge(CriticCase(frame, classes, None, *states, pictures, colors))
    except ToolRefused:
        return "refused"
    recorder.event("verdict", frame=frame, **asdict(judgement))
    return JudgedCase(info.sequence or "", frame, state.kind, judgement.verdict)


async def _look_of(state: StateToJudge, server: ServerClient) -> bytes:
    async with server.another_run(sequence_name(state.sequence.folder)):
        await _make(state, server)
        return await _look(server)


async def _look(server: ServerClient) -> bytes:
    """The diagram of the current state: states that look the same have the same."""
    _, pictures = await server.ask(RenderView, "render_current", labels=False)
    return pictures[0].data


async def _make(state: StateToJudge, server: ServerClient) -> None:
    """Carry out the true steps up to the frame before, saving each, then the last as it is to be."""
    steps = state.sequence.steps
    for frame, step in enumerate(((), *steps[: state.frame - 2]), start=1):
        await carry_out(server, step)
        await server.ask(CheckpointSaved, "save_checkpoint", frame=frame)
    last = steps[state.frame - 2]
    if state.kind == "right":
        await carry_out(server, last)
    else:
        await carry_out_wrongly(server, last, state.kind)


def classes_of(step: Actions) -> tuple[ActionClass, ...]:
    """What a critic is told that was done in a step."""
    kinds = dict.fromkeys(action.action for action in step if action.action != "add_vertex")
    return cast("tuple[ActionClass, ...]", tuple(kinds) or ("none",))


@dataclass
class _Measured:
    """What was judged so far."""

    critic: str
    seed: int
    cases: list[JudgedCase] = field(default_factory=list)
    left_out: Counter[LeftOut] = field(default_factory=Counter)
    stopped: str = ""

    def add(self, case: JudgedCase | LeftOut) -> None:
        """One case more."""
        if isinstance(case, JudgedCase):
            self.cases.append(case)
        else:
            self.left_out[case] += 1

    def count(self, *, right: bool) -> int:
        """How many states of a sort were judged."""
        return sum((case.kind == "right") == right for case in self.cases)

    @property
    def said(self) -> str:
        """How far it is, in words."""
        right = sum(case.is_right for case in self.cases)
        return f"{len(self.cases)} states judged, {right} of them rightly"

    def counted(self, recorder: Recorder) -> CriticAccuracy:
        """The figures."""
        wrong = [case for case in self.cases if case.kind != "right"]
        rights = [case for case in self.cases if case.kind == "right"]
        return CriticAccuracy(
            self.critic,
            self.seed,
            _share(self.cases, lambda case: case.is_right),
            _share(wrong, _says_match),
            _share(rights, lambda case: case.verdict is not None and not _says_match(case)),
            _share(self.cases, lambda case: case.verdict is None),
            {kind: _share([case for case in wrong if case.kind == kind], _says_match) for kind in KINDS},
            self.left_out["refused"],
            self.left_out["alike"],
            total_tokens(recorder.totals),
            total_cost(recorder.totals),
            self.stopped,
            self.cases,
        )


def _says_match(case: JudgedCase) -> bool:
    return case.verdict == "MATCH"


def _share(cases: Sequence[JudgedCase], holds: Callable[[JudgedCase], bool]) -> Share:
    return share_of(sum(map(holds, cases)), len(cases))


def accuracy_lines(found: CriticAccuracy) -> Iterator[str]:
    """The figures for people, with 95 % intervals."""
    yield f"{found.critic}: accuracy {found.accuracy.text}"
    yield f"wrong states taken for a match: {found.false_match.text}"
    for kind, share in found.false_match_by_kind.items():
        yield f"  {kind}: {share.text}"
    yield f"right states taken for a mismatch: {found.false_mismatch.text}"
    yield f"no verdict: {found.no_verdict.text}"
    if found.refused or found.alike:
        yield f"left out: {found.refused} that could not be made, {found.alike} wrong ones that look like the right one"
    if found.tokens:
        cost = "price not known" if found.cost is None else f"${found.cost:.4f}"
        yield f"{found.tokens:,} tokens, {cost}"
