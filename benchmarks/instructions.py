"""Time sheets, words and films of 12 steps and print JSON: python benchmarks/instructions.py [--repeats N] [--film].

The program is the first twelve moves of the example heart. A PDF has a goal of 1 s, a film as MP4 at 720p of 10 s, which is
written once with --film. Times are of the wall clock, in seconds, the least of the repeats, in a process that has loaded what it needs;
beside them is the processor's time of the same call, which other programs on the machine do not lengthen as much.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from folding_schemas.actions import Program
from folding_server.animation.film_files import write_film
from folding_server.instructions.moves import Lesson, lesson_of
from folding_server.instructions.sheet_files import sheet_content
from folding_server.instructions.sheet_layout import SheetForm
from folding_server.interchange.programs import load_published
from folding_server.wording.sheet_words import lesson_words

HEART = Path(__file__).resolve().parents[1] / "examples" / "programs" / "heart.json"
STEPS = 12
GOALS = {"pdf": 1.0, "mp4": 10.0}


def lesson_of_twelve() -> Lesson:
    """A lesson of twelve moves."""
    program = load_published(HEART.read_text(encoding="utf-8")).program
    for count in range(len(program.steps), 0, -1):
        lesson = lesson_of(Program(name="heart", steps=program.steps[:count]))
        if len(lesson.moves) <= STEPS:
            return lesson
    raise AssertionError


def least(work: Callable[[], object], repeats: int) -> dict[str, float]:
    """The least time of some calls, on the wall and of the processor."""
    times = []
    for _ in range(repeats):
        wall, processor = time.perf_counter(), time.process_time()
        work()
        times.append((time.perf_counter() - wall, time.process_time() - processor))
    return {"wall": round(min(t for t, _ in times), 3), "processor": round(min(t for _, t in times), 3)}


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--film", action="store_true")
    options = parser.parse_args()
    lesson, form = lesson_of_twelve(), SheetForm()
    seconds = {
        "words": least(lambda: lesson_words(lesson), options.repeats),
        **{
            kind: least(lambda kind=kind: sheet_content(lesson, f".{kind}", form, {}), options.repeats)  # type: ignore[misc]
            for kind in ("pdf", "svg", "html")
        },
    }
    sizes = {"pdf": len(sheet_content(lesson, ".pdf", form, {}))}
    if options.film:
        with tempfile.TemporaryDirectory() as folder:
            file, words = Path(folder) / "heart.mp4", [each.text for each in lesson_words(lesson)]
            seconds["mp4"] = least(lambda: write_film(lesson, words, file, "tilted"), 1)
            sizes["mp4"] = file.stat().st_size
    print(
        json.dumps({"moves": len(lesson.moves), "goals": GOALS, "seconds": seconds, "bytes": sizes}, indent=1)
    )


if __name__ == "__main__":
    main()
