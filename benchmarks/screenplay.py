"""What happens in a film of someone folding a program, beat by beat, drawn from a seed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np
from folding_server.photographer.movements import Movement, Swing
from folding_server.photographer.rng import stream


class Seen(Enum):
    """What an image shows of a state: finished without a hand, finished with one in the picture, or in the making."""

    BARE = "bare"
    HELD = "held"
    MAKING = "making"


@dataclass(frozen=True)
class Trouble:
    """What goes wrong in a film: chances at each step, for light and camera at each beat.

    ``resting`` a hand stays on the finished paper for up to two seconds; ``never_bare`` it stays until the next
    step begins; ``idle`` a hand comes and changes nothing; ``pauses`` the paper is held half way for up to
    1.4 seconds; ``lamp`` the light changes; ``bumps`` the camera is nudged for good; ``uneven`` images come
    at uneven times.
    """

    resting: float = 0.0
    never_bare: float = 0.0
    idle: float = 0.0
    pauses: float = 0.0
    lamp: float = 0.0
    bumps: float = 0.0
    uneven: bool = False


TROUBLES = {
    "plain": Trouble(),
    "hands": Trouble(resting=0.7, never_bare=0.25, idle=0.3),
    "pauses": Trouble(pauses=0.6),
    "lamp": Trouble(lamp=0.12),
    "bumps": Trouble(bumps=0.08),
    "uneven": Trouble(uneven=True),
    "all": Trouble(0.5, 0.15, 0.2, 0.3, 0.06, 0.04, uneven=True),
}


@dataclass(frozen=True)
class Beat:
    """A stretch of a film.

    ``state`` counts finished states from 0. ``movement`` counts those of the step that led to it, or that leads
    on from it if the hand is just ``coming``; the paper is ``done`` from one part of it to another, 0 to 1.
    ``hand`` says how far in the hand is at the beginning and the end (0 out of the picture, 1 at the paper),
    ``sway`` whether it moves about there.
    """

    seconds: float
    state: int
    seen: Seen
    hand: tuple[float, float] = (0.0, 0.0)
    movement: int = 0
    done: tuple[float, float] = (1.0, 1.0)
    sway: bool = False
    coming: bool = False

    @property
    def step(self) -> int:
        """The number of the step, from 0, whose hand it is."""
        return self.state if self.coming else self.state - 1


def screenplay(steps: Sequence[Sequence[Movement]], trouble: Trouble, seed: int) -> list[Beat]:
    """The beats of a film: a rest, then for each step a hand that comes, what it does, how it goes, a rest."""
    rng = stream(seed, "screenplay")
    beats = [_rest(rng, 0)]
    for state, movements in enumerate(steps, 1):
        if beats[-1].hand[1] == 0:
            seconds = rng.uniform(0.3, 0.6)
            beats.append(Beat(seconds, state - 1, Seen.HELD, (0.0, 1.0), 0, (0.0, 0.0), coming=True))
        for number, movement in enumerate(movements):
            beats += _moving(rng, state, number, trouble.pauses * isinstance(movement, Swing))
        last = len(movements) - 1
        beats.append(_holding(state, last, rng.uniform(0.3, 0.8), sway=True))
        beats += _ending(rng, state, last, trouble, final=state == len(steps))
    return beats


def _rest(rng: np.random.Generator, state: int) -> Beat:
    return Beat(rng.uniform(0.7, 1.8), state, Seen.BARE)


def _holding(state: int, movement: int, seconds: float, *, sway: bool = False) -> Beat:
    """A hand on the finished paper."""
    return Beat(seconds, state, Seen.HELD, (1.0, 1.0), movement, sway=sway)


def _moving(rng: np.random.Generator, state: int, number: int, pauses: float) -> Iterator[Beat]:
    """A movement, with a pause somewhere in the middle if chance will have it."""
    seconds = rng.uniform(0.6, 1.1)
    stops = [float(rng.choice([rng.uniform(0.25, 0.45), rng.uniform(0.55, 0.8)]))]
    for start, end in pairwise([0.0, *(stops if rng.random() < pauses else []), 1.0]):
        yield Beat(seconds * (end - start), state, Seen.MAKING, (1.0, 1.0), number, (start, end))
        if end < 1:
            yield Beat(rng.uniform(0.5, 1.4), state, Seen.MAKING, (1.0, 1.0), number, (end, end))


def _ending(
    rng: np.random.Generator, state: int, last: int, trouble: Trouble, *, final: bool
) -> Iterator[Beat]:
    """How a step ends: a hand that rests, goes, and comes back for nothing, as trouble will have it."""
    stays = not final and rng.random() < trouble.never_bare
    if stays or rng.random() < trouble.resting:
        yield _holding(state, last, rng.uniform(1.2, 2.2) if stays else rng.uniform(0.5, 2.0))
    if stays:
        return
    yield Beat(rng.uniform(0.3, 0.6), state, Seen.HELD, (1.0, 0.0), last)
    yield _rest(rng, state)
    if rng.random() < trouble.idle:
        yield Beat(rng.uniform(0.3, 0.6), state, Seen.HELD, (0.0, 1.0), last)
        yield _holding(state, last, rng.uniform(0.4, 1.6), sway=bool(rng.random() < 0.5))
        yield Beat(rng.uniform(0.3, 0.6), state, Seen.HELD, (1.0, 0.0), last)
        yield _rest(rng, state)
