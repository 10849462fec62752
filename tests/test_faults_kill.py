"""Servers killed at random moments; ``benchmarks/kills.py`` does so as often as one likes."""

from pathlib import Path

import pytest
from folding_schemas.actions import Rotate
from folding_server.store.run_store import RunStore
from kills import Answered, faults_in, kill_often
from postgresql import empty_database


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_what_was_answered_is_there_after_kills_at_random_moments(kind: str, tmp_path: Path) -> None:
    with empty_database(kind, tmp_path) as url:
        report = kill_often(url, kills=3, seed=1)
    assert report["faults"] == []
    assert report["answered"] > 0


def test_an_answer_that_is_not_there_would_be_noticed(tmp_path: Path) -> None:
    with RunStore.in_folder(tmp_path) as store:
        run_id = store.create().run_id
        with store.change(run_id) as change:
            change.act(Rotate(angle=1))
        one, other = ("rotate", {"angle": 1.0}), ("rotate", {"angle": 2.0})
        for calls, sent, faults in (
            ([one], None, 0),
            ([], one, 0),
            ([], None, 1),
            ([one, other], None, 1),
            ([], other, 1),
        ):
            assert len(faults_in(store, Answered(run_id, calls, sent))) == faults
