"""Sequences of keyframes, and the library that serves them from the folders it was given, nowhere else."""

import hashlib
from collections.abc import Hashable, Iterable, Iterator
from collections.abc import Sequence as ListOf
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.filmstrip import MAX_STRIP_IMAGES, evenly_spaced, filmstrip
from folding_server.frames.image_files import MODEL_SIDE, EncodedImage, encode_for_model
from folding_server.frames.manifest import FILE_NAME, Manifest, check_name, read_manifest
from folding_server.frames.photo_cache import PhotoCache
from folding_server.frames.sources import FrameSource, file_stamp, image_folder, named_images, require_inside

_STRIP_SIDE = 1280
THUMBNAIL_SIDE = 160
"""Pixels of the longest side of a thumbnail: twice the 72 to 80 at which lists show it, for screens with two dots a pixel."""
THUMBNAIL_BYTES = 8_000
"""The most bytes of a thumbnail."""
_SHOWN = 20


@dataclass(frozen=True)
class Sequence:
    """The keyframes of one folding: frames count from 1, `keyframes` has each one's index in the video.

    Pixels are read when asked for. Colours are None where the manifest does not tell them.
    """

    name: str
    folder: Path
    front_color: str | None
    back_color: str | None
    keyframes: tuple[int, ...]
    source: FrameSource = field(repr=False, compare=False)
    cache: PhotoCache = field(repr=False, compare=False)

    @property
    def frame_count(self) -> int:
        """The number of keyframes."""
        return len(self.keyframes)

    def require(self, frame: int) -> None:
        """Raise PhotoError unless there is a keyframe `frame`."""
        if isinstance(frame, bool) or not isinstance(frame, int) or not 1 <= frame <= self.frame_count:
            raise PhotoError(f"frame {frame} is not in 1..{self.frame_count}")

    def index(self, frame: int) -> int:
        """The index in the video of keyframe `frame`; PhotoError if there is no such frame."""
        self.require(frame)
        return self.keyframes[frame - 1]

    def photo(self, frame: int) -> RgbImage:
        """Keyframe `frame` in full size: RGB, shape (height, width, 3), read-only; PhotoError if broken."""
        return self.image(self.index(frame))

    def image(self, index: int) -> RgbImage:
        """The image at `index` of the video in full size, like `photo`."""
        key = (self.source.stamp(index), index)
        return self.cache.get(key, lambda: self.source.read(index))

    def photo_for_model(self, frame: int) -> EncodedImage:
        """Keyframe `frame` as a JPEG to show a model: longest side at most 1024 pixels, under 800 kB."""
        index = self.index(frame)
        caption = f"Frame {frame} of {self.frame_count} of {self.name}"
        return encode_for_model(self.source.read(index, MODEL_SIDE), caption=caption)

    def photo_thumbnail(self, frame: int) -> EncodedImage:
        """Keyframe `frame` as a JPEG for lists: longest side at most 160 pixels, under 8 kB."""
        return encode_for_model(
            self.source.read(self.index(frame), THUMBNAIL_SIDE), THUMBNAIL_SIDE, THUMBNAIL_BYTES
        )

    def between(self, frame: int, count: int | None = MAX_STRIP_IMAGES) -> list[int]:
        """Indices of images between keyframes `frame` - 1 and `frame`: `count` evenly spaced, or all if None.

        Empty for frame 1 and where the sequence has no images in between.
        """
        end = self.index(frame)
        if frame == 1:
            return []
        start = self.index(frame - 1)
        inner = [index for index in self.source.indices() if start < index < end]
        return inner if count is None else evenly_spaced(inner, count)

    def filmstrip(self, frame: int) -> EncodedImage:
        """What happened between keyframes `frame` - 1 and `frame`: up to 5 images side by side.

        Where there are none in between, the two keyframes themselves; the picture's caption says which.
        Raises PhotoError for frame 1, before which nothing is seen.
        """
        end = self.index(frame)
        if frame == 1:
            raise PhotoError("frame 1 has no movement before it: ask for a frame from 2 on, or view frame 1")
        inner = self.between(frame)
        if inner:
            captions = [f"image {index}" for index in inner]
            told = (
                f"{len(inner)} of the images between frames {frame - 1} and {frame}, in order, left to right"
            )
            return filmstrip([self._small(index) for index in inner], captions, told)
        pair = [self._small(self.index(frame - 1)), self._small(end)]
        told = (
            f"There are no images between frames {frame - 1} and {frame}: these are the two frames themselves"
        )
        return filmstrip(pair, [f"frame {frame - 1}", f"frame {frame}"], told)

    def fingerprint(self) -> str:
        """SHA-256 of the manifest and of the files that hold the keyframes, as they were when first asked."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> str:
        digest = hashlib.sha256()
        for path in [self.folder / FILE_NAME, *self.source.files(self.keyframes)]:
            digest.update(_file_digest(path))
        return digest.hexdigest()

    def _small(self, index: int) -> RgbImage:
        return self.source.read(index, _STRIP_SIDE)


def load_sequence(folder: Path, cache: PhotoCache | None = None) -> Sequence:
    """The sequence in `folder`: the manifest is read, each keyframe's file looked for, no pixels read.

    Raises PhotoError, one sentence, for a missing folder or image, for what may not be read and for anything wrong with
    the manifest.
    """
    folder = Path(folder)
    with _readable(folder):
        manifest = read_manifest(folder)
        source = _source(manifest, folder)
        source.files(manifest.indices)
    return Sequence(
        name=manifest.name or folder.resolve().name,
        folder=folder,
        front_color=manifest.front_color,
        back_color=manifest.back_color,
        keyframes=manifest.indices,
        source=source,
        cache=cache or PhotoCache(),
    )


class Library:
    """The sequences in a list of folders: each root is a sequence itself, or holds sequences one level down.

    Names are compared with the names of the sequences found and never joined to a path, so that no name can
    lead out of the roots; folders that link out of their root are not served.

    ``added`` is a folder that may hold more of them, or not be there: those added through the server. They give way to
    sequences of the same name in the roots.
    """

    def __init__(
        self, roots: ListOf[Path], added: Path | None = None, cache: PhotoCache | None = None
    ) -> None:
        self._roots = [Path(root) for root in roots]
        self._added = added
        self._cache = cache or PhotoCache()
        self._loaded: dict[Path, tuple[Hashable, Sequence]] = {}
        for root in self._roots:
            if not root.is_dir():
                raise PhotoError(
                    f"there is no folder {root} to serve sequences from: create it or name another",
                    "a folder that the server has sequences in is gone: whoever runs it has to bring it back",
                )

    def sequences(self) -> list[Sequence]:
        """All sequences that can be opened, by name; those that cannot are told by `problems`."""
        found, _ = self._scan()
        return [same[0] for _, same in sorted(found.items()) if len(same) == 1]

    def problems(self) -> list[str]:
        """One sentence for each folder that looks like a sequence but cannot be served."""
        found, broken = self._scan()
        return [_ambiguous(name, same) for name, same in sorted(found.items()) if len(same) > 1] + [
            str(error) for _, error in sorted(broken.items(), key=lambda item: item[0])
        ]

    def served_names(self) -> set[str]:
        """The names of the sequences in the roots, without those that were added."""
        found, _ = self._scan_folders(self._folders())
        return set(found)

    def open(self, name: str) -> Sequence:
        """The sequence called `name`; PhotoError if that is a path, unknown, ambiguous or a broken folder."""
        check_name(name)
        found, broken = self._scan()
        same = found.get(name, [])
        if len(same) > 1:
            raise PhotoError(_ambiguous(name, same))
        if same:
            return same[0]
        if name in broken:
            raise broken[name]
        if broken and not found:
            raise next(iter(broken.values()))
        raise PhotoError(f"there is no sequence {name!r}: {_known(sorted(found))}")

    def _scan(self) -> tuple[dict[str, list[Sequence]], dict[str, PhotoError]]:
        """Sequences by name, and the errors of broken folders by the folder's name."""
        found, broken = self._scan_folders(self._folders())
        if self._added is not None and self._added.is_dir():
            added, damaged = self._scan_folders(_sequence_folders(self._added.resolve()))
            broken |= damaged | {name: _hidden(name) for name in added.keys() & found.keys()}
            found = added | found
        return found, broken

    def _scan_folders(
        self, folders: Iterable[Path]
    ) -> tuple[dict[str, list[Sequence]], dict[str, PhotoError]]:
        found: dict[str, list[Sequence]] = {}
        broken: dict[str, PhotoError] = {}
        for folder in folders:
            try:
                with _readable(folder):
                    sequence = self._load(folder)
            except PhotoError as error:
                broken[folder.name] = error
                continue
            found.setdefault(sequence.name, []).append(sequence)
        return found, broken

    def _folders(self) -> list[Path]:
        """The real folders that hold a manifest, each once."""
        roots = [root.resolve() for root in self._roots]
        return list(dict.fromkeys(folder for root in roots for folder in _sequence_folders(root)))

    def _load(self, folder: Path) -> Sequence:
        """The sequence in `folder`, loaded again only when its manifest or its images have changed."""
        require_inside(folder / FILE_NAME, folder)
        stamp = (
            file_stamp(folder / FILE_NAME),
            *(file_stamp(part) for part in folder.iterdir() if part.exists()),
        )
        known = self._loaded.get(folder)
        if known is not None and known[0] == stamp:
            return known[1]
        sequence = load_sequence(folder, self._cache)
        self._loaded[folder] = stamp, sequence
        return sequence


def _sequence_folders(root: Path) -> Iterator[Path]:
    """The real folders with a manifest in a root: itself, or those one level down that do not link out of it."""
    with _readable(root):
        inside = [root] if _has_manifest(root) else sorted(root.iterdir())
    for folder in inside:
        if _has_manifest(folder) and folder.resolve().is_relative_to(root):
            yield folder.resolve()


def _has_manifest(folder: Path) -> bool:
    """Whether a folder holds a manifest: not if it may not be looked into, such as the lost+found of a disk."""
    try:
        return (folder / FILE_NAME).is_file()
    except OSError:
        return False


@contextmanager
def _readable(folder: Path) -> Iterator[None]:
    """PhotoError where the system refuses to read something of a folder."""
    try:
        yield
    except OSError as error:
        raise PhotoError(
            f"the folder {folder.name!r:.80} cannot be read ({error.strerror or error}): see that the server may read it, or name another"
        ) from error


def _source(manifest: Manifest, folder: Path) -> FrameSource:
    if manifest.video is None:
        place = folder / (manifest.frames or "frames")
        return named_images(place, folder, manifest.names) if manifest.names else image_folder(place, folder)
    from folding_server.frames.films import open_film  # noqa: PLC0415  (may load the video library)

    require_inside(folder / manifest.video, folder)
    return open_film(folder / manifest.video)


def _file_digest(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except OSError as error:
        raise PhotoError(f"{path.name} cannot be read: {error.strerror or error}") from error


def _ambiguous(name: str, same: ListOf[Sequence]) -> str:
    places = " and ".join(_told_apart([sequence.folder for sequence in same]))
    return f"{len(same)} sequences are called {name!r} ({places}): change the name in one's {FILE_NAME}"


def _told_apart(folders: ListOf[Path]) -> list[str]:
    """As many last parts of the paths of different folders as tell them apart."""
    for count in range(1, max(len(folder.parts) for folder in folders) + 1):
        shown = [Path(*folder.parts[-count:]).as_posix() for folder in folders]
        if len(set(shown)) == len(folders):
            return shown
    return [str(folder) for folder in folders]


def _hidden(name: str) -> PhotoError:
    return PhotoError(
        f"the sequence {name!r} that was added is hidden by one of that name in the server's folders: add it again by another name"
    )


def _known(names: ListOf[str]) -> str:
    if not names:
        return "the server's folders hold none"
    shown = ", ".join(names[:_SHOWN])
    return f"there are {shown}" + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
