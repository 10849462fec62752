"""Images in and out: decode what phones and scanners write, scale it, encode it small enough for a model."""

import io
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError

from folding_server.arrays import RgbImage
from folding_server.errors import PhotoError

MODEL_SIDE = 1024
MAX_ENCODED_BYTES = 590_000
"""Largest encoded picture: it stays under 800 kB when it travels in base64, which adds a third."""
MIN_SIDE = 32
MAX_PIXELS = 120_000_000
QUALITIES = (92, 85, 76, 66, 55, 42)
_DRAFT_MARGIN = 1.5
_SIGNATURES = (
    (b"ftyp", 4, "a video or a damaged HEIC or AVIF file"),
    (b"WEBP", 8, "a damaged WebP file"),
    (b"GIF8", 0, "a GIF file"),
    (b"%PDF", 0, "a PDF file"),
    (b"\xff\xd8\xff", 0, "cut off near its start"),
    (b"\x89PNG\r\n", 0, "cut off near its start"),
)
PHOTO_FORMATS = ("JPEG", "PNG", "WEBP", "AVIF", "TIFF", "BMP")
"""Formats that Pillow reads itself, as it calls them."""
READ_FORMATS = "JPEG, PNG, HEIC, WebP, AVIF, TIFF or BMP"
"""What is read, in words."""
_HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"mif1", b"msf1")
"""The brands by which a HEIC file says what it is, after its first box."""
_HEAD_BYTES = 16
_BROKEN = (
    OSError,
    SyntaxError,
    ValueError,
    EOFError,
    struct.error,
    zlib.error,
    IndexError,
    TypeError,
    KeyError,
)


@dataclass(frozen=True)
class EncodedImage:
    """An encoded image, ready to send: bytes, media type, size in pixels, and what it shows in words."""

    data: bytes
    mime: str
    width: int
    height: int
    caption: str = ""


def decode(path: Path, longest: int | None = None) -> RgbImage:
    """The photo at `path`, of one of the formats READ_FORMATS, as RGB, shape (height, width, 3), upright, on white where transparent.

    With `longest` the picture is scaled down until its longest side is at most that many pixels.
    Raises PhotoError for a missing file, another format, a broken or cut-off file, and impossible sizes.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise PhotoError(f"{_short(path)} cannot be read: {error.strerror or error}") from error
    return decode_bytes(data, _short(path), longest)


def decode_bytes(data: bytes, called: str, longest: int | None = None) -> RgbImage:
    """Like `decode`, from the bytes of the file; `called` names the picture in errors."""
    image = _open(data, called)
    _check_size(image, called)
    try:
        if longest is not None:
            image.draft("RGB", _draft_size(image, longest))
        image.load()
        upright = _upright(image)
    except _BROKEN as error:
        raise PhotoError(
            f"{called} is broken or cut off ({error}): copy it again from where it came"
        ) from error
    except Image.DecompressionBombError as error:
        raise PhotoError(f"{called} unpacks to far more than its size and was refused") from error
    shrunk = upright if longest is None else _shrink(upright, longest)
    return np.asarray(shrunk, dtype=np.uint8)


def photo_format(path: Path) -> str | None:
    """What format a file's photo is of, by its first bytes, such as JPEG; None if it is none that is read, or of several images."""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    if _is_heif(head):
        return "HEIC"
    try:
        with Image.open(path, formats=(*PHOTO_FORMATS, "GIF")) as image:
            return image.format if getattr(image, "n_frames", 1) == 1 else None
    except (*_BROKEN, Image.DecompressionBombError):
        return None


def scale_to(rgb: RgbImage, longest: int) -> RgbImage:
    """`rgb` scaled down so that its longest side is at most `longest` pixels; never scaled up."""
    if max(rgb.shape[:2]) <= longest:
        return rgb
    return np.asarray(_shrink(Image.fromarray(rgb), longest), dtype=np.uint8)


def encode_png(rgb: RgbImage, caption: str = "") -> EncodedImage:
    """`rgb` as a PNG of the same size; nothing is lost, so the size in bytes is not bounded."""
    buffer = io.BytesIO()
    Image.fromarray(rgb).save(buffer, "PNG", optimize=False, compress_level=6)
    return EncodedImage(buffer.getvalue(), "image/png", rgb.shape[1], rgb.shape[0], caption)


def encode_jpeg(rgb: RgbImage, quality: int, caption: str = "") -> EncodedImage:
    """`rgb` as a JPEG of a quality of 1 to 95, colours at full resolution: thin edges keep their colour."""
    buffer = io.BytesIO()
    Image.fromarray(rgb).save(buffer, "JPEG", quality=quality, subsampling=0)
    return EncodedImage(buffer.getvalue(), "image/jpeg", rgb.shape[1], rgb.shape[0], caption)


def encode_for_model(
    rgb: RgbImage, longest: int = MODEL_SIDE, max_bytes: int = MAX_ENCODED_BYTES, caption: str = ""
) -> EncodedImage:
    """`rgb` as a JPEG whose longest side is at most `longest` and which has at most `max_bytes` bytes.

    Quality steps down first; if the lowest is still too large, the picture shrinks by a fifth at a time.
    """
    scaled = scale_to(rgb, longest)
    for quality in QUALITIES:
        picture = encode_jpeg(scaled, quality, caption)
        if len(picture.data) <= max_bytes:
            return picture
    return encode_for_model(rgb, max(MIN_SIDE, max(scaled.shape[:2]) * 4 // 5), max_bytes, caption)


def _open(data: bytes, called: str) -> Image.Image:
    """The image, its pixels not read yet."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _heif(data) if _is_heif(data) else Image.open(io.BytesIO(data), formats=PHOTO_FORMATS)
    except UnidentifiedImageError as error:
        raise PhotoError(
            f"{called} is {_what(data)}, no {READ_FORMATS} image: save it as JPEG or PNG"
        ) from error
    except Image.DecompressionBombError as error:
        raise PhotoError(
            f"{called} has too many pixels: at most {MAX_PIXELS // 10**6} million are read"
        ) from error
    except _BROKEN as error:
        raise PhotoError(
            f"{called} is broken or cut off ({error}): copy it again from where it came"
        ) from error


def _is_heif(data: bytes) -> bool:
    return data[4:8] == b"ftyp" and data[8:12] in _HEIF_BRANDS


def _heif(data: bytes) -> Image.Image:
    """The main picture of a HEIC file, upright: the file says how it is turned."""
    import pillow_heif  # noqa: PLC0415  (loads its codecs)

    picture = pillow_heif.open_heif(io.BytesIO(data), convert_hdr_to_8bit=True)
    return Image.frombytes(
        picture.mode, picture.size, bytes(picture.data), "raw", picture.mode, picture.stride
    )


def _what(data: bytes) -> str:
    """What a file that no photo can be read from seems to be, in words."""
    if not data:
        return "empty"
    for start, offset, name in _SIGNATURES:
        if data.startswith(start, offset):
            return name
    return "a text file" if _is_text(data[:512]) else "some other file"


def _is_text(start: bytes) -> bool:
    return all(byte >= ord(" ") or byte in b"\t\r\n" for byte in start)


def _check_size(image: Image.Image, called: str) -> None:
    width, height = image.size
    if min(width, height) < MIN_SIDE:
        raise PhotoError(f"{called} is {width}x{height} pixels: at least {MIN_SIDE}x{MIN_SIDE} are needed")
    if width * height > MAX_PIXELS:
        raise PhotoError(
            f"{called} is {width}x{height} pixels: at most {MAX_PIXELS // 10**6} million are read, "
            "scale it down"
        )


def _draft_size(image: Image.Image, longest: int) -> tuple[int, int]:
    """The least size a JPEG decoder may stop at without harm to the final scaling."""
    factor = _DRAFT_MARGIN * longest / max(image.size)
    return max(1, int(image.width * factor)), max(1, int(image.height * factor))


def _upright(image: Image.Image) -> Image.Image:
    """`image` as 8 bit RGB, turned as its EXIF orientation says, over white."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # damaged EXIF data: the picture is shown as it lies in the file
        turned = ImageOps.exif_transpose(image)
    if turned.mode.startswith("I") or turned.mode == "F":
        deep = np.asarray(turned).astype(np.float64)
        return Image.fromarray(np.clip(np.rint(deep / 257.0), 0, 255).astype(np.uint8)).convert("RGB")
    if turned.mode in ("RGBA", "LA", "PA", "La", "RGBa") or "transparency" in turned.info:
        clear = turned.convert("RGBA")
        return Image.alpha_composite(Image.new("RGBA", clear.size, "white"), clear).convert("RGB")
    return turned.convert("RGB")


def _shrink(image: Image.Image, longest: int) -> Image.Image:
    factor = longest / max(image.size)
    if factor >= 1:
        return image
    size = max(1, round(image.width * factor)), max(1, round(image.height * factor))
    return image.resize(size, Image.Resampling.LANCZOS, reducing_gap=2.0)


def _short(path: Path) -> str:
    """The last two parts of a path: enough to find the file, no more of the server's disk than needed."""
    return f"{path.parent.name}/{path.name}" if path.parent.name else path.name
