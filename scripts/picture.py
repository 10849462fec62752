"""Draw a picture of a run: the photos above, the folded states that were recovered below.

python scripts/picture.py RUN_FOLDER PICTURE.png
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from folding_schemas.actions import Program
from folding_server.arrays import RgbImage
from folding_server.diagram import draw_svg, rasterise
from folding_server.diagram.palette import colors_of
from folding_server.frames.image_files import decode_bytes
from folding_server.frames.panels import Size, Tile, table
from folding_server.frames.sequences import load_sequence
from folding_server.interchange.programs import load_program
from folding_server.simulator import Paper, apply, new_paper
from PIL import Image

WIDTH = 1800
SIDE = 480


def states(program: Program) -> Iterator[Paper]:
    """The paper at every keyframe."""
    paper = new_paper(program.sheet)
    yield paper
    for step in program.steps:
        for action in step:
            paper = apply(paper, action)
        yield paper


def picture(run: Path) -> RgbImage:
    """Photos and diagrams of a run in two rows."""
    sequence = load_sequence(Path(json.loads((run / "run.json").read_text())["sequence"]["folder"]))
    program = load_program((run / "program.json").read_text())
    colors = colors_of(sequence.front_color, sequence.back_color)
    diagrams = [
        decode_bytes(rasterise(draw_svg(paper, colors), SIDE), "diagram") for paper in states(program)
    ]
    photos = [sequence.photo(frame) for frame in range(1, len(diagrams) + 1)]
    numbered = [Tile(photo, str(frame)) for frame, photo in enumerate(photos, start=1)]
    return table([numbered, [Tile(diagram) for diagram in diagrams]], Size(WIDTH, WIDTH))


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path)
    parser.add_argument("picture", type=Path)
    given = parser.parse_args()
    Image.fromarray(picture(given.run)).quantize(128).save(given.picture, optimize=True)


if __name__ == "__main__":
    main()
