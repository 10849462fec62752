"""Values that an option cannot have are refused in one line that names the value and what is allowed, by both commands."""

from pathlib import Path

import pytest
from folding_client.cli import main as client_main
from folding_server.cli import main as server_main

WRONG_FOR_THE_SERVER = [
    ("--vision-workers -1", "'--vision-workers': '-1' is not possible; give a number from 0 to 64."),
    ("--vision-workers two", "'two' is not possible; give a whole number from 0 to 64."),
    ("--vision-queue 1e9", "'1e9' is not possible; give a whole number from 0 to 10000."),
    ("--attempts 0", "'0' is not possible; give a number from 1 to 20."),
    ("--attempts nan", "'nan' is not possible; give a whole number from 1 to 20."),
    ("--tools nope", "'--tools': 'nope' is not one of 'paper', 'standard', 'all'."),
    ("install --host nope", "'--host': 'nope' is not one of 'claude-desktop',"),
    ("view x --port 70000", "'70000' is not possible; give a number from 0 to 65535."),
    ("--sequences gone", "there is no folder gone to serve sequences from; create it or name another."),
    ("--data EMPTY", "the path is empty; give one, or . for the folder you are in."),
    ("--http [::1", "'[::1' is no address to serve on; give HOST:PORT such as 127.0.0.1:8000."),
    ("--http nohost.invalid:80", "Cannot serve on nohost.invalid:80 ("),
    ("--known-as a.example", "--known-as is for clients over HTTP; add --http HOST:PORT, or leave it out."),
    ("--http 127.0.0.1:0 --known-as http://x/y", "--known-as 'http://x/y' is no host name; give one without"),
    ("--http 127.0.0.1:0 --known-as EMPTY", "--known-as '' is no host name"),
    ("nope", "No such command 'nope'; --help says what there is."),
    ("photograph", "Missing argument 'PROGRAM'; --help says what there is."),
]
WRONG_FOR_THE_CLIENT = [
    ("--attempts 0", "--attempts cannot be 0: give a number from 1."),
    ("--attempts x", "'--attempts': 'x' is not possible; give a whole number."),
    ("--attempts 21", "--attempts cannot be 21: give a number of at most 20."),
    ("--max-cost nan", "--max-cost cannot be nan: give a number"),
    ("--timeout inf", "--timeout cannot be inf: give a number"),
    ("--tools nope", "--tools cannot be 'nope': give 'paper', 'standard' or 'all'."),
    (
        "--server-url nope",
        "--server-url cannot be 'nope': give an address that begins with http:// or https://.",
    ),
    ("--model hybrid:", "There is no model 'hybrid:'; the ids are geometric,"),
    ("--model scripted:", "There is no model 'scripted:'; the ids are geometric,"),
    ("--out EMPTY", "the path is empty; give one, or . for the folder you are in."),
]


def line_said(
    main: object,
    words: str,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> str:
    """What a command that fails says, which is one line on stderr."""
    monkeypatch.chdir(folder)
    arguments = ["" if word == "EMPTY" else word for word in words.split()]
    with pytest.raises(SystemExit) as ended:
        main(arguments)  # type: ignore[operator]
    said = capsys.readouterr()
    assert ended.value.code
    assert said.out == ""
    (line,) = said.err.splitlines()
    assert "Input should" not in line
    assert "Value error" not in line
    return line


@pytest.mark.parametrize(("words", "says"), WRONG_FOR_THE_SERVER)
def test_the_server_names_the_value_and_what_is_allowed(
    tmp_path: Path, words: str, says: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert says in line_said(server_main, words, tmp_path, capsys, monkeypatch)


@pytest.mark.parametrize(("words", "says"), WRONG_FOR_THE_CLIENT)
def test_the_client_names_the_value_and_what_is_allowed(
    tmp_path: Path, words: str, says: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert says in line_said(client_main, f"run gone {words}", tmp_path, capsys, monkeypatch)


def test_a_wrong_model_is_told_before_a_film_is_looked_through(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "film.mp4").write_bytes(b"no film")
    for model in ("nope", "scripted:gone.json", "litellm/nosuch/model"):
        said = line_said(client_main, f"run film.mp4 --model {model}", tmp_path, capsys, monkeypatch)
        assert "film.mp4" not in said
        assert model.partition(":")[2] in said
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]
