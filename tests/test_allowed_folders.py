"""Which files of the user's own may be named by path: what leads out of the allowed folders is refused, whatever way."""

import os
import sys
from pathlib import Path

import pytest
from folding_server.errors import PhotoError
from folding_server.frames.allowed_folders import LONGEST_PATH, AllowedFolders


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home with films that may be read, and others that may not."""
    monkeypatch.setenv("HOME", str(tmp_path))
    for file in (
        "films/hat.mp4",
        "films/deep/crane.mp4",
        "films-secret/boat.mp4",
        "secret.mp4",
        "data/runs.sqlite3",
    ):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(b"film")
    return tmp_path


@pytest.fixture
def allowed(home: Path) -> AllowedFolders:
    return AllowedFolders((home / "films",), home / "data")


@pytest.mark.parametrize(
    "typed",
    [
        "~/films/hat.mp4",
        "hat.mp4",
        "deep/../hat.mp4",
        "~/films/./hat.mp4",
        "{home}/films/hat.mp4",
        "../films/hat.mp4",
    ],
)
def test_a_film_below_an_allowed_folder_is_found(home: Path, allowed: AllowedFolders, typed: str) -> None:
    assert allowed.find(typed.format(home=home)) == home / "films" / "hat.mp4"


def test_the_allowed_folder_itself_is_found(home: Path, allowed: AllowedFolders) -> None:
    assert allowed.find("~/films") == allowed.find(".") == home / "films"


@pytest.mark.parametrize(
    "typed",
    [
        "~/secret.mp4",
        "../secret.mp4",
        "~/films/../secret.mp4",
        "~/films-secret/boat.mp4",
        "../films-secret/boat.mp4",
        "/etc/passwd",
        "/proc/self/environ",
        "/dev/stdin",
        "/dev/fd/0",
        "~root/secret.mp4",
        "~nobody-of-this-name/x.mp4",
        "link.mp4",
        "folder/boat.mp4",
        "loop",
        "hat.mp4\0.png",
        "\0",
        "",
        "  ",
        "x" * (LONGEST_PATH + 1),
        "../" * 1000 + "etc/passwd",
        "file:///etc/passwd/../../secret.mp4/../../../../../../etc/passwd",
        "\udcff/../../secret.mp4",
        "deep/../../secret.mp4",
    ],
)
def test_what_leads_out_is_refused_with_the_folders_that_are_allowed(
    home: Path, allowed: AllowedFolders, typed: str
) -> None:
    films = home / "films"
    (films / "link.mp4").symlink_to(home / "secret.mp4")
    (films / "folder").symlink_to(home / "films-secret")
    (films / "loop").symlink_to(films / "loop")
    with pytest.raises(PhotoError, match="may not be read: only files in") as refusal:
        allowed.find(typed)
    said = str(refusal.value)
    assert str(films) in said
    assert "--allow" in said
    assert not [path for path in ("films-secret", "secret.mp4") if path in said and path not in typed]
    assert "\n" not in said
    assert "\0" not in said
    assert len(said) < 500


def test_a_refusal_does_not_tell_whether_a_file_is_there(home: Path, allowed: AllowedFolders) -> None:
    def refusal(typed: str) -> str:
        with pytest.raises(PhotoError) as error:
            allowed.find(typed)
        return str(error.value).replace(typed, "")

    assert refusal("~/secret.mp4") == refusal("~/nothing.mp4")
    (home / "films" / "out").symlink_to(home)
    assert refusal("out/secret.mp4") == refusal("out/nothing.mp4")


@pytest.mark.parametrize("typed", ["nothing.mp4", "~/films/nothing.mp4", "hat.mp4/x.mp4", "y" * 300])
def test_what_is_not_there_is_told_below_an_allowed_folder(allowed: AllowedFolders, typed: str) -> None:
    with pytest.raises(PhotoError, match="there is no file or folder"):
        allowed.find(typed)


def test_what_the_server_keeps_is_never_read_even_within_an_allowed_folder(home: Path) -> None:
    everything = AllowedFolders((home,), home / "data")
    assert everything.find("secret.mp4") == home / "secret.mp4"
    (home / "way").symlink_to(home / "data")
    for typed in ("data/runs.sqlite3", "data", "way/runs.sqlite3", "films/../data"):
        with pytest.raises(PhotoError, match="may not be read"):
            everything.find(typed)


def test_a_relative_path_is_looked_for_in_every_allowed_folder(home: Path) -> None:
    both = AllowedFolders((home / "films", home / "films-secret"), home / "data")
    assert both.find("boat.mp4") == home / "films-secret" / "boat.mp4"
    assert both.find("hat.mp4") == home / "films" / "hat.mp4"


def test_over_http_folders_are_named_by_their_last_part_alone(home: Path) -> None:
    shared = AllowedFolders((home / "films",), home / "data", short=True)
    with pytest.raises(PhotoError, match="only files in 'films' may; ask whoever runs the server") as refusal:
        shared.find("/etc/passwd")
    assert str(home) not in str(refusal.value)


def test_a_folder_may_be_allowed_by_a_link(home: Path) -> None:
    (home / "my films").symlink_to(home / "films")
    linked = AllowedFolders((home / "my films",), home / "data")
    assert linked.find("~/my films/hat.mp4") == linked.find("~/films/hat.mp4") == home / "films" / "hat.mp4"


def test_another_case_is_the_same_folder_only_where_the_file_system_says_so(
    home: Path, allowed: AllowedFolders
) -> None:
    same = os.path.exists(home / "FILMS")  # noqa: PTH110 - asks the file system
    if same:
        assert allowed.find("~/FILMS/hat.mp4").samefile(home / "films" / "hat.mp4")
    else:
        (home / "FILMS").mkdir()
        (home / "FILMS" / "hat.mp4").write_bytes(b"another")
        with pytest.raises(PhotoError, match="may not be read"):
            allowed.find("~/FILMS/hat.mp4")


@pytest.mark.skipif(sys.platform != "win32", reason="only Windows has drives")
@pytest.mark.parametrize("typed", [r"\\host\share\x.mp4", "Z:x.mp4", r"\\?\C:\x.mp4"])
def test_other_drives_are_not_even_looked_at(allowed: AllowedFolders, typed: str) -> None:
    with pytest.raises(PhotoError, match="may not be read"):
        allowed.find(typed)
