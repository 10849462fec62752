"""The sequences of a batch: folders in a folder, or those that a file lists. They are yielded one by one, so that a million fit."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from folding_client.interrupts import UsageError


@dataclass(frozen=True)
class Shard:
    """The ``number``-th of ``count`` parts of a corpus, from 1, by the names of the sequences."""

    number: int
    count: int

    def holds(self, sequence: Path) -> bool:
        """Whether a sequence belongs to this part, and so to no other."""
        digest = sha256(sequence.name.encode()).digest()
        return int.from_bytes(digest[:8], "big") % self.count == self.number - 1


def shard_of(text: str) -> Shard:
    """A part as one writes it, such as ``3/16``. UsageError for anything else."""
    number, _, count = text.partition("/")
    if number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
        return Shard(int(number), int(count))
    message = f"--shard cannot be {text!r}; give a part and the number of parts, such as 3/16."
    raise UsageError(message)


def sequences_of(source: Path) -> list[Path]:
    """The sequence folders in a folder, in order of name, or those that a manifest lists, one a line or as
    JSON.

    UsageError if there are none, or two have the same name.
    """
    found = list(iter_sequences(source))
    if not found:
        raise no_sequence(source)
    names = [folder.resolve().name for folder in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise same_name(source, twice[0])
    return found


def iter_sequences(source: Path) -> Iterator[Path]:
    """The same one by one, neither counted nor compared. UsageError for a file that cannot be read."""
    return _in_folder(source) if source.is_dir() else _in_manifest(source)


def absolute_folders(sequences: Iterable[Path], shard: Shard | None = None) -> Iterator[Path]:
    """The sequences by absolute paths, those of a part of the corpus alone if one is given."""
    for sequence in sequences:
        folder = sequence.resolve()
        if shard is None or shard.holds(folder):
            yield folder


def no_sequence(source: Path) -> UsageError:
    """That a source has nothing to reconstruct."""
    message = f"{source} holds no sequence; name a folder of folders with keyframes.json, or a list of such folders."
    return UsageError(message)


def same_name(source: Path, name: str) -> UsageError:
    """That two runs would share a folder."""
    message = f"{source} lists two sequences named {name}; their runs would share a folder, so rename one."
    return UsageError(message)


def _in_folder(source: Path) -> Iterator[Path]:
    if (source / "keyframes.json").is_file():
        yield source
        return
    for name in sorted(entry.name for entry in source.iterdir()):
        if (source / name / "keyframes.json").is_file():
            yield source / name


def _in_manifest(source: Path) -> Iterator[Path]:
    try:
        with source.open(encoding="utf-8") as file:
            first = file.readline()
            file.seek(0)
            listed = json.load(file) if first.lstrip().startswith("[") else file
            for entry in listed:
                path = str(entry).strip()
                if path and not path.startswith("#"):
                    yield source.parent / path
    except OSError as error:
        message = f"Cannot read {source}: {error.strerror}. Name a folder of sequences, or a list of folders."
        raise UsageError(message) from error
    except ValueError as error:
        message = f"{source} is not a list of folders: {error}."
        raise UsageError(message) from error
