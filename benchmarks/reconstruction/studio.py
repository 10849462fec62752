"""Photographs of programs, taken once and kept for the same program, seed, level, images in between and photographer."""

import hashlib
import shutil
import tempfile
import zlib
from functools import cache
from pathlib import Path

import folding_server.photographer
import folding_server.simulator
from folding_schemas.actions import Program
from folding_server.interchange.programs import load_program, program_text
from folding_server.photographer import photograph

CACHE = Path(tempfile.gettempdir()) / "foldingagent-reconstruction"
"""Where photographs are kept unless another folder is named."""


def photographed(program: Program, seed: int, level: int, folder: Path, between: int = 0) -> Path:
    """The sequence folder of a program at a level, photographed unless it is in ``folder`` already.

    ``between`` images show the paper on its way from each keyframe to the next.
    """
    own_seed = seed_of(program.name, seed)
    what = f"{program_text(program)} {own_seed} {level} {between} {version()}"
    key = hashlib.sha256(what.encode()).hexdigest()[:16]
    place = folder / f"{program.name}-{level}-{seed}-{key}"
    if not place.exists():
        folder.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(dir=folder))
        photograph(program, fresh, own_seed, level, between=between)
        _settle(fresh, place)
    return place


def seed_of(name: str, seed: int) -> int:
    """The photographer's seed for a program: every program gets a scene of its own."""
    return zlib.crc32(f"{name}:{seed}".encode())


def folded_truth(place: Path) -> Program:
    """The program as it was folded for the photos, with its imprecision."""
    return load_program((place / "program.json").read_text(encoding="utf-8"))


@cache
def version() -> str:
    """A digest of the sources that decide what photographs look like."""
    digest = hashlib.sha256()
    for package in (folding_server.photographer, folding_server.simulator):
        for path in sorted(Path(str(package.__file__)).parent.glob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _settle(fresh: Path, place: Path) -> None:
    """Put a finished folder in its place, unless another process was faster."""
    try:
        fresh.rename(place)
    except OSError:
        shutil.rmtree(fresh)
        if not place.exists():
            raise
