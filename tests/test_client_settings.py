"""Where settings come from, and what can be asked without a run: models, a first request, completion."""

import json
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest
from client_runs import PLANTED_KEY, run, sequence, served, server_url
from folding_client import exits
from folding_client.batch.batch_entry import BatchEntry
from folding_client.critic_accuracy.accuracy import CriticAccuracy
from folding_client.dry_run import DryRun
from folding_client.interrupts import UsageError
from folding_client.models.model_table import ModelRow, ModelTable
from folding_client.record.replay import Difference, Replay
from folding_client.setting_sources import settings_from
from paths import ROOT
from providers.openai import OpenAI
from test_client_commands import TURN, command, save, script

FILES = {
    "settings.toml": "max_queries = 10\nmax-time = '2m'\nmodel = 'hybrid:openai/gpt-4o'\n",
    "settings.yaml": "max_queries: 10\nmax-time: 2m\nmodel: hybrid:openai/gpt-4o\n",
    "settings.json": '{"max_queries": 10, "max_time": "2m", "model": "hybrid:openai/gpt-4o"}',
}


@pytest.mark.parametrize("name", FILES)
def test_options_win_over_variables_over_a_file_over_defaults(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(FILES[name])
    variables = {
        "FOLDINGAGENT_MAX_QUERIES": "20",
        "FOLDINGAGENT_CONFIG": str(file),
        "FOLDINGAGENT_SELECTOR": "",
    }
    settings = settings_from({}, None, {})
    assert (settings.max_queries, settings.max_time, settings.model) == (300, None, "geometric")
    settings = settings_from({}, file, {})
    assert (settings.max_queries, settings.max_time, settings.model) == (10, 120, "hybrid:openai/gpt-4o")
    settings = settings_from({}, None, variables)
    assert (settings.max_queries, settings.max_time, settings.selector) == (20, 120, None)
    settings = settings_from({"max_queries": 30}, None, variables)
    assert (settings.max_queries, settings.max_time) == (30, 120)
    assert settings.model_fields_set == {"max_queries", "max_time", "model"}


def test_variables_hold_numbers_truth_values_and_text() -> None:
    variables = {
        "FOLDINGAGENT_KEEP_IMAGES": "true",
        "FOLDINGAGENT_MAX_COST": "1.5",
        "FOLDINGAGENT_MODEL": "m",
    }
    settings = settings_from({}, None, variables)
    assert (settings.keep_images, settings.max_cost, settings.model) == (True, 1.5, "m")


@pytest.mark.parametrize(
    ("options", "text", "variables", "says"),
    [
        ({"max_queries": 0}, "", {}, "--max-queries cannot be 0: "),
        ({}, "max_queries = 0", {}, "max_queries in FILE cannot be 0: "),
        ({}, "[retries]\ntries = 0", {}, "retries.tries in FILE cannot be 0: "),
        ({}, "", {"FOLDINGAGENT_MAX_QUERIES": "0"}, "FOLDINGAGENT_MAX_QUERIES cannot be 0: "),
        ({}, "", {"FOLDINGAGENT_MAX_QUERYS": "5"}, "did you mean FOLDINGAGENT_MAX_QUERIES?"),
        ({}, "queries = 3", {}, "FILE gives 'queries', which is no setting; the settings are model, "),
        ({}, "3", {}, "FILE cannot be read as TOML"),
    ],
    ids=["option", "file", "file, inside", "variable", "misspelt variable", "unknown name", "no TOML"],
)
def test_a_value_that_cannot_be_says_where_it_stands(
    tmp_path: Path, options: dict[str, int], text: str, variables: dict[str, str], says: str
) -> None:
    file = tmp_path / "settings.toml"
    file.write_text(text)
    with pytest.raises(UsageError) as refusal:
        settings_from(options, file, variables)
    assert says.replace("FILE", str(file)) in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "says"), [("settings.ini", "its name has to end in one of .toml"), ("none.toml", "No such file")]
)
def test_a_file_of_settings_that_is_none_is_refused(tmp_path: Path, name: str, says: str) -> None:
    (tmp_path / "settings.ini").write_text("[a]\n")
    refused = command("models", "--config", tmp_path / name)
    assert refused.returncode == 2
    assert says in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1


def test_a_resumed_run_keeps_its_settings_whatever_the_variables_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = script(tmp_path, [save(1)])
    out = tmp_path / "run"
    assert (
        command("run", sequence(2), "--model", model, "--out", out, "--server-url", server_url()).returncode
        == 3
    )
    script(tmp_path, [save(1)], [TURN, save(2)])
    monkeypatch.setenv("FOLDINGAGENT_MODEL", "geometric")
    monkeypatch.setenv("FOLDINGAGENT_MAX_QUERIES", "1")
    assert command("run", "--resume", out).returncode == 0
    assert "max_queries" not in json.loads((out / "run.json").read_text())["settings"]["given"]


@pytest.mark.slow
def test_a_dry_run_shows_the_first_request_with_tokens_and_price_and_sends_nothing(tmp_path: Path) -> None:
    with OpenAI() as provider:
        words = ("run", sequence(2), "--model", "litellm/openai/gpt-4o", "--api-base", provider.url)
        done = command(*words, "--dry-run", "--json", "--out", tmp_path / "run")
        assert provider.received == []
    request = json.loads(done.stdout)
    assert [message["role"] for message in request["messages"]] == ["system", "user"]
    assert "The sequence has 2 frames" in request["messages"][1]["text"]
    assert {"fold", "ask_critic"} <= set(request["tools"])
    assert request["input_cost"] == pytest.approx(request["input_tokens"] * 2.5e-6)
    assert 1000 < request["input_tokens"] < 10_000
    assert not (tmp_path / "run").exists()


def test_a_dry_run_of_the_geometric_model_sends_no_request() -> None:
    done = command("run", sequence(2), "--dry-run")
    assert (done.returncode, done.stdout) == (0, "geometric would send no request.\n")


def test_the_models_are_told_with_keys_abilities_and_prices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)
    monkeypatch.delenv("ANTHROPIC_API_KEY", raising=False)
    words = ("models", "--model", "litellm/openai/gpt-4o", "--critic", "litellm/anthropic/claude-sonnet-4-5")
    told = json.loads(command(*words, "--json").stdout)
    agent, critic = told["models"]
    assert (agent["roles"], agent["missing_keys"], agent["images"], agent["tools"]) == (
        ["agent", "overview", "selector"],
        [],
        True,
        True,
    )
    assert (agent["input_price"], agent["output_price"]) == (2.5, 10)
    assert (critic["roles"], critic["missing_keys"]) == (["critic"], ["ANTHROPIC_API_KEY"])
    assert "OPENAI_API_KEY" in told["keys"]
    in_words = command(*words)
    assert "key: missing, set ANTHROPIC_API_KEY" in in_words.stdout
    assert PLANTED_KEY not in in_words.stdout


def test_a_model_that_is_on_no_list_is_told_as_far_as_it_is_known() -> None:
    told = command("models", "litellm/openai/a-model-of-our-own", "geometric")
    assert told.returncode == 0
    assert "images: not known; tools: not known" in told.stdout
    assert "price: not known; give it with --prices FILE" in told.stdout
    assert "geometric (agent, critic, overview, selector)\n  asks no provider" in told.stdout
    assert command("models", "gpt").returncode == 2


def test_a_server_that_offers_too_few_tools_is_named_with_what_it_lacks(tmp_path: Path) -> None:
    sequences = sequence(2).parent
    with served("--tools", "paper", sequences=sequences, data=tmp_path / "data") as url:
        refused = command("run", sequence(2), "--server-url", url, "--out", tmp_path / "run")
    assert refused.returncode == 2
    assert f"The folding server at {url} does not offer" in refused.stderr
    assert "propose_actions" in refused.stderr
    assert "--tools all" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "run").exists()


def test_shells_can_complete_commands_and_options() -> None:
    environment = {
        **os.environ,
        "_FOLDINGAGENT_COMPLETE": "complete_bash",
        "COMP_WORDS": "foldingagent repl",
        "COMP_CWORD": "1",
    }
    foldingagent = Path(sys.executable).with_name("foldingagent")
    done = subprocess.run([foldingagent], env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["replay"]


@pytest.mark.slow
@pytest.mark.parametrize("level", ["debug", "info"])
def test_log_messages_go_to_stderr_from_the_level_that_is_asked_for(tmp_path: Path, level: str) -> None:
    model = script(tmp_path, [save(1)], [TURN, save(2)])
    words = ["run", sequence(2), "--model", model, "--out", tmp_path / "run", "--server-url", server_url()]
    done = subprocess.run(
        [sys.executable, "-m", "folding_client", "--log-level", level, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert ("DEBUG folding_client.record.recorder: step_over {'frame': 2}" in done.stderr) is (
        level == "debug"
    )


def test_an_error_of_the_program_itself_is_one_sentence_and_written_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SOME_API_KEY", PLANTED_KEY)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def broken() -> None:
        raise KeyError(PLANTED_KEY)

    with pytest.raises(SystemExit) as end:
        exits.end_cleanly(broken)
    assert end.value.code == exits.EXIT_FAULT
    said = capsys.readouterr().err
    assert said.startswith("An error in foldingagent itself, KeyError: ")
    assert len(said.strip().splitlines()) == 1
    (written,) = tmp_path.iterdir()
    assert str(written) in said
    assert "Traceback" in written.read_text()
    assert PLANTED_KEY not in said + written.read_text()


def test_every_exit_code_is_documented() -> None:
    page = (ROOT / "docs" / "client.md").read_text(encoding="utf-8")
    codes = {value for name, value in vars(exits).items() if name.startswith("EXIT_")} | {0}
    listed = {
        int(line.split("|")[1])
        for line in page.splitlines()
        if line.startswith("| ") and line.split("|")[1].strip().isdigit()
    }
    assert codes == listed


@pytest.mark.parametrize(
    ("command_line", "names"),
    [
        ("run --dry-run", [field.name for field in fields(DryRun)]),
        ("batch", [field.name for field in fields(BatchEntry)]),
        ("replay", [field.name for kind in (Replay, Difference) for field in fields(kind)]),
        ("models", [field.name for kind in (ModelTable, ModelRow) for field in fields(kind)]),
        ("critic-accuracy", [field.name for field in fields(CriticAccuracy)]),
    ],
)
def test_every_member_of_the_json_output_is_documented(command_line: str, names: list[str]) -> None:
    page = (ROOT / "docs" / "client.md").read_text(encoding="utf-8")
    (row,) = [line for line in page.splitlines() if line.startswith(f"| `{command_line}` | ")]
    assert [name for name in names if f"`{name}`" not in row] == []


def test_a_name_that_is_too_long_for_a_file_is_one_sentence(tmp_path: Path) -> None:
    for words in (("run", "x" * 300), ("run", sequence(2), "--out", tmp_path / ("x" * 300))):
        refused = command(*words)
        assert refused.returncode == 2
        assert "too long" in refused.stderr.lower()
        assert len(refused.stderr.strip().splitlines()) == 1


def test_a_password_in_an_address_is_on_no_record_and_asked_for_again(tmp_path: Path) -> None:
    address = server_url().replace("://", "://me:open-sesame@")
    stopped = run(2, tmp_path / "run", model=script(tmp_path, [save(1)]), server_url=address)
    assert stopped.status == "stopped"
    written = [file.read_bytes() for file in (tmp_path / "run").rglob("*") if file.is_file()]
    assert not any(b"open-sesame" in each for each in written)
    script(tmp_path, [save(1)], [TURN, save(2)])
    refused = command("run", "--resume", tmp_path / "run")
    assert refused.returncode == 2
    assert "holds --server-url without its password; give --server-url again" in refused.stderr
    assert command("run", "--resume", tmp_path / "run", "--server-url", address).returncode == 0
