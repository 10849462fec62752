"""Batches from start to end: experiments in YAML, a ceiling over all runs, and what the command says."""

import json
from pathlib import Path

import pytest
from client_runs import MATCH, PLANTED_KEY, act, ask, events, program, save, sequence, server_url
from folding_client.batch.batch_index import INDEX_FILE
from providers.openai import OpenAI
from test_client_commands import TURN as TURN_CALL
from test_client_commands import Done, command, script
from test_client_commands import save as saves

TURN = {"action": "rotate", "angle": 45.0}
MODEL = "litellm/openai/gpt-4o"
REPLY_COST = 0.003
"""Of the local provider's replies, by litellm's list."""


def experiment(folder: Path, text: str) -> Path:
    file = folder / "experiment.yaml"
    file.write_text(text)
    return file


def two(folder: Path) -> Path:
    """A list of two sequences."""
    (folder / "list.txt").write_text(f"{sequence(2)}\n{sequence(3)}\n")
    return folder / "list.txt"


def batch(*words: object) -> Done:
    return command("batch", *words, "--server-url", server_url())


def test_an_experiment_is_sequences_by_models_by_seeds_with_a_folder_for_each(tmp_path: Path) -> None:
    script(tmp_path, [saves(1)], [TURN_CALL, saves(2)])
    file = experiment(
        tmp_path,
        f"sequences: {sequence(2)}\nmodels: [random, 'scripted:{tmp_path}/script.json']\nseeds: [1, 2]\n"
        "out: results\njobs: 2\nsettings: {max-queries: 100}\n",
    )
    done = batch(file, "--models", "random", "--json")
    assert done.returncode == 0, done.stderr
    lines = json.loads(done.stdout)
    found = {(line["model"], line["seed"]): line for line in lines}
    assert set(found) == {("random", 1), ("random", 2)}
    runs = tmp_path / "results"
    assert found["random", 2]["run"] == str(runs / "random_seed-2" / sequence(2).name)
    assert json.loads((runs / "random_seed-1" / sequence(2).name / "run.json").read_text())["settings"][
        "given"
    ]["max_queries"]
    all_models = json.loads(batch(file, "--json").stdout)
    statuses = [line["status"] for line in all_models if line["model"] == "random"]
    assert statuses == ["skipped"] * 2, "a model more leaves the runs of the others where they are"
    assert {line["status"] for line in all_models if line["model"] != "random"} == {"complete"}


def test_without_its_index_a_batch_goes_by_the_run_folders(tmp_path: Path) -> None:
    model = script(tmp_path, [saves(1)], [TURN_CALL, saves(2)])
    words = (two(tmp_path), "--model", model, "--out", tmp_path / "runs", "--json")
    assert [line["status"] for line in json.loads(batch(*words).stdout)] == ["complete", "stopped"]
    (tmp_path / "runs" / INDEX_FILE).unlink()
    script(tmp_path, [saves(1)], [TURN_CALL, saves(2)], [TURN_CALL, saves(3)])
    assert [line["status"] for line in json.loads(batch(*words).stdout)] == ["skipped", "complete"]


def test_a_batch_off_a_terminal_prints_a_line_for_each_run_and_the_sums(tmp_path: Path) -> None:
    model = script(tmp_path, [saves(1)], [TURN_CALL, saves(2)])
    done = batch(two(tmp_path), "--model", model, "--out", tmp_path / "runs")
    first, second, last = done.stderr.splitlines()
    assert first.startswith(f"{sequence(2).name}: complete, 2 of 2 frames")
    assert second.startswith(f"{sequence(3).name}: stopped, 2 of 3 frames")
    assert last == "1 of 2 runs complete, 1 stopped"
    assert done.returncode == 3


def test_at_the_ceiling_of_cost_every_run_stops_and_goes_on_with_a_higher_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)
    words = [two(tmp_path), "--model", MODEL, "--out", tmp_path / "runs", "--json", "--api-base"]
    with OpenAI(save(1), act(TURN), ask(2, "rotate"), MATCH) as provider:
        stopped = batch(*words, provider.url, "--max-batch-cost", 3.5 * REPLY_COST)
    assert stopped.returncode == 3
    first, second = json.loads(stopped.stdout)
    assert (first["status"], second["status"]) == ("stopped", "waiting")
    for line in (first, second):
        assert (
            "The limit of $0.0105 for the whole batch is reached ($0.0120 spent by all its runs)"
            in line["reason"]
        )
        assert line["reason"].endswith("with a higher --max-batch-cost.")
    assert not (tmp_path / "runs" / sequence(3).name).exists()
    with OpenAI() as provider:
        again = batch(*words, provider.url, "--max-batch-cost", 3.5 * REPLY_COST)
    assert again.returncode == 3
    assert provider.received == []
    rest = [act(TURN), save(2), save(1), act(TURN), save(2), act(TURN), save(3)]
    with OpenAI(*rest) as provider:
        done = batch(*words, provider.url, "--max-batch-cost", 1.0)
    assert [line["status"] for line in json.loads(done.stdout)] == ["complete", "complete"]
    assert len(program(tmp_path / "runs" / sequence(3).name)) == 2
    assert [event["cause"] for event in events(Path(first["run"]), "stopped")] == ["LimitReached"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("models: [random]", "names no sequences"),
        (
            "sequences: list.txt\nmodel: random",
            "gives model, which is not known; it may give sequences, models",
        ),
        ("sequences: list.txt\njobs: 0", "jobs in .* cannot be 0"),
        ("sequences: list.txt\nsettings: {mdel: x}", "gives settings.mdel, which is not known"),
        ("sequences: list.txt\nsettings: {max_cost: -1}", "settings.max_cost in .* cannot be -1"),
        ("sequences: list.txt\nvariants: [vlm-x]", "variants.0 in .* cannot be 'vlm-x'"),
        ("sequences: list.txt\nmodels: [none-such]", "There is no model 'none-such'"),
        ("sequences: nowhere.txt", "Cannot read .*nowhere.txt"),
        ("sequences: empty.txt", "holds no sequence"),
        ("models: [random", "cannot be read as YAML"),
    ],
)
def test_a_mistake_in_an_experiment_is_one_sentence(tmp_path: Path, text: str, says: str) -> None:
    two(tmp_path)
    (tmp_path / "empty.txt").write_text("# nothing yet\n")
    refused = command("batch", experiment(tmp_path, text), "--out", tmp_path / "runs")
    assert refused.returncode == 2
    with pytest.raises(AssertionError, match=says):
        raise AssertionError(refused.stderr)
    assert refused.stderr.count("\n") == 1


def test_a_ceiling_that_cannot_be_kept_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED_KEY)
    model = "litellm/openai/a-model-of-our-own"
    refused = command(
        "batch", two(tmp_path), "--model", model, "--max-batch-cost", 5, "--out", tmp_path / "runs"
    )
    assert refused.returncode == 2
    assert refused.stderr == (
        "The price of openai/a-model-of-our-own is not known, so --max-batch-cost 5 cannot be kept; give its price with "
        "--prices FILE.\n"
    )


def test_a_baseline_is_an_agent_and_no_critic(tmp_path: Path) -> None:
    for words in (("--model", "random", "--variant", "vlm-s"), ("--model", MODEL, "--critic", "search")):
        refused = command("run", sequence(2), "--out", tmp_path / "run", *words)
        assert refused.returncode == 2
        assert refused.stderr.count("\n") == 1
