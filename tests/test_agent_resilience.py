"""What goes wrong with providers, replies, calls and the server, and how the run bears it."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from client_runs import (
    MATCH,
    PLANTED_KEY,
    act,
    ask,
    events,
    program,
    restore,
    resume,
    run,
    save,
    sequence,
)
from folding_client.interrupts import UsageError
from folding_client.models.retries import RetryPolicy
from folding_client.record.replay import replay_run
from providers.base import Fails, Hangs, Resets, Says, Truncates, Turn
from providers.openai import OpenAI

MODEL = "litellm/openai/gpt-4o"
ONLY_LOCAL = """
import socket, sys
def seen(where):
    print("CONNECTS", where, file=sys.stderr, flush=True)
def watch(event, arguments):
    if event == "socket.connect" and arguments[0].family in (socket.AF_INET, socket.AF_INET6):
        seen(arguments[1][0])
    elif event == "socket.getaddrinfo":
        seen(arguments[0])
sys.addaudithook(watch)
from folding_client.cli import main
main()
"""
TURN = {"action": "rotate", "angle": 45.0}
LOOK = Says(calls=[("get_current_state", {})])


@pytest.mark.slow
@pytest.mark.parametrize(
    "trouble",
    [Fails(429, headers={"retry-after": "0.3"}), Fails(500), Fails(503), Resets(), Truncates(), Hangs(2.0)],
    ids=["rate limit", "error 500", "error 503", "reset", "truncated", "silence"],
)
def test_passing_trouble_is_waited_out(tmp_path: Path, trouble: Turn) -> None:
    with OpenAI(save(1), trouble, act(TURN), trouble, save(2)) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, timeout=0.5)
    assert outcome.status == "complete"
    waits = [event["wait"] for event in events(tmp_path / "run", "retry")]
    assert len(waits) == 2
    if isinstance(trouble, Fails) and trouble.headers:
        assert min(waits) >= 0.3
    assert outcome.run["totals"]["agent"]["queries"] == 3


def test_lasting_trouble_is_a_clean_stop_and_the_run_resumes(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), Fails(503), Resets(), Fails(500)) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert stopped.status == "stopped"
    assert "resume" in stopped.reason
    assert stopped.run["outcome"]["frames_saved"] == 1
    with OpenAI(act(TURN), save(2)) as provider:
        resumed = resume(tmp_path / "run", api_base=provider.url)
    assert resumed.status == "complete"
    assert program(tmp_path / "run") == [[TURN]]
    assert resumed.run["totals"]["agent"]["queries"] == 4


def test_a_provider_that_asks_for_an_hour_is_not_waited_for(tmp_path: Path) -> None:
    with OpenAI(Fails(429, headers={"retry-after": "3600"})) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert stopped.status == "stopped"
    assert "3600 s" in stopped.reason


@pytest.mark.parametrize(("status", "words"), [(401, "refuses the key"), (404, "does not know the model")])
def test_a_refused_key_or_model_stops_at_once_with_one_sentence(
    tmp_path: Path, status: int, words: str
) -> None:
    with OpenAI(Fails(status)) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert stopped.status == "stopped"
    assert words in stopped.reason
    assert "\n" not in stopped.reason
    assert events(tmp_path / "run", "retry") == []


def test_a_model_that_litellm_cannot_place_is_refused_and_leaves_no_folder(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no provider"):
        run(2, tmp_path / "run", model="litellm/no-such-model")
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (Says(calls=[("rotate", '{"angle": 45')]), "not JSON"),
        (Says(calls=[("rotate", "[45]")]), "send one JSON object"),
        (Says(calls=[("rotate", {"angle": "a lot"})]), "angle"),
        (Says(calls=[("rotate", {"degrees": 45})]), "its arguments are: angle"),
        (Says(calls=[("rotate", {})]), "'angle' is a required property"),
        (Says(calls=[("rotat", {"angle": 45})]), "Did you mean rotate?"),
        (Says(calls=[("open_run", {})]), "no tool 'open_run'"),
        (Says(calls=[("fold", {"edge": [1, 99], "direction": 1})]), "99"),
    ],
    ids=[
        "cut off JSON",
        "not an object",
        "wrong type",
        "unknown argument",
        "missing argument",
        "misspelt tool",
        "tool of the controller",
        "unknown vertex",
    ],
)
def test_a_bad_call_gets_a_usable_error_and_the_run_goes_on(tmp_path: Path, bad: Says, words: str) -> None:
    with OpenAI(save(1), bad, act(TURN), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    answer = provider.received[2]["messages"][-1]["content"]
    assert answer.startswith("Error: ")
    assert words in answer
    assert program(tmp_path / "run") == [[TURN]]


def test_after_a_failed_call_the_reply_s_other_changes_are_not_made(tmp_path: Path) -> None:
    both = Says(
        calls=[
            ("fold", {"edge": [1, 99], "direction": 1}),
            ("rotate", {"angle": 90}),
            ("get_current_state", {}),
        ]
    )
    with OpenAI(save(1), both, act(TURN), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    failed, skipped, looked = provider.received[2]["messages"][-3:]
    assert "99" in failed["content"]
    assert "Not carried out, because fold" in skipped["content"]
    assert '"vertices"' in looked["content"]
    assert program(tmp_path / "run") == [[TURN]]


@pytest.mark.parametrize(
    "cut",
    [
        Says(finish="length"),
        Says("I think", finish="length"),
        Says(calls=[("rotate", '{"ang')], finish="length"),
    ],
    ids=["nothing", "words", "half a call"],
)
def test_a_reply_that_is_cut_off_rolls_the_step_back(tmp_path: Path, cut: Says) -> None:
    with OpenAI(save(1), act({"action": "rotate", "angle": 10.0}), cut, act(TURN), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    (rolled,) = events(tmp_path / "run", "rolled_back")
    assert rolled["cause"] == "ReplyCutOff"
    assert program(tmp_path / "run") == [[TURN]]
    assert len(provider.received[3]["messages"]) == 2, "the context is fresh"


def test_three_empty_replies_roll_back_three_times(tmp_path: Path) -> None:
    with OpenAI(save(1), Says(), Says(), Says(), act(TURN), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert [event["cause"] for event in events(tmp_path / "run", "rolled_back")] == ["ReplyEmpty"] * 3


def test_a_reply_that_cannot_be_read_rolls_the_step_back_and_is_counted_with_its_tokens(
    tmp_path: Path,
) -> None:
    with OpenAI(
        save(1), act({"action": "rotate", "angle": 10.0}), Says(silent=True), act(TURN), save(2)
    ) as provider:
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert outcome.status == "complete"
    (rolled,) = events(tmp_path / "run", "rolled_back")
    assert rolled["cause"] == "ReplyUnreadable"
    assert program(tmp_path / "run") == [[TURN]]
    assert outcome.run["totals"]["agent"]["queries"] == 5
    assert outcome.run["totals"]["agent"]["input_tokens"] == 5000
    assert outcome.run["tally"] == {"rolled_back": 1, "unreadable": 1}


def test_replies_that_cannot_be_read_count_towards_the_limit_of_queries(tmp_path: Path) -> None:
    with OpenAI(save(1), *[Says(silent=True)] * 2) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, max_queries=3)
    assert "3 queries" in stopped.reason
    with OpenAI(act(TURN), save(2)) as provider:
        resumed = resume(tmp_path / "run", api_base=provider.url, max_queries=5)
    assert resumed.status == "complete"
    assert resumed.run["tally"] == {"rolled_back": 2, "unreadable": 2}


def test_waits_grow_and_end_at_the_longest(tmp_path: Path) -> None:
    patient = RetryPolicy(tries=6, first_wait=0.02, longest_wait=0.1)
    with OpenAI(*[Fails(503)] * 6) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, retries=patient)
    assert stopped.status == "stopped"
    waits = [event["wait"] for event in events(tmp_path / "run", "retry")]
    ceilings = [0.02, 0.04, 0.08, 0.1, 0.1]
    assert all(ceiling / 2 - 0.001 <= wait <= ceiling for wait, ceiling in zip(waits, ceilings, strict=True))


def test_a_provider_s_error_that_repeats_the_key_is_told_without_it(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    leaky = Fails(401, f"Incorrect API key provided: {PLANTED_KEY}.")
    with OpenAI(save(1), act(TURN), Fails(500, f"bad key {PLANTED_KEY}"), leaky) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert "refuses the key" in stopped.reason
    printed = capfd.readouterr()
    written = [
        file.read_bytes().decode(errors="replace") for file in (tmp_path / "run").rglob("*") if file.is_file()
    ]
    assert len(written) >= 5
    assert not any(PLANTED_KEY in text for text in (stopped.reason, printed.out, printed.err, *written))
    assert "[redacted]" in stopped.reason


@pytest.mark.slow
def test_nothing_goes_to_the_network_but_the_model_s_calls(tmp_path: Path) -> None:
    with OpenAI(save(1), act(TURN), save(2)) as provider:
        done = subprocess.run(
            [
                sys.executable,
                "-c",
                ONLY_LOCAL,
                "run",
                sequence(2),
                "--model",
                MODEL,
                "--out",
                tmp_path / "run",
                "--api-base",
                provider.url,
            ],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "OPENAI_API_KEY": PLANTED_KEY},
        )
    assert done.returncode == 0, done.stderr
    allowed = {"127.0.0.1", provider.url.split("/")[2].partition(":")[0]}
    assert {line.split()[1] for line in done.stderr.splitlines() if line.startswith("CONNECTS ")} == allowed


def test_a_step_that_fails_again_and_again_stops_the_run(tmp_path: Path) -> None:
    with OpenAI(save(1), *[Says()] * 4) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, failures_per_step=4)
    assert stopped.status == "stopped"
    assert "failed 4 times" in stopped.reason


def test_three_replies_without_a_call_rewind_the_context(tmp_path: Path) -> None:
    with OpenAI(save(1), LOOK, Says("Hm."), Says("Well."), Says("So."), act(TURN), save(2)) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    lengths = [len(body["messages"]) for body in provider.received]
    assert lengths[1:6] == [2, 4, 6, 8, 4]
    assert "without calling a tool" in provider.received[3]["messages"][-1]["content"]
    assert len(events(tmp_path / "run", "rewound")) == 1


def test_the_limit_of_300_queries_is_checked_before_a_query(tmp_path: Path) -> None:
    look = {"calls": [{"tool": "ponder"}]}
    first = {"calls": [{"tool": "save_checkpoint", "arguments": {"frame": 1}}]}
    script = tmp_path / "script.json"
    script.write_text(json.dumps([first, *[look] * 400]))
    stopped = run(2, tmp_path / "run", model=f"scripted:{script}")
    assert stopped.status == "stopped"
    assert "300 queries" in stopped.reason
    assert len(events(tmp_path / "run", "request")) == 300
    assert resume(tmp_path / "run", max_queries=310).run["totals"]["agent"]["queries"] == 310


def test_a_critic_without_a_verdict_is_not_a_match(tmp_path: Path) -> None:
    with OpenAI(
        save(1),
        act(TURN),
        ask(2, "rotate"),
        Says("Looks fine to me!"),
        Says('{"verdict": "PERFECT"}'),
        ask(2, "rotate"),
        Says("Yes."),
        MATCH,
        save(2),
    ) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert [event["verdict"] for event in events(tmp_path / "run", "verdict")] == [None, "MATCH"]
    answers = [message for message in provider.received[5]["messages"] if message["role"] == "tool"]
    assert "NO VERDICT" in answers[-1]["content"]


def test_a_selector_without_a_label_is_asked_again(tmp_path: Path) -> None:
    attempts = [
        turn
        for angle in (10, 20, 30, 40, 50)
        for turn in (act({"action": "rotate", "angle": angle}), restore(1))
    ]
    with OpenAI(save(1), *attempts, Says("The second one, B2, or B3."), Says("B2")) as provider:
        assert run(2, tmp_path / "run", model=MODEL, api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 20.0}]]
    assert "exactly one of B1, B2, B3, B4, B5" in provider.received[-1]["messages"][-1]["content"]


def test_without_a_label_or_a_photo_that_can_be_compared_the_run_stops_and_can_be_resumed(
    tmp_path: Path,
) -> None:
    attempts = [
        turn
        for angle in (10, 20, 30, 40, 50)
        for turn in (act({"action": "rotate", "angle": angle}), restore(1))
    ]
    with OpenAI(save(1), *attempts, Says(), Says("None of them.")) as provider:
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url)
    assert stopped.status == "stopped"
    assert "No attempt at frame 2 can be compared with its photo" in stopped.reason
    with OpenAI(Says("B2")) as provider:
        assert resume(tmp_path / "run", api_base=provider.url).status == "complete"
    assert program(tmp_path / "run") == [[{"action": "rotate", "angle": 20.0}]]


def server_processes(store: Path) -> list[int]:
    """The folding servers that keep their runs in a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if b"folding_server" in words and str(store).encode() in words:
                found.append(int(entry.name))
    return found


@contextmanager
def killing(store: Path, enough: Callable[[int], bool], start: threading.Event) -> Iterator[list[int]]:
    """Kill the folding servers of a store, from when ``start`` is set until as many were killed as are
    enough.
    """
    killed: list[int] = []
    over = threading.Event()

    def work() -> None:
        start.wait()
        while not over.is_set() and not enough(len(killed)):
            for process in server_processes(store):
                if process not in killed:
                    os.kill(process, signal.SIGKILL)
                    killed.append(process)
            time.sleep(0.01)

    thread = threading.Thread(target=work)
    thread.start()
    yield killed
    over.set()
    start.set()
    thread.join()


@pytest.mark.slow
def test_a_server_killed_in_mid_run_is_started_again_and_the_run_goes_on(tmp_path: Path) -> None:
    start = threading.Event()
    deadly = Says(calls=[("rotate", {"angle": 45.0})], meanwhile=lambda: (start.set(), time.sleep(0.3)))
    with (
        killing((tmp_path / "run" / "store").resolve(), lambda count: count == 1, start) as killed,
        OpenAI(save(1), deadly, save(2)) as provider,
    ):
        outcome = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, server_url=None)
    assert outcome.status == "complete"
    assert len(killed) == 1
    assert program(tmp_path / "run") == [[TURN]]
    assert len(events(tmp_path / "run", "server_restarted")) == 1
    assert asyncio.run(replay_run(tmp_path / "run")).differences == ()


@pytest.mark.slow
def test_a_server_killed_twice_in_a_row_is_a_clean_stop_and_the_run_resumes(tmp_path: Path) -> None:
    start = threading.Event()
    deadly = Says(calls=[("rotate", {"angle": 45.0})], meanwhile=lambda: (start.set(), time.sleep(0.3)))
    with (
        killing((tmp_path / "run" / "store").resolve(), lambda count: count == 2, start) as killed,
        OpenAI(save(1), deadly) as provider,
    ):
        stopped = run(2, tmp_path / "run", model=MODEL, api_base=provider.url, server_url=None)
    assert stopped.status == "stopped"
    assert len(killed) == 2
    assert "twice in a row" in stopped.reason or "does not start" in stopped.reason
    with OpenAI(act(TURN), save(2)) as provider:
        assert resume(tmp_path / "run", api_base=provider.url, server_url=None).status == "complete"
    assert program(tmp_path / "run") == [[TURN]]
