"""Animated pictures are films whose images rest; films with new kinds of side data are read; a photo is told from a film."""

import io
import json
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError
from folding_server.frames.animated_pictures import animated_picture
from folding_server.frames.films import open_film
from folding_server.frames.image_files import decode_bytes
from folding_server.frames.keyframes import keyframe_proposal
from folding_server.frames.sequence_writer import keyframes_command
from folding_server.frames.sequences import load_sequence
from folding_server.frames.video import open_video
from pictures import quadrants
from PIL import Image
from reference_data import REFERENCE

GREYS = (40, 90, 140, 190)
KINDS = ("gif", "webp", "png")


def grey(value: int) -> Image.Image:
    """A picture of one grey with a corner that does not change."""
    picture = Image.new("RGB", (96, 64), (value, value, value))
    picture.paste((250, 250, 250), (0, 0, 20, 20))
    return picture


def animated(path: Path, seconds: list[float], greys: tuple[int, ...] = GREYS) -> Path:
    """An animated picture, each image shown for so long."""
    first, *rest = [grey(value) for value in greys]
    first.save(
        path,
        save_all=True,
        append_images=rest,
        duration=[round(1000 * s) for s in seconds],
        loop=0,
        lossless=True,
    )
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_every_image_has_the_time_for_which_it_is_shown(tmp_path: Path, kind: str) -> None:
    film = animated_picture(animated(tmp_path / f"steps.{kind}", [0.5, 1.2, 0.7, 2.0]))
    assert film is not None
    assert film.durations == pytest.approx([0.5, 1.2, 0.7, 2.0])
    assert film.times == pytest.approx([0.0, 0.5, 1.7, 2.4])
    assert [int(film.read(index).mean(axis=(0, 1))[0]) for index in (3, 0, 2)] == pytest.approx(
        [grey(GREYS[index]).resize((1, 1), Image.Resampling.BOX).getpixel((0, 0))[0] for index in (3, 0, 2)],  # type: ignore[index]
        abs=3,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_each_image_that_rests_is_a_keyframe_but_one_that_repeats_the_last(tmp_path: Path, kind: str) -> None:
    path = animated(tmp_path / f"steps.{kind}", [1.0] * 5, (40, 60, 60, 140, 40))
    found = [open_film(path).read(index) for index in keyframe_proposal(path).indices]
    assert [int(np.rint(image[-1, -1, 0] / 4)) for image in found] == [10, 15, 35, 10]
    assert keyframe_proposal(path).moving == ()


def test_an_animation_that_moves_rests_where_an_image_is_shown_for_long(tmp_path: Path) -> None:
    path = animated(tmp_path / "steps.gif", [1.0, 0.1, 0.1, 2.0])
    assert keyframe_proposal(path).indices == (0, 3)


def test_a_duration_that_a_file_leaves_out_is_a_tenth_of_a_second(tmp_path: Path) -> None:
    film = animated_picture(animated(tmp_path / "steps.gif", [0.0, 0.01, 0.5, 0.5]))
    assert film is not None
    assert film.durations == pytest.approx([0.1, 0.1, 0.5, 0.5])


@pytest.mark.parametrize("kind", KINDS)
def test_an_animated_picture_becomes_a_sequence(tmp_path: Path, kind: str) -> None:
    path = animated(tmp_path / f"steps.{kind}", [1.0] * 4)
    report = keyframes_command(path, tmp_path / "steps")
    assert (report.keyframes, report.seconds) == ((0, 1, 2, 3), pytest.approx((0.0, 1.0, 2.0, 3.0)))
    assert load_sequence(tmp_path / "steps").frame_count == 4


def test_a_manifest_may_name_an_animated_picture(tmp_path: Path) -> None:
    animated(tmp_path / "steps.gif", [1.0] * 4)
    (tmp_path / "keyframes.json").write_text(json.dumps({"video": "steps.gif", "keyframes": [0, 2]}))
    assert load_sequence(tmp_path).photo(2)[-1, -1, 0] == pytest.approx(140, abs=3)


@pytest.mark.parametrize("name", ["photo.jpg", "photo.png", "photo.webp", "photo.gif", "photo.heic"])
def test_a_photo_that_is_named_as_a_film_is_told_to_be_one(tmp_path: Path, name: str) -> None:
    if name.endswith("heic"):
        import pillow_heif  # noqa: PLC0415  (loads its codecs)

        pillow_heif.from_pillow(grey(90)).save(tmp_path / name)
    else:
        grey(90).save(tmp_path / name)
    with pytest.raises(PhotoError, match=rf"{name} is a single photo \(.*name a film, or the folder"):
        keyframe_proposal(tmp_path / name)


def test_an_animated_picture_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    whole = animated(tmp_path / "steps.webp", [1.0] * 4).read_bytes()
    (tmp_path / "cut.webp").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(PhotoError, match="broken or cut off"):
        keyframe_proposal(tmp_path / "cut.webp")


def jpeg_with_exif(image: RgbImage, orientation: int) -> bytes:
    """A JPEG that says how it was held."""
    exif = Image.Exif()
    exif[0x0112] = orientation
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "JPEG", quality=95, exif=exif)
    return buffer.getvalue()


@pytest.mark.parametrize("orientation", [1, 3, 6, 8])
def test_a_film_of_jpegs_with_exif_data_is_read_upright(tmp_path: Path, orientation: int) -> None:
    data = jpeg_with_exif(quadrants(96, 64), orientation)
    path = tmp_path / "exif.mov"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=10)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuvj420p"
        for number in range(3):
            packet = av.Packet(data)
            packet.stream, packet.time_base = stream, Fraction(1, 10)
            packet.pts = packet.dts = number
            packet.is_keyframe = True
            container.mux(packet)
    wanted = decode_bytes(data, "the photo")
    image = open_video(path).read(1)
    assert image.shape == wanted.shape
    assert np.abs(image.astype(int) - wanted).mean() < 8


@pytest.mark.reference("cases/photos")
def test_a_phones_film_of_jpegs_with_exif_data_is_read() -> None:
    film = open_film(REFERENCE / "cases" / "photos" / "mjpeg_exif.mov")
    assert film.read(0).shape == (149, 200, 3)
    assert len(film.times) == 60
