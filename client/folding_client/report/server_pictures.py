"""The pictures that a run's folder lacks, from a folding server of the report's own: photos, diagrams, crease patterns,
overlays.

The recorded program is carried out on a fresh run in a folder that goes afterwards, so the record and its store are not
touched.
"""

import tempfile
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO
from urllib.parse import quote

from folding_schemas.actions import Actions

from folding_client.interrupts import Interrupt, ToolRefused
from folding_client.messages import ToolResult
from folding_client.protocol.connection import Connection, ServerAddress
from folding_client.report.site_files import SiteFiles, content_key

_JPEG, _SVG = "image/jpeg", "image/svg+xml"


@dataclass(frozen=True)
class FramePictures:
    """Where the pictures of a frame are within a site, each None if there is none."""

    photo: str | None = None
    thumbnail: str | None = None
    diagram: str | None = None
    pattern: str | None = None
    overlay: str | None = None


@dataclass(frozen=True)
class PicturedRun:
    """What pictures are made of: the sequence's folder and name, its frames, the saved steps from frame 1 on without a
    gap, and the frames whose overlay is on record already.
    """

    folder: Path
    sequence: str
    frames: int
    steps: tuple[Actions, ...]
    overlays: frozenset[int] = frozenset()

    @property
    def has_photos(self) -> bool:
        """Whether the sequence is where the run had it."""
        try:
            return (self.folder / "keyframes.json").is_file()
        except OSError:
            return False

    def photo_key(self, frame: int) -> str:
        """The name of a frame's photo."""
        return content_key("photo", self._manifest, frame)

    def thumbnail_key(self, frame: int) -> str:
        """The name of a frame's photo in lists."""
        return content_key("thumbnail", self._manifest, frame)

    def state_key(self, kind: str, frame: int) -> str:
        """The name of a picture of the state at a frame, or of how it lies on the photo."""
        steps = "|".join(str(action) for step in self.steps[:frame] for action in (*step, "/"))
        return content_key(kind, self._manifest, frame, steps)

    @property
    def _manifest(self) -> str:
        """What tells this sequence from others and from itself before it was corrected."""
        try:
            told = (self.folder / "keyframes.json").read_text(encoding="utf-8", errors="replace")
        except OSError:
            told = ""
        return f"{self.folder}\0{told}"

    def keys(self, *, overlays: bool) -> Iterator[str]:
        """The names of all pictures that a server can make."""
        if self.has_photos:
            for frame in range(1, self.frames + 1):
                yield self.photo_key(frame)
                yield self.thumbnail_key(frame)
        for frame in range(1, len(self.steps) + 1):
            yield self.state_key("diagram", frame)
            yield self.state_key("pattern", frame)
            if overlays and self.has_photos and frame > 1 and frame not in self.overlays:
                yield self.state_key("overlay", frame)

    def found(self, files: SiteFiles) -> dict[int, FramePictures]:
        """Where the pictures are, by frame."""
        count = max(self.frames, len(self.steps))
        return {
            frame: FramePictures(
                files.picture(self.photo_key(frame)),
                files.picture(self.thumbnail_key(frame)),
                files.picture(self.state_key("diagram", frame)) if frame <= len(self.steps) else None,
                files.picture(self.state_key("pattern", frame)) if frame <= len(self.steps) else None,
                files.picture(self.state_key("overlay", frame)) if frame <= len(self.steps) else None,
            )
            for frame in range(1, count + 1)
        }


async def fetch_pictures(
    runs: Mapping[str, PicturedRun], files: SiteFiles, say: Callable[[str], None], *, overlays: bool = True
) -> dict[str, list[str]]:
    """Have a server make the pictures that the site lacks; what it could not make, by the key of the run."""
    troubles: dict[str, list[str]] = {}
    for folder, keys in _by_folder(_lacking(runs, files, overlays=overlays)).items():
        with tempfile.TemporaryDirectory() as place, (Path(place) / "server.log").open("w") as log:
            group = {key: runs[key] for key in keys}
            for key, trouble in (
                await _fetched(folder, group, files, Path(place), log, say, overlays)
            ).items():
                troubles.setdefault(key, []).append(trouble)
    return troubles


def _lacking(
    runs: Mapping[str, PicturedRun], files: SiteFiles, *, overlays: bool
) -> Iterator[tuple[str, Path]]:
    for key, run in runs.items():
        if any(files.picture(name) is None for name in run.keys(overlays=overlays)):
            yield key, run.folder


def _by_folder(lacking: Iterable[tuple[str, Path]]) -> dict[Path, list[str]]:
    groups: dict[Path, list[str]] = {}
    for key, folder in lacking:
        groups.setdefault(folder, []).append(key)
    return groups


async def _fetched(
    folder: Path,
    runs: Mapping[str, PicturedRun],
    files: SiteFiles,
    place: Path,
    log: TextIO,
    say: Callable[[str], None],
    overlays: bool,
) -> dict[str, str]:
    """Make the pictures of runs of one sequence on one server."""
    troubles: dict[str, str] = {}
    there = any(run.has_photos for run in runs.values())
    connection = Connection(ServerAddress(folder if there else place, place / "data"), log)
    try:
        await connection.open()
        for key, run in runs.items():
            say(f"pictures of {run.sequence}")
            try:
                left_out = await _Pictures(connection, run, files, overlays=overlays).make()
            except ToolRefused as refusal:
                left_out = str(refusal)
            if left_out:
                troubles[key] = f"Pictures are missing: {left_out}"
    except Interrupt as trouble:
        left = f"Pictures are missing, since the folding server ended: {trouble}."
        troubles |= {key: left for key in runs if key not in troubles}
    finally:
        await connection.close()
    return troubles


class _Pictures:
    """Makes the pictures of one run."""

    def __init__(self, connection: Connection, run: PicturedRun, files: SiteFiles, *, overlays: bool) -> None:
        self._connection = connection
        self._run = run
        self._files = files
        self._overlays = overlays and run.has_photos
        self._run_id = ""
        self._left_out = ""

    async def make(self) -> str:
        """Make all that the site lacks; why an overlay could not be made, empty if all could. ToolRefused where the server
        refuses a step; what was made before stays.
        """
        run = self._run
        sequence = {"sequence": run.sequence} if run.has_photos else {}
        opened = await self._call("open_run", **sequence)
        self._run_id = str((opened.data or {}).get("run_id"))
        if run.has_photos:
            for frame in range(1, run.frames + 1):
                await self._photo(frame)
        for frame, step in enumerate(run.steps, start=1):
            for action in step:
                arguments = action.model_dump(mode="json", exclude_none=True, exclude={"action"})
                await self._call(action.action, **arguments)
            if run.has_photos:
                await self._call("save_checkpoint", frame=frame)
            await self._state(frame)
        return self._left_out

    async def _photo(self, frame: int) -> None:
        name = self._run.photo_key(frame)
        if self._files.picture(name) is None:
            shown = (await self._call("view_frame", frame=frame)).pictures[0]
            self._files.keep_picture(name, shown.data, shown.mime)
        name = self._run.thumbnail_key(frame)
        if self._files.picture(name) is None:
            address = f"folding://sequences/{quote(self._run.sequence, safe='')}/frames/{frame}/thumbnail"
            data, mime = await self._connection.read(address), _JPEG
            if not data:
                shown = (await self._call("view_frame", frame=frame, images="small")).pictures[0]
                data, mime = shown.data, shown.mime
            self._files.keep_picture(name, data, mime)

    async def _state(self, frame: int) -> None:
        for kind, export in (("diagram", "svg"), ("pattern", "crease-pattern-svg")):
            name = self._run.state_key(kind, frame)
            if self._files.picture(name) is None:
                exported = await self._call("export_state", format=export)
                text = str((exported.data or {}).get("text") or "")
                self._files.keep_picture(name, text.encode("utf-8"), _SVG)
        if self._overlays and frame > 1 and frame not in self._run.overlays:
            await self._overlay(frame)

    async def _overlay(self, frame: int) -> None:
        name = self._run.state_key("overlay", frame)
        if self._files.picture(name) is not None:
            return
        try:
            shown = (await self._call("compare_to_frame", frame=frame)).pictures
        except (
            ToolRefused
        ) as refusal:  # a photo that cannot be read, say: the states can be drawn all the same
            self._left_out = self._left_out or str(refusal)
            return
        for picture in shown[:1]:
            self._files.keep_picture(name, picture.data, picture.mime)

    async def _call(self, tool: str, **arguments: object) -> ToolResult:
        """What a tool answers. ToolRefused if it refuses."""
        told = {**arguments, "run_id": self._run_id} if self._run_id else arguments
        result = await self._connection.call(tool, told)
        if result.is_error:
            raise ToolRefused(result.text)
        return result


def saved_steps(saved: Container[int]) -> int:
    """How many frames are saved from frame 1 on without a gap."""
    count = 0
    while count + 1 in saved:
        count += 1
    return count
