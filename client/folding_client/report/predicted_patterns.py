"""The crease patterns that the variant ``vlm-cp`` predicted, as pictures."""

import json
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from folding_client.variants.vlm_cp import PatternReply

_STROKES = {
    "B": 'stroke="#222" stroke-width="0.008"',
    "M": 'stroke="#c02020" stroke-width="0.006"',
    "V": 'stroke="#1f5fd0" stroke-width="0.006" stroke-dasharray="0.02 0.01"',
    "F": 'stroke="#8b8d94" stroke-width="0.004"',
    "U": 'stroke="#8b8d94" stroke-width="0.004" stroke-dasharray="0.004 0.008"',
}
"""How lines are drawn, by the letters of the FOLD format; widths in sides of the sheet."""


def predicted_patterns(folder: Path) -> dict[int, str]:
    """By frame, the SVG of each pattern in a run folder that can be read."""
    try:
        patterns = json.loads((folder / "patterns.json").read_text(encoding="utf-8"))["patterns"]
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    found: dict[int, str] = {}
    for frame, pattern in enumerate(patterns if isinstance(patterns, list) else [], start=1):
        try:
            found[frame] = _drawn(PatternReply.model_validate(pattern))
        except ValidationError:
            continue
    return found


def _drawn(pattern: PatternReply) -> str:
    """The lines of a pattern on the unit square, y upwards, with a margin."""
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-0.06 -0.06 1.12 1.12"><rect x="-0.06" y="-0.06" '
        f'width="1.12" height="1.12" fill="#fff"/>{"".join(_lines(pattern))}</svg>'
    )


def _lines(pattern: PatternReply) -> Iterator[str]:
    for (start, end), letter in zip(pattern.edges_vertices, pattern.edges_assignment, strict=True):
        (x1, y1), (x2, y2) = pattern.vertices_coords[start], pattern.vertices_coords[end]
        yield f'<line x1="{x1:.4f}" y1="{1 - y1:.4f}" x2="{x2:.4f}" y2="{1 - y2:.4f}" {_STROKES[letter]}/>'
