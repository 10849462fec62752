"""``foldingagent-server install``: entries that hosts can use, in files that keep everything else."""

import json
import re
import shlex
import stat
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from folding_server.cli import main
from folding_server.install.entry import server_command
from folding_server.install.hosts import HOSTS, HostId, Machine
from folding_server.install.settings_text import SettingsRefused, read_json, snippet, with_entry
from hypothesis import given
from hypothesis import strategies as st
from mcp import Client, StdioServerParameters
from paths import ROOT

FILES = {
    "claude-desktop": ".config/Claude/claude_desktop_config.json",
    "vscode": ".config/Code/User/mcp.json",
    "cursor": ".cursor/mcp.json",
    "gemini-cli": ".gemini/settings.json",
    "codex": ".codex/config.toml",
}
SECTIONS = {"vscode": "servers", "codex": "mcp_servers"}
COMMAND = ["/opt/folding/bin/foldingagent-server", "--sequences", "/data/my photos"]
DESKTOP, CODEX, VSCODE = HOSTS[HostId.CLAUDE_DESKTOP], HOSTS[HostId.CODEX], HOSTS[HostId.VSCODE]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's empty home folder on Linux."""
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("XDG_CONFIG_HOME", "CODEX_HOME"):
        monkeypatch.delenv(name, raising=False)
    return tmp_path


def install(*words: str | Path) -> int:
    """The exit code of the command."""
    with pytest.raises(SystemExit) as end:
        main(["install", *map(str, words)])
    return int(end.value.code or 0)


def document(file: Path) -> dict[str, Any]:
    """What a configuration file says."""
    read: dict[str, Any] = (
        tomllib.loads(file.read_text()) if file.suffix == ".toml" else json.loads(file.read_text())
    )
    return read


def backups(file: Path) -> list[Path]:
    """The copies beside a file."""
    return sorted(file.parent.glob("*.bak*"))


@pytest.mark.parametrize("host", FILES)
def test_a_host_without_a_file_gets_one_with_absolute_paths(host: str, home: Path) -> None:
    (home / "photos").mkdir()
    assert install("--host", host, "--sequences", home / "photos" / ".." / "photos", "--data", "~/runs") == 0
    entry = document(home / FILES[host])[SECTIONS.get(host, "mcpServers")]["folding"]
    assert Path(entry["command"]).is_absolute()
    assert entry["args"][-4:] == ["--sequences", str(home / "photos"), "--data", str(home / "runs")]
    assert backups(home / FILES[host]) == []


@pytest.mark.parametrize("host", FILES)
def test_folders_of_films_are_entered_with_absolute_paths(
    host: str, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (home / "films" / "new").mkdir(parents=True)
    monkeypatch.chdir(home / "films")
    assert install("--host", host, "--allow", "new", "--allow", "~/films") == 0
    entry = document(home / FILES[host])[SECTIONS.get(host, "mcpServers")]["folding"]
    assert entry["args"][-4:] == ["--allow", str(home / "films" / "new"), "--allow", str(home / "films")]
    assert install("--host", host, "--allow", "nothing") != 0


@pytest.mark.parametrize("host", FILES)
def test_installing_twice_is_installing_once(
    host: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install("--host", host)
    first = (home / FILES[host]).read_bytes()
    assert install("--host", host) == 0
    assert (home / FILES[host]).read_bytes() == first
    assert backups(home / FILES[host]) == []
    assert "already" in capsys.readouterr().out


@pytest.mark.parametrize("host", FILES)
def test_a_dry_run_prints_what_can_be_pasted_and_writes_nothing(
    host: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert install("--host", host, "--dry-run") == 0
    printed = capsys.readouterr()
    assert list(home.iterdir()) == []
    assert str(home / FILES[host]) in printed.err
    install("--host", host)
    assert (home / FILES[host]).read_text() == printed.out


@pytest.mark.anyio
async def test_the_entry_starts_a_server_that_answers(home: Path) -> None:
    install("--host", "claude-desktop", "--data", home / "runs")
    entry = document(home / FILES["claude-desktop"])["mcpServers"]["folding"]
    async with Client(
        StdioServerParameters(command=entry["command"], args=entry["args"], cwd=home)
    ) as client:
        assert "fold" in {tool.name for tool in (await client.list_tools()).tools}


def test_claude_code_is_told_by_its_own_command(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (home / "my photos").mkdir()
    assert install("--host", "claude-code", "--sequences", home / "my photos") == 0
    printed = capsys.readouterr().out
    assert printed.startswith("claude mcp add --scope user folding -- /")
    assert f"--sequences '{home}/my photos'" in printed
    assert [file.name for file in home.iterdir()] == ["my photos"]


def test_a_project_file_of_claude_code_is_written_where_one_is_named(home: Path) -> None:
    assert install("--host", "claude-code", "--file", home / ".mcp.json") == 0
    assert document(home / ".mcp.json")["mcpServers"]["folding"]["type"] == "stdio"


def test_what_else_a_file_says_stays_and_a_copy_of_it_is_kept(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = home / FILES["claude-desktop"]
    file.parent.mkdir(parents=True)
    before = '{\n\t"theme": "dunkelgrün",\n\t"mcpServers": {\n\t\t"other": {"command": "x"}\n\t}\n}\n'
    file.write_text(before)
    file.chmod(0o640)
    assert install("--host", "claude-desktop") == 0
    after = document(file)
    assert list(after) == ["theme", "mcpServers"]
    assert list(after["mcpServers"]) == ["other", "folding"]
    assert after["mcpServers"]["other"] == {"command": "x"}
    assert file.read_text().startswith('{\n\t"theme": "dunkelgrün",')
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    (backup,) = backups(file)
    assert backup.read_text() == before
    assert str(backup) in capsys.readouterr().out


def test_every_change_keeps_a_copy_of_its_own(home: Path) -> None:
    file = home / FILES["cursor"]
    for folder in ("one", "two", "three"):
        (home / folder).mkdir()
        install("--host", "cursor", "--sequences", home / folder)
    assert [backup.name for backup in backups(file)] == ["mcp.json.bak", "mcp.json.bak2"]
    assert document(backups(file)[0])["mcpServers"]["folding"]["args"][-1] == str(home / "one")
    assert document(file)["mcpServers"]["folding"]["args"][-1] == str(home / "three")


def test_a_link_stays_a_link(home: Path) -> None:
    (home / "dotfiles").mkdir()
    kept = home / "dotfiles" / "cursor.json"
    kept.write_text("{}")
    (home / ".cursor").mkdir()
    (home / ".cursor" / "mcp.json").symlink_to(kept)
    assert install("--host", "cursor") == 0
    assert (home / ".cursor" / "mcp.json").is_symlink()
    assert "folding" in document(kept)["mcpServers"]


@pytest.mark.parametrize(
    ("host", "text", "why"),
    [
        ("vscode", '{\n  // my servers\n  "servers": {},\n}\n', "not plain JSON"),
        ("gemini-cli", '{"mcpServers": {}, "mcpServers": {"a": {}}}', "'mcpServers' comes twice"),
        ("claude-desktop", "[1, 2]", "does not hold a JSON object"),
        ("claude-desktop", '{"mcpServers": ["other"]}', "'mcpServers' is not the list of servers"),
        ("cursor", '{"mcpServers": {"folding": "x"}}', "'mcpServers' is not the list of servers"),
        ("cursor", '{"limit": NaN}', "NaN is no JSON"),
        ("codex", "model = \n", "not TOML"),
        ("codex", "mcp_servers = 3\n", "'mcp_servers' is not the list of servers"),
    ],
)
def test_a_file_that_would_be_broken_is_left_and_the_entry_printed(
    host: str, text: str, why: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = home / FILES[host]
    file.parent.mkdir(parents=True)
    file.write_text(text)
    assert install("--host", host) == 1
    printed = capsys.readouterr()
    assert file.read_text() == text
    assert [other.name for other in file.parent.iterdir()] == [file.name]
    assert printed.err.count("\n") == 1
    assert why in printed.err
    assert str(file) in printed.err
    assert "folding" in printed.out


def test_a_file_in_another_encoding_is_left_alone(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = home / FILES["cursor"]
    file.parent.mkdir()
    file.write_bytes('{"a": "é"}'.encode("utf-16"))
    assert install("--host", "cursor") == 1
    assert "is not UTF-8" in capsys.readouterr().err


def test_a_place_that_cannot_be_written_is_one_sentence(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (home / ".cursor").write_text("a file where the folder should be")
    assert install("--host", "cursor") == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert str(home / ".cursor" / "mcp.json") in said


def test_a_folder_that_is_not_there_is_refused_before_anything_is_written(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert install("--host", "cursor", "--sequences", home / "gone") != 0
    assert f"there is no folder {home / 'gone'}" in capsys.readouterr().err
    assert list(home.iterdir()) == []


CODEX_TEXTS = [
    "",
    '# mine\nmodel = "o9" # the big one\n\n[mcp_servers.other]\ncommand = "x"\n\n[history]\npersistence = "none"\n',
    '[mcp_servers]\nother = { command = "x" }\n',
    'mcp_servers = { other = { command = "x" } }\n',
    'mcp_servers.other.command = "x"\nmodel = "o9"\n',
    '[mcp_servers.a]\ncommand = "x"\n[tui]\ntheme = "dark"\n[mcp_servers.b]\ncommand = "y"\n',
    'model = "o9"\r\n[mcp_servers.a]\r\ncommand = "x"\r\n',
    '[mcp_servers.folding]\nurl = "http://127.0.0.1:8000/mcp"\nstartup_timeout_sec = 5\nenv = { A = "1" } # keep\n',
    '[mcp_servers.folding]\ncommand = "old"\n[mcp_servers.folding.env]\nA = "1"\n[tui]\ntheme = "dark"\n',
]


@pytest.mark.parametrize("text", CODEX_TEXTS)
def test_toml_keeps_its_comments_and_everything_else(text: str) -> None:
    after = with_entry(text, CODEX, COMMAND)
    wanted, found = tomllib.loads(text), tomllib.loads(after)
    entry = found["mcp_servers"].pop("folding")
    old = wanted.setdefault("mcp_servers", {}).pop("folding", {})
    assert found == wanted
    assert (entry["command"], entry["args"]) == (COMMAND[0], COMMAND[1:])
    assert "url" not in entry
    assert entry["startup_timeout_sec"] == old.get("startup_timeout_sec", 60)
    assert entry.get("env") == old.get("env")
    for comment in ("# mine", "# the big one", "# keep"):
        assert (comment in after) == (comment in text)
    assert with_entry(after, CODEX, COMMAND) == after


def test_what_a_user_added_to_the_entry_stays_and_an_address_goes() -> None:
    text = json.dumps({"servers": {"folding": {"type": "http", "url": "http://h/mcp", "env": {"A": "1"}}}})
    entry = json.loads(with_entry(text, VSCODE, COMMAND))["servers"]["folding"]
    assert entry == {"type": "stdio", "command": COMMAND[0], "args": COMMAND[1:], "env": {"A": "1"}}


def test_line_ends_of_windows_stay() -> None:
    after = with_entry('{\r\n    "a": 1\r\n}\r\n', DESKTOP, COMMAND)
    assert after.count("\n") == after.count("\r\n")
    assert '\r\n    "mcpServers"' in after


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@given(
    others=st.dictionaries(st.text().filter(lambda key: key != "mcpServers"), VALUES, max_size=4),
    servers=st.dictionaries(st.text().filter(lambda key: key != "folding"), VALUES, max_size=3),
    indent=st.sampled_from([None, 1, 2, 4, "\t"]),
    plain=st.booleans(),
)
def test_any_json_keeps_all_it_says(
    others: dict, servers: dict, indent: int | str | None, plain: bool
) -> None:
    text = json.dumps({**others, "mcpServers": servers}, indent=indent, ensure_ascii=plain)
    after = with_entry(text, DESKTOP, COMMAND)
    found = read_json(after)
    assert found["mcpServers"].pop("folding") == {"command": COMMAND[0], "args": COMMAND[1:]}
    assert found == {**others, "mcpServers": servers}
    assert with_entry(after, DESKTOP, COMMAND) == after


@given(st.text(max_size=40))
def test_any_text_is_read_or_refused(text: str) -> None:
    for host in (DESKTOP, CODEX):
        try:
            after = with_entry(text, host, COMMAND)
        except SettingsRefused:
            continue
        assert "folding" in after


def test_half_a_character_survives() -> None:
    after = with_entry('{"a": "\\ud83d"}', DESKTOP, COMMAND)
    assert json.loads(after.encode())["a"] == "\ud83d"


@pytest.mark.parametrize(
    ("system", "environment", "desktop", "vscode"),
    [
        ("darwin", {}, "/u/Library/Application Support/Claude", "/u/Library/Application Support/Code/User"),
        (
            "darwin",
            {"XDG_CONFIG_HOME": "/x"},
            "/u/Library/Application Support/Claude",
            "/u/Library/Application Support/Code/User",
        ),
        (
            "win32",
            {"APPDATA": "/u/AppData/Roaming"},
            "/u/AppData/Roaming/Claude",
            "/u/AppData/Roaming/Code/User",
        ),
        ("win32", {}, "/u/AppData/Roaming/Claude", "/u/AppData/Roaming/Code/User"),
        ("linux", {"XDG_CONFIG_HOME": "/x"}, "/x/Claude", "/x/Code/User"),
    ],
)
def test_files_are_where_each_system_keeps_them(
    system: str, environment: dict[str, str], desktop: str, vscode: str
) -> None:
    machine = Machine(system, Path("/u"), environment)
    assert DESKTOP.file
    assert DESKTOP.file(machine) == Path(desktop) / "claude_desktop_config.json"
    assert VSCODE.file
    assert VSCODE.file(machine) == Path(vscode) / "mcp.json"


def test_codex_may_live_elsewhere() -> None:
    assert CODEX.file
    assert CODEX.file(Machine("linux", Path("/u"), {"CODEX_HOME": "/c"})) == Path("/c/config.toml")


def test_without_its_script_the_server_is_started_by_its_interpreter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("folding_server.install.entry.SCRIPT", "no-such-script")
    assert server_command() == [sys.executable, "-m", "folding_server"]


def test_the_page_about_hosts_gives_the_very_entry_of_each() -> None:
    """With paths of nobody's checkout, which the reader replaces."""
    checkout = "/path/to/foldingagent-mcp"
    command = [f"{checkout}/.venv/bin/foldingagent-server", "--sequences", f"{checkout}/examples"]
    text = (ROOT / "docs" / "hosts.md").read_text(encoding="utf-8")
    for known in HOSTS.values():
        part = text[text.index(f"**{known.title}**") :]
        assert re.findall(r"```(?:json|toml)\n(.*?)```", part, re.DOTALL)[0] == snippet(known, command)
    assert f"claude mcp add --scope user folding -- {shlex.join(command)}\n" in text
