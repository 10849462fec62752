"""Verdicts and numbers of layer orders of random patterns, beside those of rabbit-ear."""

import json
import shutil
import subprocess
from pathlib import Path
from random import Random

from folding_server.interchange.pattern_files import written_pattern
from folding_server.simulator.foldability import CreasePattern, check_pattern, pattern_of
from known_patterns import flipped, map_of, miura, random_map, strip, twist
from papers import random_paper

PEERS = Path(__file__).parent / "peers"


def lettered(seed: int) -> CreasePattern:
    """A random pattern of which every letter is given: a paper that was folded, a map, a strip that may not fold."""
    random = Random(seed)  # noqa: S311
    match seed % 5:
        case 0:
            return pattern_of(random_paper(seed, 3))
        case 1:
            return random_map(random.choice((2, 3)), random.choice((2, 3)), seed)
        case 2:
            return flipped(random_map(3, 3, seed), random.randrange(4))
        case 3:
            return miura(random.choice((2, 3)), random.choice((2, 3, 4)), random.uniform(0.02, 0.08))
    widths = [random.choice((1, 1.5, 2)) for _ in range(6)]
    return strip(widths, "".join(random.choice("MV") for _ in range(5)))


def patterns() -> list[CreasePattern]:
    """Random patterns, twists, and maps of which nothing is lettered."""
    fixed = [twist(4, 1.0, "VM"), twist(4, 1.0), map_of(2, 2, "U" * 4), map_of(2, 3, "U" * 7)]
    return [*map(lettered, range(60)), *fixed]


def peer_counts(given: list[CreasePattern], folder: Path) -> list[int | None]:
    """What rabbit-ear counts, None where it finds no order."""
    node = shutil.which("node")
    assert node, "node is not installed"
    assert (PEERS / "node_modules").is_dir(), "run: npm ci --prefix tests/peers"
    files = [folder / f"{k}.fold" for k in range(len(given))]
    for file, pattern in zip(files, given, strict=True):
        file.write_text(written_pattern(pattern, ".fold"), encoding="utf-8")
    run = subprocess.run(
        [node, PEERS / "layers.js", *files], capture_output=True, text=True, check=False, timeout=200
    )
    assert run.returncode == 0, run.stderr
    counts: list[int | None] = json.loads(run.stdout)
    return counts


def test_a_peer_counts_as_many_layer_orders(tmp_path: Path) -> None:
    """rabbit-ear asks the layers alone: where a vertex fails, ours says so first."""
    given = patterns()
    reports = [check_pattern(pattern, None) for pattern in given]
    counts = peer_counts(given, tmp_path)
    compared = [
        (k, report.states, count or 0)
        for k, (report, count) in enumerate(zip(reports, counts, strict=True))
        if not report.violations
    ]
    assert [(k, count) for k, _, count in compared] == [(k, states) for k, states, _ in compared]
    assert sum(states == 0 for _, states, _ in compared) >= 3
    assert sum(states > 1 for _, states, _ in compared) >= 3
