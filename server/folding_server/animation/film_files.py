"""Films as files: MP4 and WebM by PyAV, GIF by Pillow."""

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, cast

from folding_server.animation.film import FilmForm, FilmMoment, LessonFilm
from folding_server.animation.film_page import film_page
from folding_server.arrays import RgbImage
from folding_server.errors import FoldingError
from folding_server.instructions.moves import Lesson

if TYPE_CHECKING:
    from av.video.stream import VideoStream

CODECS = {
    ".mp4": ("libx264", {"preset": "veryfast", "crf": "20"}),
    ".webm": ("libvpx", {"deadline": "realtime", "cpu-used": "8", "crf": "12", "b": "2M"}),
}
"""Codec and options of each kind of film: quick to write, and without visible loss in flat colours."""
GIF_FORM = FilmForm(640, 480, 12)
"""A GIF has no compression of movement worth the name: it is smaller and has fewer pictures."""
FILM_ENDINGS = (*CODECS, ".gif", ".html")


def write_film(lesson: Lesson, words: list[str], out: Path, view: str, language: str = "en") -> None:
    """Write a film, of the kind that the file's name ends in. FoldingError for another ending, or if it cannot be written."""
    ending = out.suffix.lower()
    if ending not in FILM_ENDINGS:
        raise FoldingError(
            f"A film cannot be written as {ending!r}; end the file's name in {', '.join(FILM_ENDINGS)}."
        )
    try:
        if ending == ".html":
            out.write_text(film_page(lesson, words, language, view), encoding="utf-8")
        elif ending == ".gif":
            form = replace(GIF_FORM, view=view)
            _write_gif(out, LessonFilm(lesson, words, form).pictures(), form)
        else:
            form = FilmForm(view=view)
            _write_video(out, LessonFilm(lesson, words, form).pictures(), form)
    except OSError as error:
        raise FoldingError(
            f"{out} cannot be written ({error.strerror or error}); give another file."
        ) from error


def poster_png(lesson: Lesson, words: list[str], view: str) -> bytes:
    """The finished model and the title, as the film shows them first."""
    from folding_server.frames.image_files import encode_png

    return encode_png(
        LessonFilm(lesson, words, FilmForm(view=view)).picture(FilmMoment(None, 1.0, None))
    ).data


def _write_video(out: Path, pictures: Iterable[RgbImage], form: FilmForm) -> None:
    """A picture that stays is written once, and shown until the next: half of all do."""
    try:
        import av
    except ModuleNotFoundError as error:
        raise FoldingError(
            "Films as MP4 and WebM need PyAV, which is not installed; install it with pip install 'foldingagent-mcp[video]', or "
            "write a .gif or .html."
        ) from error
    codec, options = CODECS[out.suffix.lower()]
    with av.open(str(out), "w") as container:
        stream = cast("VideoStream", container.add_stream(codec, rate=form.rate, options=dict(options)))
        stream.width, stream.height, stream.pix_fmt = form.width, form.height, "yuv420p"
        last: RgbImage | None = None
        for count, picture in enumerate(pictures):
            if picture is not last:
                frame = av.VideoFrame.from_ndarray(picture, "rgb24")
                frame.pts, frame.time_base = count, Fraction(1, form.rate)
                container.mux(stream.encode(frame))
                last = picture
        frame.pts = count  # the last picture again: it is shown to the end
        container.mux(stream.encode(frame))
        container.mux(stream.encode())


def _write_gif(out: Path, pictures: Iterable[RgbImage], form: FilmForm) -> None:
    """Still pictures are written once and shown longer."""
    from PIL import Image

    frames: list[Image.Image] = []
    durations: list[int] = []
    last: RgbImage | None = None
    for picture in pictures:
        if picture is last:
            durations[-1] += round(1000 / form.rate)
            continue
        last = picture
        frames.append(Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE))
        durations.append(round(1000 / form.rate))
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=False)
