"""The long part of adding a sequence: finding the keyframes of a film, and writing the folder; paths in, numbers out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from folding_server.errors import PhotoError
from folding_server.frames.filmstrip import evenly_spaced
from folding_server.frames.image_supply import ImageSupply, NamedPhotos
from folding_server.frames.sequence_folder import DeclaredSheet, PartDone, fill_folder, require_images

MOST_KEYFRAMES = 500
"""Of an added sequence: more than ten times the steps of a long diagram, and as many photos as a person can look over."""

AROUND = 3
"""How many images before the first keyframe, and after the last, the contact sheet has."""

_SEARCHED = 0.8
"""The part of the work that finding keyframes is, as progress is told: decoding a film takes longer than writing some images."""


@dataclass(frozen=True)
class SequenceMaterial:
    """What a sequence is to be made of: one film, or photos in order. Errors name the files as ``called``."""

    files: tuple[Path, ...]
    called: tuple[str, ...]
    film: bool


@dataclass(frozen=True)
class BuiltSequence:
    """What was written: keyframes by index, with their seconds in a film, and at which of them something is ``moving``; how many
    images there were; labels of those written.
    """

    keyframes: tuple[int, ...]
    seconds: tuple[float, ...] | None
    images: int
    labels: dict[int, str]
    moving: tuple[int, ...] = ()


def build_sequence(
    material: SequenceMaterial,
    keyframes: Sequence[int] | None,
    paper: DeclaredSheet,
    folder: Path,
    progress: PartDone,
    still_seconds: float | None = None,
) -> BuiltSequence:
    """Write a sequence into an empty folder; its keyframes are those given, else proposed for a film, all of the photos.

    ``still_seconds`` is the shortest rest of a keyframe that is proposed. ``progress`` may raise, which ends the work. PhotoError if a file cannot be read or a keyframe is not there, OSError if
    the folder cannot be written.
    """
    if not material.film:
        photos = NamedPhotos(material.files, material.called)
        numbers = range(1, len(material.files) + 1)
        return _built(photos, numbers, tuple(keyframes or numbers), paper, folder, progress)
    return _built_of_film(material, keyframes, paper, folder, progress, still_seconds)


def _built_of_film(
    material: SequenceMaterial,
    keyframes: Sequence[int] | None,
    paper: DeclaredSheet,
    folder: Path,
    progress: PartDone,
    still_seconds: float | None,
) -> BuiltSequence:
    from folding_server.frames.films import open_film  # noqa: PLC0415  (may load the video library)
    from folding_server.frames.keyframes import (  # noqa: PLC0415
        STILL_SECONDS,
        KeyframeProposal,
        keyframe_proposal,
    )

    path, name = material.files[0], material.called[0]
    try:
        film = open_film(path)
        found = (
            KeyframeProposal(tuple(keyframes))
            if keyframes
            else keyframe_proposal(
                path, still_seconds or STILL_SECONDS, lambda part: progress(_SEARCHED * part)
            )
        )
        start = 0.0 if keyframes else _SEARCHED

        def rest(part: float) -> None:
            progress(start + (1 - start) * part)

        built = _built(film, film.indices(), found.indices, paper, folder, rest, found.moving)
    except PhotoError as error:
        raise PhotoError(str(error).replace(path.name, name)) from error
    return replace(built, seconds=tuple(film.times[index] for index in built.keyframes))


def _around(indices: Sequence[int], keyframes: Sequence[int]) -> list[int]:
    """Some images before the first keyframe and after the last, for whoever finds that one is missing there."""
    before = [index for index in indices if index < keyframes[0]]
    after = [index for index in indices if index > keyframes[-1]]
    return [*evenly_spaced(before, AROUND), *evenly_spaced(after, AROUND)]


def _built(
    images: ImageSupply,
    indices: Sequence[int],
    keyframes: tuple[int, ...],
    paper: DeclaredSheet,
    folder: Path,
    progress: PartDone,
    moving: tuple[int, ...] = (),
) -> BuiltSequence:
    if len(keyframes) > MOST_KEYFRAMES:
        raise PhotoError(
            f"{len(keyframes)} keyframes are more than the {MOST_KEYFRAMES} that a sequence may have: "
            "give the numbers of fewer as keyframes"
        )
    require_images(images, keyframes)
    around = _around(indices, keyframes)
    written = fill_folder(
        folder, images, keyframes, around=around, moving=moving, paper=paper, progress=progress
    )
    labels = {index: images.label(index) for index in written}
    return BuiltSequence(keyframes, None, len(indices), labels, moving)
