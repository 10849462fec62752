"""Reading videos by image index: any frame rate, any turn, and files that are not whole."""

import wave
from pathlib import Path

import av
import numpy as np
import pytest
from folding_server.errors import PhotoError
from folding_server.frames.sequences import load_sequence
from folding_server.frames.video import Video, open_video
from pictures import quadrants, write_manifest
from videos import Camera, encode

GREYS = [8 * index for index in range(30)]


def write_greys(path: Path, camera: Camera = Camera(), times: list[float] | None = None) -> Path:
    """A video whose image `index` has the grey 8 * index."""
    times = times or [index / 30 for index in range(30)]
    encode(path, (np.full((64, 96, 3), grey, np.uint8) for grey in GREYS), times, camera)
    return path


def grey(video: Video, index: int) -> float:
    return float(video.read(index).mean())


@pytest.mark.parametrize(
    ("name", "camera"),
    [
        ("clip.mp4", Camera()),
        ("clip.mkv", Camera()),
        ("clip.mov", Camera()),
        ("clip.avi", Camera(codec="mpeg4")),
        ("clip.webm", Camera(codec="libvpx")),
        ("clip.h264", Camera()),
    ],
)
def test_images_are_found_by_index_in_any_order(tmp_path: Path, name: str, camera: Camera) -> None:
    video = open_video(write_greys(tmp_path / name, camera))
    assert list(video.indices()) == list(range(30))
    for index in (0, 29, 7, 26, 25, 24, 12):
        assert grey(video, index) == pytest.approx(GREYS[index], abs=4)
    together = [(moment.index, float(moment.image.mean())) for moment in video.read_each([3, 4, 11, 28])]
    assert together == [(index, pytest.approx(GREYS[index], abs=4)) for index in (3, 4, 11, 28)]


def test_times_follow_a_variable_frame_rate(tmp_path: Path) -> None:
    times = [round(0.01 * index + 0.004 * index**2, 3) for index in range(30)]
    video = open_video(write_greys(tmp_path / "clip.mp4", times=times))
    assert video.times == pytest.approx(times, abs=2e-3)
    assert grey(video, 17) == pytest.approx(GREYS[17], abs=4)
    moments = list(video.moments(96, 4.0))
    assert [moment.seconds for moment in moments] == pytest.approx(
        [times[moment.index] for moment in moments], abs=2e-3
    )
    assert min(np.diff([moment.seconds for moment in moments])) > 0.12


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_images_are_turned_upright(tmp_path: Path, degrees: int, mirrored: bool) -> None:
    shown = quadrants(96, 64)
    stored = shown[:, ::-1] if mirrored else shown
    stored = np.ascontiguousarray(np.rot90(stored, -degrees // 90))
    path = tmp_path / "turned.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=10)
        stream.height, stream.width = stored.shape[:2]
        stream.pix_fmt = "yuv420p"
        stream.set_display_rotation(degrees, hflip=mirrored)
        for _ in range(3):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(stored, "rgb24")))
        container.mux(stream.encode())
    image = open_video(path).read(1)
    assert image.shape == shown.shape
    for y in (16, 48):
        for x in (24, 72):
            assert np.abs(image[y, x].astype(int) - shown[y, x]).max() < 16


def test_images_are_scaled_when_asked(tmp_path: Path) -> None:
    video = open_video(write_greys(tmp_path / "clip.mp4"))
    assert video.read(3, longest=48).shape == (32, 48, 3)
    assert video.read(3, longest=4000).shape == (64, 96, 3)


@pytest.mark.parametrize("index", [-1, 30, 1000])
def test_indices_outside_the_video_are_refused(tmp_path: Path, index: int) -> None:
    video = open_video(write_greys(tmp_path / "clip.mp4"))
    with pytest.raises(PhotoError, match=rf"image {index} is not in clip\.mp4, whose images are 0\.\.29"):
        video.read(index)


@pytest.mark.parametrize(
    ("name", "part"), [("a.mp4", 0.5), ("a.mp4", 0.9), ("a.mkv", 0.5), ("fast.mp4", 0.6)]
)
def test_videos_that_are_cut_off_are_refused(tmp_path: Path, name: str, part: float) -> None:
    frames = (np.random.default_rng(n).integers(0, 255, (64, 96, 3), np.uint8) for n in range(90))
    whole = tmp_path / f"whole_{name}"
    encode(whole, frames, [n / 30 for n in range(90)])
    if name == "fast.mp4":
        whole = with_index_first(whole)
    path = tmp_path / name
    path.write_bytes(whole.read_bytes()[: int(whole.stat().st_size * part)])
    with pytest.raises(PhotoError, match=r"\.(mp4|mkv) (is|cannot be (read|decoded).*it is) cut off"):
        open_video(path)


def with_index_first(path: Path) -> Path:
    """The same video with its index at the start, as web sites serve them."""
    fast = path.with_name("index_first.mp4")
    with av.open(str(path)) as source, av.open(str(fast), "w", options={"movflags": "faststart"}) as target:
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(source.streams.video[0]):
            if packet.dts is not None:
                packet.stream = stream
                target.mux(packet)
    return fast


def test_sound_alone_is_no_video(tmp_path: Path) -> None:
    path = tmp_path / "song.wav"
    with wave.open(str(path), "wb") as song:
        song.setparams((1, 2, 8000, 0, "NONE", ""))
        song.writeframes(bytes(16000))
    with pytest.raises(PhotoError, match=r"song\.wav is no video: it holds only sound"):
        open_video(path)


@pytest.mark.parametrize(
    "content", [b"", b"a letter, not a film\n" * 40, b"#EXTM3U\n#EXTINF:1,\n/etc/passwd\n"]
)
@pytest.mark.parametrize("name", ["clip.mp4", "clip.m3u8", "clip.txt"])
def test_other_files_are_refused(tmp_path: Path, content: bytes, name: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(PhotoError, match=f"{name} cannot be read as a video"):
        open_video(tmp_path / name)


def test_a_missing_video_is_named(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match=r"there is no video gone\.mp4"):
        open_video(tmp_path / "gone.mp4")


def test_a_folder_is_no_video(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match="is a folder: name the file of a video"):
        open_video(tmp_path)


def test_a_video_may_stand_in_for_a_folder_of_images(tmp_path: Path) -> None:
    write_greys(tmp_path / "clip.mp4")
    write_manifest(tmp_path, name="greys", video="clip.mp4", keyframes=[2, 9, 10])
    sequence = load_sequence(tmp_path)
    assert float(sequence.photo(2).mean()) == pytest.approx(GREYS[9], abs=4)
    assert sequence.between(2) == [3, 4, 6, 7, 8]
    assert sequence.filmstrip(2).caption.startswith("5 of the images")
    assert "no images between" in sequence.filmstrip(3).caption
    assert sequence.photo_for_model(1).mime == "image/jpeg"
    assert len(sequence.fingerprint()) == 64


def test_a_keyframe_beyond_the_video_is_refused(tmp_path: Path) -> None:
    write_greys(tmp_path / "clip.mp4")
    write_manifest(tmp_path, video="clip.mp4", keyframes=[2, 30])
    with pytest.raises(PhotoError, match=r"image 30 is not in clip\.mp4, whose images are 0\.\.29"):
        load_sequence(tmp_path)
    write_manifest(tmp_path, video="gone.mp4", keyframes=[2])
    with pytest.raises(PhotoError, match=r"there is no video gone\.mp4"):
        load_sequence(tmp_path)
