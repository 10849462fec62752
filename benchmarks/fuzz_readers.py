"""Damaged crease patterns: ``python benchmarks/fuzz_readers.py --inputs 20000 [--seed N]``. Prints one JSON document.

Files of every kind are cut short, nested deeply, made large and given wrong types; reading and checking each may take 10 seconds and
1 GB, and ends in an answer or in one sentence. What does not is listed with the seed that makes it.
"""

import argparse
import json
import re
import resource
import time
from collections import Counter
from random import Random
from typing import Any

from folding_server.errors import FoldingError
from folding_server.interchange.pattern_files import read_patterns
from folding_server.simulator.foldability import Counting, check_pattern

SECONDS = 10.0
MEGABYTES = 1000
_POINTS = "[[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]"
_LINES = [
    (1, 0, 0, 9, 0),
    (1, 9, 0, 9, 9),
    (1, 9, 9, 0, 9),
    (1, 0, 9, 0, 0),
    (2, 0, 0, 9, 9),
    (3, 0, 9, 9, 0),
]
_COLORS = {1: "black", 2: "red", 3: "blue"}
_ORI = {1: "BLACK_0", 2: "RED_1", 3: "BLUE_2"}
_DXF = {1: 7, 2: 1, 3: 5}
SEEDS: dict[str, str] = {
    ".fold": '{"file_spec": 1.2, "vertices_coords": '
    + _POINTS
    + ', "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]], "edges_assignment": ["B", "B", "B", '
    '"B", "M", "V", "M", "M"], "edges_foldAngle": [0, 0, 0, 0, -180, 180, -180, -180], "faces_vertices": [[0, 1, 4], [1, 2, 4], '
    '[2, 3, 4], [3, 0, 4]], "faceOrders": [[0, 1, 1]], "file_frames": [{"frame_classes": ["creasePattern"], "frame_inherit": '
    'true, "frame_parent": 0}]}',
    ".cp": "".join(f"{k} {a} {b} {c} {d}\n" for k, a, b, c, d in _LINES),
    ".ori": json.dumps(
        {
            "@version": "v1.1",
            "lineSegments": [
                {"a": f"{a},{b}", "b": f"{c},{d}", "color": _ORI[k]} for k, a, b, c, d in _LINES
            ],
        }
    ),
    ".opx": "<java><object class='oripa.DataSet'><void property='lines'><array class='oripa.OriLineProxy'>"
    + "".join(
        f"<void index='0'><object class='oripa.OriLineProxy'><void property='type'><int>{k}</int></void><void property='x0'><double>"
        f"{a}</double></void><void property='y0'><double>{b}</double></void><void property='x1'><double>{c}</double></void>"
        f"<void property='y1'><double>{d}</double></void></object></void>"
        for k, a, b, c, d in _LINES
    )
    + "</array></void></object></java>",
    ".svg": '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><style>.a{stroke:red}</style><g transform="scale(2)">'
    + "".join(
        f'<line x1="{a}" y1="{b}" x2="{c}" y2="{d}" stroke="{_COLORS[k]}"/>' for k, a, b, c, d in _LINES
    )
    + '<path class="a" d="M0 0C1 1 2 2 3 3z"/></g></svg>',
    ".dxf": "0\nSECTION\n2\nENTITIES\n"
    + "".join(
        f"0\nLINE\n8\n0\n62\n{_DXF[k]}\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for k, a, b, c, d in _LINES
    )
    + "0\nENDSEC\n0\nEOF\n",
}
"""One small sound file of each kind, by its ending."""
_VALUES = (
    "-1",
    "7",
    "1e400",
    "1e-300",
    "1e9",
    "NaN",
    "null",
    '"x"',
    "[]",
    "{}",
    "true",
    "0.5",
    "99999999999",
    "",
    "\\u0000",
    "-",
)
_PIECES = ("[", "]", "{", "}", "<", ">", '"', "<g>", "</g>", "<!--", "0\n", "&a;", "\n", " ", ",", "折")


def fuzzed(kind: str, random: Random) -> str:
    """A damaged file of a kind."""
    text = SEEDS[kind]
    for _ in range(random.randint(1, 3)):
        text = random.choice((_cut_short, _other_number, _other_piece, _doubled, _deep, _long))(text, random)
    return text


def _cut_short(text: str, random: Random) -> str:
    return text[: random.randrange(len(text) + 1)]


def _other_number(text: str, random: Random) -> str:
    found = list(re.finditer(r"-?\d+(\.\d+)?", text))
    if not found:
        return text
    place = random.choice(found)
    return text[: place.start()] + random.choice(_VALUES) + text[place.end() :]


def _other_piece(text: str, random: Random) -> str:
    at = random.randrange(len(text) + 1)
    return text[:at] + random.choice(_PIECES) + text[at + random.randint(0, 4) :]


def _doubled(text: str, random: Random) -> str:
    start, end = sorted(random.randrange(len(text) + 1) for _ in range(2))
    return text[:end] + text[start:end] + text[end:]


def _deep(text: str, random: Random) -> str:
    if random.random() < 0.8:
        return text
    opening = random.choice(("[", "{", '{"a":', "<g>", "<void>"))
    at = random.randrange(len(text) + 1)
    return text[:at] + opening * random.choice((100, 100_000)) + text[at:]


def _long(text: str, random: Random) -> str:
    if random.random() < 0.9:
        return text
    at = random.randrange(len(text) + 1)
    return text[:at] + text[at : at + 60] * random.choice((50, 500)) + text[at:]


def fate(kind: str, text: str) -> str:
    """What comes of a file: read, refused, or the error that may not come."""
    try:
        for read in read_patterns(text, kind, "all"):
            check_pattern(read.pattern, counting=Counting(seconds=0.1))
    except FoldingError as refused:
        return "refused" if "\n" not in str(refused) else "refused in more than one line"
    except Exception as error:  # noqa: BLE001 - what this looks for
        return f"{type(error).__name__}: {error}"[:200]
    return "read"


def main() -> None:
    """Try so many files and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    fates: Counter[str] = Counter()
    wrong: list[dict[str, Any]] = []
    longest = 0.0
    for number in range(options.inputs):
        kind = list(SEEDS)[number % len(SEEDS)]
        text = fuzzed(kind, Random(f"{options.seed} {number}"))
        started = time.perf_counter()
        came = fate(kind, text)
        seconds = time.perf_counter() - started
        longest = max(longest, seconds)
        fates[came if came in {"read", "refused"} else "wrong"] += 1
        if came not in {"read", "refused"} or seconds > SECONDS:
            wrong.append(
                {"kind": kind, "seed": f"{options.seed} {number}", "came": came, "seconds": round(seconds, 1)}
            )
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    document = {"inputs": options.inputs, **fates, "longest_seconds": round(longest, 2), "megabytes": memory}
    print(json.dumps({**document, "memory_kept": memory <= MEGABYTES, "wrong": wrong[:50]}, indent=1))


if __name__ == "__main__":
    main()
