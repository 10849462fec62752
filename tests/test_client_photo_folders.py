"""A folder of photos without a manifest: in which order they are taken, and what is said and written."""

import json
from pathlib import Path

import pytest
from folding_client.interrupts import UsageError
from folding_client.photo_folders import as_sequence
from folding_server.frames.sequences import load_sequence
from PIL import Image

TAKEN, EXIF = 36867, 0x8769


def photo(path: Path, taken: str | None = None, shade: int = 100) -> None:
    image = Image.new("RGB", (64, 48), (shade, shade, shade))
    exif = image.getexif()
    if taken:
        exif.get_ifd(EXIF)[TAKEN] = taken
    image.save(path, exif=exif)


def manifest(folder: Path) -> dict[str, object]:
    read: dict[str, object] = json.loads((folder / "keyframes.json").read_text(encoding="utf-8"))
    return read


def test_photos_are_taken_in_the_order_of_their_names_ten_after_nine(tmp_path: Path) -> None:
    for name in ("step10.jpg", "step9.JPG", "step1.png"):
        photo(tmp_path / name)
    said: list[str] = []
    as_sequence(tmp_path, said.append)
    assert manifest(tmp_path)["keyframes"] == ["step1.png", "step9.JPG", "step10.jpg"]
    assert len(said) == 1
    assert said[0].startswith("3 photos in the order of their names: step1.png, step9.JPG, step10.jpg. ")


def test_the_time_at_which_all_were_taken_counts_for_more_than_their_names(tmp_path: Path) -> None:
    photo(tmp_path / "b.jpg", "2026:05:01 10:00:00")
    photo(tmp_path / "a.jpg", "2026:05:01 10:00:30")
    said: list[str] = []
    as_sequence(tmp_path, said.append)
    assert manifest(tmp_path)["keyframes"] == ["b.jpg", "a.jpg"]
    assert "in the order of when they were taken" in said[0]


def test_what_was_written_is_a_sequence_in_that_order(tmp_path: Path) -> None:
    photo(tmp_path / "second.jpg", "2026:05:01 10:00:30", 200)
    photo(tmp_path / "zeroth.jpg", "2026:05:01 10:00:00", 50)
    as_sequence(tmp_path, lambda _: None)
    sequence = load_sequence(tmp_path)
    assert [int(sequence.photo(frame).mean()) for frame in (1, 2)] == [50, 200]


def test_a_folder_with_a_manifest_or_a_single_photo_stays_as_it_is(tmp_path: Path) -> None:
    photo(tmp_path / "only.jpg")
    as_sequence(tmp_path, pytest.fail)
    assert not (tmp_path / "keyframes.json").exists()
    photo(tmp_path / "other.jpg")
    (tmp_path / "keyframes.json").write_text("{}", encoding="utf-8")
    as_sequence(tmp_path, pytest.fail)
    assert (tmp_path / "keyframes.json").read_text(encoding="utf-8") == "{}"


def test_a_folder_that_cannot_be_written_is_refused_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("1.jpg", "2.jpg"):
        photo(tmp_path / name)

    def refuse(*_: object, **__: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "write_text", refuse)
    with pytest.raises(UsageError, match="none can be written there .Permission denied.; copy the photos"):
        as_sequence(tmp_path, lambda _: None)
