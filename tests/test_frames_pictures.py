"""Decoding, scaling and encoding single images."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pillow_heif
import pytest
from folding_server.errors import PhotoError
from folding_server.frames.image_files import (
    MAX_ENCODED_BYTES,
    decode,
    decode_bytes,
    encode_for_model,
    encode_png,
    scale_to,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from pictures import Rgb, noise, quadrants, write_image
from PIL import Image
from reference_data import REFERENCE

TURNS = {
    1: lambda image: image,
    2: lambda image: image[:, ::-1],
    3: lambda image: image[::-1, ::-1],
    4: lambda image: image[::-1],
    5: lambda image: image.transpose(1, 0, 2),
    6: np.rot90,
    7: lambda image: np.rot90(image, 2).transpose(1, 0, 2),
    8: lambda image: np.rot90(image, -1),
}
"""How a camera that writes each EXIF orientation stores an upright picture."""


def close(image: Rgb, expected: Rgb, by: int = 12) -> bool:
    """Same shape and, away from the edges between colours, the same colours."""
    if image.shape != expected.shape:
        return False
    height, width = image.shape[:2]
    spots = [(y, x) for y in (height // 4, 3 * height // 4) for x in (width // 4, 3 * width // 4)]
    return all(np.abs(image[spot].astype(int) - expected[spot]).max() <= by for spot in spots)


@pytest.mark.parametrize("orientation", sorted(TURNS))
def test_exif_orientation_is_honoured(tmp_path: Path, orientation: int) -> None:
    exif = Image.Exif()
    exif[0x0112] = orientation
    stored = np.ascontiguousarray(TURNS[orientation](quadrants()))
    path = write_image(tmp_path / "turned.jpg", stored, exif=exif, quality=95, subsampling=0)
    assert close(decode(path), quadrants())


@pytest.mark.parametrize("mode", ["L", "RGB", "P", "RGBA", "LA", "CMYK", "1"])
def test_every_colour_mode_becomes_rgb(tmp_path: Path, mode: str) -> None:
    path = tmp_path / f"image.{'jpg' if mode == 'CMYK' else 'png'}"
    source = Image.fromarray(quadrants()).convert(mode)
    source.save(path)
    image = decode(path)
    assert image.shape == (64, 96, 3)
    assert image.dtype == np.uint8
    assert close(image, np.asarray(source.convert("RGB")))


def test_sixteen_bit_grey_keeps_its_range(tmp_path: Path) -> None:
    ramp = np.linspace(0, 65535, 96).astype(np.uint16)
    Image.fromarray(np.tile(ramp, (64, 1))).save(tmp_path / "deep.png")
    image = decode(tmp_path / "deep.png")
    assert image[0, 0].tolist() == [0, 0, 0]
    assert image[0, -1].tolist() == [255, 255, 255]
    assert np.all(np.diff(image[0, :, 0].astype(int)) >= 0)


def test_transparent_parts_are_white(tmp_path: Path) -> None:
    clear = np.dstack([quadrants(), np.full((64, 96), 255, np.uint8)])
    clear[:32, :48, 3] = 0
    Image.fromarray(clear).save(tmp_path / "clear.png")
    image = decode(tmp_path / "clear.png")
    assert image[5, 5].tolist() == [255, 255, 255]
    assert image[60, 90].tolist() == [220, 220, 30]


def test_a_palette_with_a_transparent_colour_is_laid_on_white(tmp_path: Path) -> None:
    palette = Image.fromarray(quadrants()).convert("P", palette=Image.Palette.ADAPTIVE, colors=4)
    first = palette.getpixel((5, 5))
    palette.save(tmp_path / "palette.png", transparency=first)
    assert decode(tmp_path / "palette.png")[5, 5].tolist() == [255, 255, 255]


def test_decoding_to_a_side_gives_that_side(tmp_path: Path) -> None:
    path = write_image(tmp_path / "large.jpg", quadrants(3000, 2000), quality=90)
    image = decode(path, 1024)
    assert image.shape == (683, 1024, 3)
    assert close(image, scale_to(decode(path), 1024), by=3)


def test_small_pictures_are_not_blown_up(tmp_path: Path) -> None:
    assert decode(write_image(tmp_path / "small.png"), 1024).shape == (64, 96, 3)


def test_the_smallest_allowed_picture_is_read(tmp_path: Path) -> None:
    assert decode(write_image(tmp_path / "small.png", quadrants(32, 32))).shape == (32, 32, 3)


@pytest.mark.parametrize("size", [(1, 1), (31, 400), (400, 31)])
def test_tiny_pictures_are_refused(tmp_path: Path, size: tuple[int, int]) -> None:
    path = write_image(tmp_path / "tiny.png", quadrants(*size))
    with pytest.raises(PhotoError, match=f"tiny.png is {size[0]}x{size[1]} pixels: at least 32x32"):
        decode(path)


def test_a_missing_picture_is_named(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match=r"000004\.jpg cannot be read: No such file"):
        decode(tmp_path / "000004.jpg")


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"this is a letter, not a picture\n", "a text file"),
        (b"", "empty"),
        (b"\x00\x00\x00\x18ftypqt  " + bytes(40), "a video"),
        (b"\x00\x00\x00\x18ftypheic" + bytes(40), "broken or cut off"),
        (b"RIFF\x10\x00\x00\x00WEBPVP8 " + bytes(40), "broken or cut off"),
        (b"GIF89a" + bytes(40), "a GIF file"),
        (b"\xff\xd8\xff", "cut off"),
    ],
)
def test_other_files_named_jpg_are_told_for_what_they_are(tmp_path: Path, content: bytes, what: str) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(content)
    with pytest.raises(PhotoError, match=rf"photo\.jpg is {what}"):
        decode(path)


@pytest.mark.parametrize("suffix", ["heic", "webp", "avif", "tiff", "bmp"])
def test_photos_of_newer_phones_and_of_scanners_are_read(tmp_path: Path, suffix: str) -> None:
    pillow_heif.register_heif_opener()
    path = tmp_path / f"photo.{suffix}"
    Image.fromarray(quadrants()).save(path)
    read = decode(path).astype(int)
    assert read.shape == quadrants().shape
    assert np.abs(read - quadrants()).mean() < 6


@pytest.mark.parametrize("suffix", ["jpg", "png"])
@pytest.mark.parametrize("part", [0.2, 0.5, 0.9])
def test_cut_off_pictures_are_refused(tmp_path: Path, suffix: str, part: float) -> None:
    whole = write_image(tmp_path / f"whole.{suffix}", noise(200, 200)).read_bytes()
    path = tmp_path / f"cut.{suffix}"
    path.write_bytes(whole[: int(len(whole) * part)])
    for longest in (None, 64):
        with pytest.raises(PhotoError, match="cut off"):
            decode(path, longest)


def png_header(width: int, height: int) -> bytes:
    """A PNG that claims a size and holds next to nothing."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


@pytest.mark.parametrize("size", [(11000, 11000), (30000, 30000), (2**31 - 1, 2**31 - 1)])
def test_decompression_bombs_are_refused_before_they_unpack(size: tuple[int, int]) -> None:
    with pytest.raises(PhotoError, match="pixels: at most 120 million are read"):
        decode_bytes(png_header(*size), "bomb.png")


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damaged_files_give_a_picture_or_a_sentence(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(["JPEG", "PNG"]))
    exif = Image.Exif()
    exif[0x0112] = 6
    buffer = io.BytesIO()
    Image.fromarray(quadrants(64, 48)).save(buffer, kind, exif=exif)
    damaged = bytearray(buffer.getvalue())
    for _ in range(data.draw(st.integers(1, 6))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    try:
        image = decode_bytes(bytes(damaged), "damaged", data.draw(st.sampled_from([None, 40])))
    except PhotoError as error:
        assert "\n" not in str(error)
    else:
        assert image.ndim == 3
        assert image.shape[2] == 3


def test_pictures_for_models_fit_even_when_they_are_noise() -> None:
    picture = encode_for_model(noise(2400, 1800))
    assert len(picture.data) <= MAX_ENCODED_BYTES
    assert max(picture.width, picture.height) <= 1024
    assert Image.open(io.BytesIO(picture.data)).size == (picture.width, picture.height)


def test_pictures_for_models_keep_their_colours() -> None:
    picture = encode_for_model(quadrants(900, 600))
    assert (picture.mime, picture.width, picture.height) == ("image/jpeg", 900, 600)
    assert close(decode_bytes(picture.data, "sent"), quadrants(900, 600), by=3)


def test_a_limit_that_cannot_be_met_at_this_size_shrinks_the_picture() -> None:
    picture = encode_for_model(noise(1024, 1024), max_bytes=50_000)
    assert len(picture.data) <= 50_000
    assert picture.width < 1024


def test_png_is_exact() -> None:
    picture = encode_png(noise(64, 40))
    assert picture.mime == "image/png"
    assert np.array_equal(decode_bytes(picture.data, "sent"), noise(64, 40))


@pytest.mark.reference("photos/blackboard")
def test_phone_photos_are_read() -> None:
    path = REFERENCE / "photos/blackboard/IMG_6365.jpg"
    assert decode(path).shape == (1024, 768, 3)
    assert decode(path, 512).shape == (512, 384, 3)
