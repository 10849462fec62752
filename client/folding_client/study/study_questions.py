"""Which pairs a user study shows: frames of the sequences that both folders of runs completed."""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from folding_client.batch.sequence_lists import sequences_of
from folding_client.interrupts import UsageError
from folding_client.reconstruct import sequence_name
from folding_client.report.recorded_runs import find_runs
from folding_client.report.run_pages import RunPage, gather_page
from folding_client.report.run_scores import Evaluations
from folding_client.report.server_pictures import PicturedRun
from folding_client.report.site_files import content_key
from folding_client.study.study_files import KeyedQuestion, StudySide


@dataclass(frozen=True)
class JointSequence:
    """A sequence that both sides completed, as pictures can be made of it."""

    name: str
    sides: Mapping[StudySide, PicturedRun]

    @property
    def frames(self) -> range:
        """The frames that a question can be about: all but the flat sheet."""
        return range(2, min(len(run.steps) for run in self.sides.values()) + 1)


def joint_sequences(first: Path, second: Path, truth: Path) -> list[JointSequence]:
    """The sequences of a folder that both folders of runs completed, in order of name. UsageError if there are none."""
    photos = {sequence_name(folder): folder.resolve() for folder in sequences_of(truth)}
    sides: dict[StudySide, dict[str, RunPage]] = {"first": _completed(first), "second": _completed(second)}
    names = sorted(photos.keys() & sides["first"].keys() & sides["second"].keys())
    if not names:
        message = (
            f"No sequence of {truth} is completed in both {first} and {second}; a study compares the sequences that both "
            "completed."
        )
        raise UsageError(message)
    joint = [
        JointSequence(name, {side: _pictured(runs[name], photos[name]) for side, runs in sides.items()})
        for name in names
    ]
    if not any(each.frames for each in joint):
        message = f"The sequences of {truth} that both completed have no frame after the flat sheet; there is nothing to compare."
        raise UsageError(message)
    return joint


def _completed(root: Path) -> dict[str, RunPage]:
    """The completed runs in a folder by sequence. UsageError if one was completed twice."""
    found: dict[str, RunPage] = {}
    for place in find_runs([root]):
        page = gather_page(place, Evaluations(()))
        if page.run.status != "complete" or len(page.pictured.steps) < len(page.frames):
            continue
        name = page.run.sequence
        if name in found:
            message = (
                f"{root} holds two completed runs of {name}, in {found[name].run.place.folder} and {place.folder}; name a "
                "folder with one run of each sequence."
            )
            raise UsageError(message)
        found[name] = page
    return found


def _pictured(page: RunPage, photos: Path) -> PicturedRun:
    """The run with the photos of the truth."""
    return PicturedRun(photos, page.run.sequence, len(page.frames), page.pictured.steps)


def draw_questions(
    sequences: Sequence[JointSequence], count: int, seed: int, *, last_only: bool = False
) -> list[KeyedQuestion]:
    """Up to ``count`` questions in the order in which they are asked. Each sequence comes as often as any other while it has
    frames left; frames, order and sides are drawn by the seed, each side being on the left as often as on the right, or once
    more.
    """
    chance = random.Random(seed)
    frames = {each.name: list(each.frames)[-1:] if last_only else list(each.frames) for each in sequences}
    for left in frames.values():
        chance.shuffle(left)
    drawn: list[tuple[str, int]] = []
    while len(drawn) < count and any(frames.values()):
        for name in chance.sample(sorted(frames), len(frames)):
            if frames[name] and len(drawn) < count:
                drawn.append((name, frames[name].pop()))
    chance.shuffle(drawn)
    lefts = _balanced_sides(len(drawn), chance)
    return [
        KeyedQuestion(
            question=content_key("question", chance.getrandbits(128)), sequence=name, frame=frame, left=left
        )
        for (name, frame), left in zip(drawn, lefts, strict=True)
    ]


def _balanced_sides(count: int, chance: random.Random) -> list[StudySide]:
    sides: list[StudySide] = ["first", "second"]
    chance.shuffle(sides)
    dealt = [sides[number % 2] for number in range(count)]
    chance.shuffle(dealt)
    return dealt
