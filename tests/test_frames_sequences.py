"""Sequence folders: manifests, photos by frame, images in between, and the library that serves them."""

import io
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from folding_server.errors import PhotoError
from folding_server.frames.color_names import color_rgb
from folding_server.frames.filmstrip import evenly_spaced
from folding_server.frames.photo_cache import PhotoCache
from folding_server.frames.sequences import Library, load_sequence
from hypothesis import given
from hypothesis import strategies as st
from paths import EXAMPLES
from pictures import noise, write_image, write_manifest, write_sequence_folder
from PIL import Image
from reference_data import REFERENCE


def test_a_sequence_tells_its_frames_and_colours(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [4, 10, 15], front_color="red", back_color="#FFFFFF")
    sequence = load_sequence(folder)
    assert (sequence.name, sequence.frame_count, sequence.keyframes) == ("crane", 3, (4, 10, 15))
    assert (sequence.front_color, sequence.back_color) == ("red", "#FFFFFF")
    assert sequence.photo(2)[0, 0].tolist() == [10, 10, 10]


def test_name_and_colours_may_be_missing(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "boat", [1])
    write_manifest(folder, {"keyframes": [1], "front_color": None})
    sequence = load_sequence(folder)
    assert (sequence.name, sequence.front_color, sequence.back_color) == ("boat", None, None)


def test_images_may_have_any_usual_suffix_and_any_number_of_zeros(tmp_path: Path) -> None:
    write_manifest(tmp_path, keyframes=[1, 2, 3, 12])
    for name in ("000001.JPG", "2.jpeg", "03.PNG", "0012.jpg"):
        write_image(tmp_path / "frames" / name)
    write_image(tmp_path / "frames" / "cover.jpg")
    assert load_sequence(tmp_path).photo(4).shape == (64, 96, 3)


def test_photos_cannot_be_written_to(tmp_path: Path) -> None:
    photo = load_sequence(write_sequence_folder(tmp_path / "crane", [1])).photo(1)
    with pytest.raises(ValueError, match="read-only"):
        photo[0, 0] = 0


def test_pixels_are_read_only_when_asked_for(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1, 2])
    (folder / "frames/000002.png").write_text("not a picture")
    sequence = load_sequence(folder)
    assert sequence.photo(1).shape == (64, 96, 3)
    with pytest.raises(PhotoError, match=r"frames/000002\.png is a text file"):
        sequence.photo(2)


def test_a_replaced_photo_is_seen(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1])
    sequence = load_sequence(folder)
    before = sequence.photo(1)
    write_image(folder / "frames/000001.png", noise(80, 80))
    assert before.shape != sequence.photo(1).shape


def test_a_photo_for_a_model_is_small(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1])
    write_image(folder / "frames/000001.png", noise(1600, 1200))
    picture = load_sequence(folder).photo_for_model(1)
    assert len(picture.data) < 800_000
    assert (picture.width, picture.height) == (1024, 768)
    assert Image.open(io.BytesIO(picture.data)).size == (1024, 768)


@pytest.mark.parametrize("frame", [0, 99, -1, True, 1.0, "1"])
def test_frames_that_are_not_there_are_refused(tmp_path: Path, frame: int) -> None:
    sequence = load_sequence(write_sequence_folder(tmp_path / "crane", list(range(1, 10))))
    for ask in (sequence.photo, sequence.photo_for_model, sequence.between, sequence.filmstrip):
        with pytest.raises(PhotoError, match=rf"frame {frame} is not in 1\.\.9"):
            ask(frame)


def test_between_gives_at_most_five_evenly_spaced_images(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [10, 30, 33], others=(5, *range(11, 30), 31))
    sequence = load_sequence(folder)
    assert sequence.between(1) == []
    assert sequence.between(2) == [13, 17, 20, 23, 27]
    assert sequence.between(2, count=None) == list(range(11, 30))
    assert sequence.between(3) == [31]


@given(st.lists(st.integers(0, 10_000), unique=True).map(sorted), st.integers(1, 8))
def test_evenly_spaced_choices_are_distinct_and_leave_equal_gaps(items: list[int], count: int) -> None:
    chosen = evenly_spaced(items, count)
    places = [items.index(item) for item in chosen]
    assert len(chosen) == min(count, len(items))
    gaps = np.diff([-1, *places, len(items)])
    assert gaps.min() >= 1
    if len(items) > count:
        assert gaps.max() - gaps.min() <= 1


def test_a_filmstrip_shows_the_images_in_between(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [10, 200], others=(60, 100, 140))
    strip = load_sequence(folder).filmstrip(2)
    pixels = np.asarray(Image.open(io.BytesIO(strip.data)))
    middle = pixels[pixels.shape[0] * 2 // 3, :, 0]
    for place, grey in ((1 / 6, 60), (1 / 2, 100), (5 / 6, 140)):
        assert abs(int(middle[int(len(middle) * place)]) - grey) <= 2
    assert strip.caption.startswith("3 of the images between frames 1 and 2")
    assert len(strip.data) < 800_000


def test_a_filmstrip_of_noise_is_small(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1, 9])
    for index in range(2, 9):
        write_image(folder / f"frames/{index}.png", noise(700, 700, index))
    strip = load_sequence(folder).filmstrip(2)
    assert len(strip.data) < 800_000
    assert max(strip.width, strip.height) <= 2000


def test_without_images_in_between_the_filmstrip_shows_both_keyframes_and_says_so(tmp_path: Path) -> None:
    sequence = load_sequence(write_sequence_folder(tmp_path / "crane", [40, 180]))
    strip = sequence.filmstrip(2)
    pixels = np.asarray(Image.open(io.BytesIO(strip.data)))
    row = pixels[pixels.shape[0] // 2, :, 0]
    assert abs(int(row[len(row) // 4]) - 40) <= 2
    assert abs(int(row[3 * len(row) // 4]) - 180) <= 2
    assert "no images between frames 1 and 2" in strip.caption
    with pytest.raises(PhotoError, match="frame 1 has no movement before it"):
        sequence.filmstrip(1)


def test_the_fingerprint_follows_manifest_and_keyframes_only(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1, 5], others=(3,))
    copy = write_sequence_folder(tmp_path / "copies" / "crane", [1, 5])
    original = load_sequence(folder).fingerprint()
    assert load_sequence(copy).fingerprint() == original
    write_image(folder / "frames/000003.png", noise(64, 64))
    assert load_sequence(folder).fingerprint() == original
    write_image(folder / "frames/000005.png", noise(64, 64))
    assert load_sequence(folder).fingerprint() != original


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ({"name": "x"}, "the key 'keyframes' is missing"),
        ({"keyframes": [1], "key_frames": [1]}, "the key 'key_frames' is not known; known are name"),
        ({"keyframes": []}, "'keyframes' is empty"),
        ({"keyframes": [1, 3, 3]}, "keyframes must increase, but 3 comes after 3"),
        ({"keyframes": [4, 2]}, "keyframes must increase, but 2 comes after 4"),
        ({"keyframes": [1, 2.5]}, r"keyframes\.1 is 2\.5, but keyframes are whole numbers"),
        ({"keyframes": [1, "2"]}, r"keyframes\.1 is '2', but keyframes are whole numbers"),
        ({"keyframes": [True]}, r"keyframes\.0 is True, but keyframes are whole numbers"),
        ({"keyframes": [-1]}, r"keyframes\.0 is -1"),
        ({"keyframes": 4}, "keyframes is 4"),
        ([1, 2], "it must hold an object"),
        ({"keyframes": [1], "name": "../x"}, r"'\.\./x' is a path"),
        ({"keyframes": [1], "name": ""}, "'' is not usable"),
        ({"keyframes": [1], "frames": "../other"}, r"'\.\./other' is not a place inside"),
        ({"keyframes": [1], "frames": "/etc"}, "'/etc' is not a place inside"),
        ({"keyframes": [1], "frames": "photos"}, "has no folder 'photos' of images"),
        ({"keyframes": [1], "frames": "frames", "video": "clip.mp4"}, "either 'frames' .* or 'video'"),
        ({"keyframes": [1], "front_color": "redd"}, "the colour 'redd' is not known: write it as #rrggbb"),
        ({"keyframes": [1], "back_color": "#12345"}, "the colour '#12345' is not known"),
        ({"keyframes": [1], "back_color": 5}, "back_color is 5"),
        ({"keyframes": [1, 8]}, r"the image of keyframe 8 is missing: expected frames/000008\.jpg"),
    ],
)
def test_wrong_manifests_are_refused_in_one_sentence(tmp_path: Path, content: object, sentence: str) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [1, 2, 3, 4])
    write_manifest(folder, content)
    with pytest.raises(PhotoError, match=sentence) as refusal:
        load_sequence(folder)
    assert "\n" not in str(refusal.value)


def test_missing_pieces_are_named(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match=r"there is no folder .*nowhere"):
        load_sequence(tmp_path / "nowhere")
    with pytest.raises(PhotoError, match=r"it has no keyframes\.json"):
        load_sequence(tmp_path)
    for text in ("{keyframes: 1", "[" * 5000, "\xff"):
        (tmp_path / "keyframes.json").write_bytes(text.encode("latin-1"))
        with pytest.raises(PhotoError, match="is not JSON"):
            load_sequence(tmp_path)


def test_two_files_for_one_image_are_refused(tmp_path: Path) -> None:
    folder = write_sequence_folder(tmp_path / "crane", [4])
    write_image(folder / "frames/4.jpg")
    with pytest.raises(PhotoError, match=r"000004\.png and 4\.jpg in crane are both image 4"):
        load_sequence(folder)


def test_links_out_of_the_sequence_are_refused(tmp_path: Path) -> None:
    secret = write_image(tmp_path / "secret.png")
    folder = write_sequence_folder(tmp_path / "crane", [4])
    (folder / "frames/000005.png").symlink_to(secret)
    with pytest.raises(PhotoError, match=r"000005\.png in crane leads out of the sequence's folder"):
        load_sequence(folder)
    (folder / "photos").symlink_to(tmp_path)
    write_manifest(folder, keyframes=[4], frames="photos")
    with pytest.raises(PhotoError, match="photos in crane leads out"):
        load_sequence(folder)


def test_the_library_serves_roots_that_are_or_hold_sequences(tmp_path: Path) -> None:
    write_sequence_folder(tmp_path / "many" / "crane", [1, 2])
    write_sequence_folder(tmp_path / "many" / "boat", [1])
    (tmp_path / "many" / "notes").mkdir()
    write_sequence_folder(tmp_path / "single", [7])
    library = Library([tmp_path / "many", tmp_path / "single", tmp_path / "many" / "boat"])
    assert [sequence.name for sequence in library.sequences()] == ["boat", "crane", "single"]
    assert library.problems() == []
    assert library.open("crane").frame_count == 2


@pytest.mark.parametrize(
    "name",
    [
        "../secret",
        "..",
        ".",
        "/etc/passwd",
        "a/b",
        "a\\b",
        "..\\x",
        "",
        "   ",
        "nul\0byte",
        "line\nbreak",
        "x" * 500,
    ],
)
def test_names_that_are_paths_never_reach_the_disk(tmp_path: Path, name: str) -> None:
    write_sequence_folder(tmp_path / "secret", [1])
    write_sequence_folder(tmp_path / "open" / "crane", [1])
    with pytest.raises(PhotoError, match=r"is a path|is not usable") as refusal:
        Library([tmp_path / "open"]).open(name)
    assert len(str(refusal.value)) < 300


@given(name=st.text(max_size=30))
def test_only_listed_names_open(tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    root = tmp_path_factory.getbasetemp() / "listed"
    if not root.exists():
        write_sequence_folder(root / "crane", [1])
    with pytest.raises(PhotoError):
        Library([root]).open(name if name != "crane" else "Crane")


def test_unknown_names_are_answered_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match="there is no sequence 'crane': the server's folders hold none"):
        Library([tmp_path]).open("crane")
    write_sequence_folder(tmp_path / "boat", [1])
    with pytest.raises(PhotoError, match="there is no sequence 'crane': there are boat"):
        Library([tmp_path]).open("crane")


def test_a_link_out_of_the_root_is_not_served(tmp_path: Path) -> None:
    write_sequence_folder(tmp_path / "secret", [1])
    root = tmp_path / "open"
    root.mkdir()
    (root / "alias").symlink_to(tmp_path / "secret")
    library = Library([root])
    assert library.sequences() == []
    with pytest.raises(PhotoError, match="there is no sequence 'secret'"):
        library.open("secret")


def test_a_manifest_that_links_out_is_a_problem_not_a_leak(tmp_path: Path) -> None:
    (tmp_path / "secret.json").write_text('{"token": 1}')
    folder = write_sequence_folder(tmp_path / "open" / "crane", [1])
    (folder / "keyframes.json").unlink()
    (folder / "keyframes.json").symlink_to(tmp_path / "secret.json")
    with pytest.raises(PhotoError, match=r"keyframes\.json in crane leads out"):
        Library([tmp_path / "open"]).open("crane")


def test_two_sequences_of_one_name_are_refused_and_others_still_served(tmp_path: Path) -> None:
    write_sequence_folder(tmp_path / "a" / "crane", [1])
    write_sequence_folder(tmp_path / "b" / "crane", [1])
    write_sequence_folder(tmp_path / "b" / "boat", [1])
    library = Library([tmp_path / "a", tmp_path / "b"])
    assert [sequence.name for sequence in library.sequences()] == ["boat"]
    with pytest.raises(PhotoError, match="2 sequences are called 'crane' \\(a/crane and b/crane\\)"):
        library.open("crane")
    assert len(library.problems()) == 1


def test_a_broken_folder_spoils_only_itself_and_says_why(tmp_path: Path) -> None:
    write_sequence_folder(tmp_path / "boat", [1])
    write_manifest(tmp_path / "crane", {"keyframes": []})
    library = Library([tmp_path])
    assert [sequence.name for sequence in library.sequences()] == ["boat"]
    assert library.problems() == ["crane/keyframes.json: 'keyframes' is empty; list at least one image"]
    with pytest.raises(PhotoError, match="'keyframes' is empty"):
        library.open("crane")


def test_the_library_follows_changes_on_disk(tmp_path: Path) -> None:
    library = Library([tmp_path])
    assert library.sequences() == []
    folder = write_sequence_folder(tmp_path / "boat", [1])
    first = library.open("boat")
    assert library.open("boat") is first
    write_image(folder / "frames/000009.png")
    write_manifest(folder, name="ship", keyframes=[1, 9])
    assert library.open("ship").frame_count == 2


def test_a_root_that_is_no_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match=r"there is no folder .*gone to serve sequences from"):
        Library([tmp_path / "gone"])


def test_the_cache_holds_the_latest_photos_within_its_bytes() -> None:
    cache = PhotoCache(capacity=3 * 300)
    made: list[int] = []

    def photo(key: int) -> None:
        cache.get(key, lambda: made.append(key) or np.zeros((10, 10, 3), np.uint8))

    for key in (1, 2, 3, 1, 4, 1, 2):
        photo(key)
    assert made == [1, 2, 3, 4, 2]
    assert cache.bytes_held == 900


def test_threads_share_a_cache(tmp_path: Path) -> None:
    sequence = load_sequence(write_sequence_folder(tmp_path / "crane", [1, 2, 3]))
    with ThreadPoolExecutor(8) as pool:
        photos = list(pool.map(sequence.photo, [1, 2, 3] * 20))
    assert [int(photo[0, 0, 0]) for photo in photos] == [1, 2, 3] * 20


@pytest.mark.parametrize(
    ("color", "rgb"),
    [
        ("red", (255, 0, 0)),
        ("#0A0b0C", (10, 11, 12)),
        ("Light Blue", (173, 216, 230)),
        ("off-white", (250, 249, 246)),
    ],
)
def test_colours_are_read_as_people_write_them(color: str, rgb: tuple[int, int, int]) -> None:
    assert color_rgb(color) == rgb


@pytest.mark.parametrize("color", ["", "#fff", "rgb(1,2,3)", "#gggggg", "reddish", "#0000000"])
def test_other_colours_are_refused(color: str) -> None:
    with pytest.raises(PhotoError, match="write it as #rrggbb"):
        color_rgb(color)


def test_the_examples_open() -> None:
    library = Library([EXAMPLES])
    assert {sequence.name: sequence.frame_count for sequence in library.sequences()} == {
        "cat": 9,
        "cup": 8,
        "heart": 16,
    }
    assert "no images between" in library.open("cat").filmstrip(4).caption


@pytest.mark.reference("photos/rendered", "photos/sailboat")
def test_real_sequences_open() -> None:
    library = Library([REFERENCE / "photos/rendered", REFERENCE / "photos/sailboat"])
    assert {sequence.name: sequence.frame_count for sequence in library.sequences()} == {
        "how_to_make_an_easy_origami_tulip_stem": 9,
        "sailboat": 4,
        "very_easy_origami_sloth_instructions": 16,
    }
    assert "no images between" in library.open("sailboat").filmstrip(4).caption


def test_sequences_load_neither_opencv_nor_the_video_library() -> None:
    code = "import sys, folding_server.frames.sequences; print({'cv2', 'av', 'scipy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert run.stdout.strip() == "set()"


def test_a_broken_sequence_asked_for_by_its_own_name_says_what_is_broken(tmp_path: Path) -> None:
    folder = tmp_path / "download"
    folder.mkdir()
    (folder / "keyframes.json").write_text('{"name": "hat", "frames": "frames", "keyframes": [1, 2]}')
    with pytest.raises(PhotoError, match="frames"):
        Library([folder]).open("hat")
