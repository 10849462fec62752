"""How well the keyframes of films are found, when hands, lamps, cameras and clocks make it hard. Prints JSON.

    python benchmarks/keyframes.py [--films N] [--seed N] [--troubles NAME ...] [--keep FOLDER]

N films of each kind of trouble are painted from programs, their states known. A keyframe finds a state when the
paper lies finished in its image. `missed` are states that no keyframe finds; `twice` keyframes of states that
were found already; `midway` keyframes of paper in the making; `covered` states found under a hand although the
film shows them without one for half a second. Beside the product's proposals stand two plain ways: `still`, every
span without motion (of the same least length), and `spaced`, images at even intervals, as many as there are states.

Seeds below 100 are for development, figures that are reported anywhere use seeds from 100 on.
"""

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from filming import Film, make_film
from folding_schemas.actions import Program
from folding_server.errors import PhotoError
from folding_server.frames.keyframes import RATE, STILL_SECONDS, WATCHED_SIDE, propose_keyframes
from folding_server.frames.sequence_writer import write_sequence
from folding_server.frames.stillness import still_spans
from folding_server.frames.video import open_video
from folding_server.interchange.programs import load_program
from folding_server.photographer.rng import stream
from reconstruction.studio import seed_of
from screenplay import TROUBLES, Seen

PROGRAMS = Path(__file__).resolve().parent / "reconstruction" / "programs"
STEPS = 6
"""Films show at most this many steps of a program."""
BARE_SECONDS = 0.5
Score = dict[str, int]


def proposed(film: Film) -> Sequence[int]:
    """The product's keyframes."""
    try:
        return propose_keyframes(film.path)
    except PhotoError:
        return []


def every_still(film: Film) -> Sequence[int]:
    """The middle of every span without motion."""
    return [
        still.index
        for still in still_spans(open_video(film.path).moments(WATCHED_SIDE, RATE), STILL_SECONDS).stills
    ]


def evenly_spaced(film: Film) -> Sequence[int]:
    """As many images as there are states, at even intervals."""
    ends = np.arange(film.states) + 0.5
    wanted = ends / film.states * film.times[-1]
    return [int(np.abs(np.array(film.times) - second).argmin()) for second in wanted]


WAYS: dict[str, Callable[[Film], Sequence[int]]] = {
    "proposed": proposed,
    "still": every_still,
    "spaced": evenly_spaced,
}


def score(film: Film, keyframes: Sequence[int]) -> Score:
    """Counts of states, keyframes, and of what is right and wrong with them."""
    shown = [film.shows[index] for index in keyframes]
    finished = [(state, seen) for state, seen in shown if seen is not Seen.MAKING]
    found = {state for state, _ in finished}
    bare = {state for state, seen in finished if seen is Seen.BARE}
    return {
        "states": film.states,
        "keyframes": len(keyframes),
        "found": len(found),
        "missed": film.states - len(found),
        "twice": len(finished) - len(found),
        "midway": len(shown) - len(finished),
        "covered": len((found - bare) & bare_states(film)),
    }


def bare_states(film: Film) -> set[int]:
    """The states that the film shows without a hand for at least BARE_SECONDS on end."""
    states, start = set(), 0
    for index in range(1, len(film.times) + 1):
        if index == len(film.times) or film.shows[index] != film.shows[start]:
            state, seen = film.shows[start]
            if seen is Seen.BARE and film.times[index - 1] - film.times[start] >= BARE_SECONDS:
                states.add(state)
            start = index
    return states


def film_of(trouble: str, number: int, seed: int, folder: Path) -> Film:
    """The film of this number: another program, level and scene for each."""
    rng = stream(seed_of(f"{trouble} {number}", seed), "casting")
    files = sorted(PROGRAMS.glob("*.json"))
    file = files[int(rng.integers(len(files)))]
    path = folder / f"{trouble}-{number}-{file.stem}.mp4"
    return make_film(
        shortened(file), path, trouble, level=1 + number % 3, seed=seed_of(trouble, seed + 1000 * number)
    )


def shortened(path: Path) -> Program:
    """The first steps of a program."""
    program = load_program(path.read_text(encoding="utf-8"))
    return program.model_copy(update={"steps": program.steps[:STEPS]})


def total(scores: Iterable[Score]) -> Score:
    """The sum of several scores."""
    counts: Counter[str] = Counter()
    for one in scores:
        counts.update(one)
    return dict(counts)


def measure(film: Film) -> dict[str, Any]:
    """The scores of every way with one film, and the processor's seconds for each second of it."""
    row: dict[str, Any] = {"film": film.path.stem, "seconds": round(film.times[-1], 1)}
    for way, keyframes in WAYS.items():
        busy = time.process_time()
        indices = keyframes(film)
        seconds = time.process_time() - busy
        row[way] = score(film, indices)
        if way == "proposed":
            row["cpu_seconds_per_second"] = round(seconds / film.times[-1], 3)
            row["indices"] = list(indices)
    return row


def main() -> None:
    """Film, measure, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--films", type=int, default=3, help="films of each kind of trouble")
    parser.add_argument("--seed", type=int, default=1, help="development: 1 to 99")
    parser.add_argument("--troubles", nargs="+", choices=list(TROUBLES), default=list(TROUBLES))
    parser.add_argument("--keep", type=Path, help="keep the films here, with a sequence folder for each")
    options = parser.parse_args()
    with TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        rows: dict[str, list[dict[str, Any]]] = {trouble: [] for trouble in options.troubles}
        for trouble in options.troubles:
            for number in range(options.films):
                film = film_of(trouble, number, options.seed, folder)
                row = measure(film)
                rows[trouble].append(row)
                sys.stderr.write(f"{row['film']}: {row['proposed']}\n")
                if options.keep and row["indices"]:
                    write_sequence(film.path, film.path.with_suffix(""), row["indices"])
    overall = {
        trouble: {way: total(row[way] for row in films) for way in WAYS} for trouble, films in rows.items()
    }
    together = {way: total(kind[way] for kind in overall.values()) for way in WAYS}
    json.dump({"overall": together, "troubles": overall, "films": rows}, sys.stdout, indent=1)
    sys.stdout.write("\n")


if __name__ == "__main__":
    main()
