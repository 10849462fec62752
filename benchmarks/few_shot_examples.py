"""Write the solved transitions that ``--few-shot`` shows: photos, states, actions and crease patterns of a
program.

    python benchmarks/few_shot_examples.py

They are made from ``few_shot/program.json`` in the prompts package and written beside it. Prints what it
wrote as JSON.
"""

import json
import tempfile
from itertools import chain
from pathlib import Path
from typing import Any

from folding_schemas.actions import Program
from folding_server.frames.sequences import load_sequence
from folding_server.interchange.fold_format import crease_pattern_document
from folding_server.photographer.photographing import photograph
from folding_server.simulator import Paper, folded_state, replay
from PIL import Image

FOLDER = Path(__file__).resolve().parents[1] / "prompts" / "folding_prompts" / "few_shot"
TRANSITIONS = (5, 1, 2)
"""Steps of the program, from easy to hard: an unfold, a fold between corners, a fold between new vertices."""
LONGEST_SIDE = 512
KEPT = ("vertices_coords", "edges_vertices", "edges_assignment")


def main() -> None:
    """Make the examples."""
    program = Program.model_validate_json((FOLDER / "program.json").read_text())
    with tempfile.TemporaryDirectory() as folder:
        photograph(program, Path(folder) / "photos", seed=5, level=1)
        examples = [_example(program, Path(folder) / "photos", step) for step in TRANSITIONS]
    text = json.dumps(examples, indent=1) + "\n"
    (FOLDER / "examples.json").write_text(text)
    print(
        json.dumps(
            {"examples": len(examples), "bytes": sum(file.stat().st_size for file in FOLDER.iterdir())}
        )
    )


def _example(program: Program, photos: Path, step: int) -> dict[str, Any]:
    before, after = _paper(program, step - 1), _paper(program, step)
    return {
        "before": _photo(photos, step),
        "after": _photo(photos, step + 1),
        "state": folded_state(before).model_dump(mode="json"),
        "actions": [action.model_dump(mode="json", exclude_none=True) for action in program.steps[step - 1]],
        "pattern_before": _pattern(before),
        "pattern_after": _pattern(after),
    }


def _paper(program: Program, steps: int) -> Paper:
    return replay(chain.from_iterable(program.steps[:steps]))


def _pattern(paper: Paper) -> dict[str, Any]:
    document = crease_pattern_document(paper)
    return {key: document[key] for key in KEPT}


def _photo(photos: Path, frame: int) -> str:
    name = f"frame{frame}.jpg"
    picture = Image.fromarray(load_sequence(photos).photo(frame))
    picture.thumbnail((LONGEST_SIDE, LONGEST_SIDE))
    picture.save(FOLDER / name, quality=85)
    return name


if __name__ == "__main__":
    main()
