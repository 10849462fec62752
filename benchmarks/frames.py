"""How fast photos are read and videos searched for keyframes. Prints one JSON document.

    python benchmarks/frames.py [--repeat N]

A photo of 12 million pixels is written first; every figure is the median of N runs in milliseconds.
"""

import argparse
import io
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from folding_server.frames.image_files import decode, encode_for_model
from folding_server.frames.keyframes import propose_keyframes
from PIL import Image, ImageOps

PHOTO_SIZE = (4032, 3024)
VIDEO_SIZE = (1280, 720)
VIDEO_SECONDS = 20
RATE = 30


def write_photo(path: Path) -> None:
    """A photo with the detail of a real one: soft shapes, fine grain, a quarter turn in its EXIF data."""
    random = np.random.default_rng(0)
    coarse = random.integers(0, 256, (30, 40, 3), np.uint8)
    image = np.asarray(Image.fromarray(coarse).resize(PHOTO_SIZE, Image.Resampling.BICUBIC)).astype(
        np.float32
    )
    grainy = np.clip(image + random.normal(0, 6, image.shape), 0, 255).astype(np.uint8)
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(grainy).save(path, quality=92, exif=exif)


def write_video(path: Path) -> None:
    """A card that lies still for two seconds and then slides for half a second, again and again."""
    table = np.random.default_rng(0).integers(90, 120, (*VIDEO_SIZE[::-1], 3), np.uint8)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=RATE, options={"preset": "veryfast"})
        stream.width, stream.height = VIDEO_SIZE
        stream.pix_fmt = "yuv420p"
        for number in range(VIDEO_SECONDS * RATE):
            lap, beat = divmod(number / RATE, 2.5)
            left = int(100 + 90 * (lap + max(0.0, beat - 2.0) * 2))
            picture = table.copy()
            picture[200:500, left : left + 300] = (230, 60, 50)
            frame = av.VideoFrame.from_ndarray(picture, "rgb24")
            frame.pts, frame.time_base = number, Fraction(1, RATE)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def pillow_alone(path: Path) -> bytes:
    """What a plain script does: open, turn upright, convert, scale, save."""
    image = ImageOps.exif_transpose(Image.open(path)).convert("RGB")
    image.thumbnail((1024, 1024), Image.Resampling.LANCZOS, reducing_gap=None)
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=92, subsampling=0)
    return buffer.getvalue()


def median_ms(run: Callable[[], object], repeat: int) -> float:
    """The median time of `run` in milliseconds, after one run to warm up."""
    run()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        run()
        times.append(1000 * (time.perf_counter() - start))
    return round(statistics.median(times), 1)


def measure(folder: Path, repeat: int) -> dict[str, object]:
    """Write the photo and the video to `folder`, and time what the server does with them."""
    photo, video = folder / "photo.jpg", folder / "clip.mp4"
    write_photo(photo)
    write_video(video)
    search = median_ms(lambda: propose_keyframes(video), max(1, repeat // 5))
    return {
        "photo_pixels": PHOTO_SIZE[0] * PHOTO_SIZE[1],
        "photo_file_bytes": photo.stat().st_size,
        "decode_full_ms": median_ms(lambda: decode(photo), repeat),
        "for_model_ms": median_ms(lambda: encode_for_model(decode(photo, 1024)), repeat),
        "for_model_plain_pillow_ms": median_ms(lambda: pillow_alone(photo), repeat),
        "for_model_bytes": len(encode_for_model(decode(photo, 1024)).data),
        "video_images": VIDEO_SECONDS * RATE,
        "video_size": VIDEO_SIZE,
        "keyframes_found": len(propose_keyframes(video)),
        "keyframes_expected": VIDEO_SECONDS * 2 // 5,
        "keyframes_ms": search,
        "keyframes_ms_per_second_of_video": round(search / VIDEO_SECONDS, 1),
    }


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=7, help="runs of each measurement")
    repeat = parser.parse_args().repeat
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(measure(Path(folder), repeat), indent=1))  # noqa: T201  (its output)


if __name__ == "__main__":
    main()
