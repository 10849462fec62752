"""Videos as images by index: rotation and mirroring applied, any frame rate, by random access or in order."""

import bisect
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from math import cos, radians, sin
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.film_image import VideoImage, image_label, require_in_film
from folding_server.frames.image_files import MAX_PIXELS, MIN_SIDE
from folding_server.frames.sources import file_stamp

try:
    import av
    from av.container import InputContainer
    from av.sidedata.sidedata import SideData
    from av.video.stream import VideoStream
except ModuleNotFoundError as error:
    raise PhotoError(
        "Videos need PyAV, which is not installed; install it with pip install 'foldingagent-mcp[video]', or use a sequence "
        "of image files."
    ) from error

FORMATS = (
    "mov,mp4,matroska,webm,avi,mpegts,mpeg,mpegvideo,m4v,h264,hevc,flv,asf,ogg,gif,mjpeg,mxf,wav,mp3,aac,flac"
)
"""Containers that are opened; playlists, which lead to other files, are not among them."""
_NO_VIDEO = "it is cut off or not a video; copy it again, or name another file"
_CUT_SECONDS = 1.0
_CUT_PART = 0.05
_FIXED = 1 << 16
"""1 in the fixed-point numbers of a display matrix."""
_ATTACHED = av.stream.Disposition.attached_pic


@dataclass(frozen=True)
class Video:
    """A video whose images are counted from 0 in the order they are shown.

    `times` holds each image's time in seconds from the first; `stamps` its time stamp in the file, None where
    the file has no usable ones, and `keys` the stamps of the images that can be decoded on their own.
    """

    path: Path
    times: tuple[float, ...] = field(repr=False)
    stamps: tuple[int, ...] | None = field(repr=False)
    keys: tuple[int, ...] = field(repr=False)

    def indices(self) -> range:
        """The indices of all images, from 0."""
        return range(len(self.times))

    def files(self, indices: Sequence[int]) -> list[Path]:
        """The video's own file; PhotoError if an index lies outside the video."""
        for index in indices:
            self._check(index)
        return [self.path]

    def stamp(self, index: int) -> Hashable:
        """Path, time of change and size of the video's file."""
        self._check(index)
        return file_stamp(self.path)

    def read(self, index: int, longest: int | None = None) -> RgbImage:
        """The image at `index`, upright, scaled down to `longest` if given; PhotoError if it is broken."""
        return next(self.read_each([index], longest)).image

    def read_each(self, indices: Sequence[int], longest: int | None = None) -> Iterator[VideoImage]:
        """The images at `indices` (increasing), decoded in one pass that skips what it can.

        Raises PhotoError for an index outside the video and for an image that cannot be decoded.
        """
        self.files(indices)
        with _opened(self.path) as (container, stream):
            walk = _Walk(self, container, stream)
            for index in indices:
                yield VideoImage(index, self.times[index], _pixels(walk.frame(index), longest))

    def moments(self, longest: int, rate: float) -> Iterator[VideoImage]:
        """The images in order, at most `rate` a second, scaled down to `longest`, without broken ones."""
        due = 0.0
        with _opened(self.path) as (container, stream):
            for index, frame in _decoded(self, container, stream):
                if self.times[index] + 1e-9 >= due:
                    due = max(due + 1 / rate, self.times[index] + 0.5 / rate)
                    yield VideoImage(index, self.times[index], _pixels(frame, longest))

    def label(self, index: int) -> str:
        """The index and its time, as ``120  0:04.0``."""
        return image_label(index, self.times[index])

    def _check(self, index: int) -> None:
        require_in_film(index, len(self.times), self.path.name)


def open_video(path: Path) -> Video:
    """The video at `path`; its images are counted, none is decoded.

    Raises PhotoError for a missing file, a file without moving pictures, and one that is cut off.
    """
    if path.is_dir():
        raise PhotoError(f"{path.name} is a folder: name the file of a video")
    if not path.is_file():
        raise PhotoError(
            f"there is no video {path.name} in {path.parent.resolve().name or path.parent}; give the path of a video file"
        )
    with _opened(path) as (container, stream):
        stamps, keys, end, cut = _survey(container, stream)
        promised = (container.duration or 0) / av.time_base
        _check_size(path, stream)
        if cut or (stamps and end < promised - max(_CUT_SECONDS, _CUT_PART * promised)):
            raise PhotoError(
                f"{path.name} is cut off: {end:.1f} of {promised:.1f} s are there; copy it again"
            )
        return _video(path, stamps, keys, stream)


def _video(path: Path, stamps: list[int | None], keys: list[int], stream: VideoStream) -> Video:
    """The record of a video from the time stamps of its packets."""
    if not stamps:
        raise PhotoError(f"{path.name} holds no images that can be read: {_NO_VIDEO}")
    known = sorted({stamp for stamp in stamps if stamp is not None})
    if len(known) == len(stamps) and stream.time_base:
        times = tuple(float((stamp - known[0]) * stream.time_base) for stamp in known)
        return Video(path, times, tuple(known), tuple(sorted(keys)))
    rate = stream.average_rate or Fraction(25)
    return Video(path, tuple(float(index / rate) for index in range(len(stamps))), None, ())


@contextmanager
def _opened(path: Path) -> Iterator[tuple[InputContainer, VideoStream]]:
    """The container and its first stream of moving pictures; the library's errors become one sentence."""
    try:
        with av.open(str(path.resolve()), options={"format_whitelist": FORMATS}) as container:
            streams = [stream for stream in container.streams.video if not stream.disposition & _ATTACHED]
            if not streams:
                kind = "only sound" if container.streams.audio else "neither pictures nor sound"
                raise PhotoError(f"{path.name} is no video: it holds {kind}; name a film")
            if getattr(streams[0], "codec_context", None) is None:
                raise PhotoError(
                    f"{path.name} cannot be decoded: it is cut off or of an unknown encoding; convert it to H.264"
                )
            streams[0].thread_type = "AUTO"
            yield container, streams[0]
    except (av.FFmpegError, UnicodeDecodeError) as error:
        raise PhotoError(f"{path.name} cannot be read as a video: {_NO_VIDEO}") from error


def _survey(
    container: InputContainer, stream: VideoStream
) -> tuple[list[int | None], list[int], float, bool]:
    """Time stamps of all images, of those that stand alone, the last second, and whether data is missing."""
    stamps: list[int | None] = []
    keys: list[int] = []
    end, cut = 0.0, False
    for packet in container.demux():
        if packet.size == 0:
            continue
        cut = cut or packet.is_corrupt
        at = packet.pts if packet.pts is not None else packet.dts
        if at is not None and packet.time_base:
            end = max(end, float((at + (packet.duration or 0)) * packet.time_base))
        if packet.stream_index == stream.index and not packet.is_discard:
            stamps.append(packet.pts)
            if packet.is_keyframe and packet.pts is not None:
                keys.append(packet.pts)
    start = (container.start_time or 0) / av.time_base
    return stamps, keys, end - max(0.0, start), cut


def _check_size(path: Path, stream: VideoStream) -> None:
    if min(stream.width, stream.height) < MIN_SIDE or stream.width * stream.height > MAX_PIXELS:
        raise PhotoError(
            f"{path.name} has images of {stream.width}x{stream.height} pixels: "
            f"at least {MIN_SIDE}x{MIN_SIDE} and at most {MAX_PIXELS // 10**6} million pixels are read"
        )


def _decoded(
    video: Video, container: InputContainer, stream: VideoStream
) -> Iterator[tuple[int, av.VideoFrame]]:
    """Index and frame of what can be decoded from where the container stands; broken packets are skipped."""
    count = 0
    for packet in container.demux(stream):
        try:
            frames = packet.decode()
        except av.InvalidDataError:
            continue
        for frame in frames:
            index = _index(video, frame, count)
            count += 1
            if index is not None:
                yield index, frame


def _index(video: Video, frame: av.VideoFrame, count: int) -> int | None:
    """The frame's index: by its time stamp or, without those, by counting."""
    if video.stamps is None:
        return count if count < len(video.times) else None
    place = bisect.bisect_left(video.stamps, frame.pts) if frame.pts is not None else len(video.stamps)
    return place if place < len(video.stamps) and video.stamps[place] == frame.pts else None


class _Walk:
    """Decodes chosen images in order, jumping ahead only where an image that stands alone lets it."""

    def __init__(self, video: Video, container: InputContainer, stream: VideoStream) -> None:
        self._video, self._container, self._stream = video, container, stream
        self._frames = _decoded(video, container, stream)
        self._at = -1

    def frame(self, index: int) -> av.VideoFrame:
        """The frame at `index`, later than any asked for before."""
        starts = [key for key in self._keys() if key <= index]
        ahead = [start for start in starts if start > self._at + 1][-1:]
        for attempt, start in enumerate([*(ahead or [index]), *starts[-2:-1], 0]):
            if ahead or attempt > 0:
                self._seek(start)
            frame = self._advance(index)
            if frame is not None:
                return frame
        raise PhotoError(f"image {index} of {self._video.path.name} cannot be decoded: choose another one")

    def _keys(self) -> list[int]:
        if self._video.stamps is None:
            return []
        return [bisect.bisect_left(self._video.stamps, key) for key in self._video.keys]

    def _seek(self, index: int) -> None:
        if self._video.stamps is not None:
            self._container.seek(self._video.stamps[index], stream=self._stream, backward=True)
        else:
            self._container.seek(0)
        self._frames = _decoded(self._video, self._container, self._stream)

    def _advance(self, index: int) -> av.VideoFrame | None:
        for at, frame in self._frames:
            self._at = at
            if at == index:
                return frame
            if at > index:
                return None
        return None


def _pixels(frame: av.VideoFrame, longest: int | None) -> RgbImage:
    """The frame as RGB, scaled down to `longest`, turned and mirrored as the file asks."""
    factor = min(1.0, (longest or max(frame.width, frame.height)) / max(frame.width, frame.height))
    size = max(1, round(frame.width * factor)), max(1, round(frame.height * factor))
    pixels = frame.to_ndarray(format="rgb24", width=size[0], height=size[1], interpolation="AREA")
    matrix = _display_matrix(frame)
    rgb = np.asarray(pixels, dtype=np.uint8)
    return rgb if matrix is None else _turned(rgb, matrix)


def _display_matrix(frame: av.VideoFrame) -> NDArray[np.int32] | None:
    """The display matrix of a frame; None if it has none.

    PyAV refuses to list side data of which one kind is newer than itself, such as the EXIF data that FFmpeg 8 attaches. The
    turn is then all that it tells: a frame that is mirrored besides, which no camera writes, is shown mirrored.
    """
    try:
        matrix = frame.side_data.get("DISPLAYMATRIX")
    except ValueError:
        angle = radians(frame.rotation)
        c, s = round(_FIXED * cos(angle)), round(_FIXED * sin(angle))
        return np.array([c, -s, 0, s, c, 0, 0, 0, 1 << 30], np.int32)
    return np.frombuffer(bytes(matrix), np.int32) if isinstance(matrix, SideData) else None


def _turned(pixels: RgbImage, matrix: NDArray[np.int32]) -> RgbImage:
    """`pixels` under a display matrix a b u c d v x y w (ISO/IEC 14496-12), to the nearest quarter turn."""
    a, b, _, c, d = (int(value) for value in matrix[:5])
    across, down = a, d
    if abs(b) > abs(a):
        pixels, across, down = pixels.transpose(1, 0, 2), c, b
    return np.ascontiguousarray(pixels[:: -1 if down < 0 else 1, :: -1 if across < 0 else 1])
