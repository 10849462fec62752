"""What becomes of a run whose server refuses a call that the client makes for itself."""

import asyncio
import shutil
from pathlib import Path

import pytest
from client_runs import events, program, run, sequence
from folding_client.progress import Silent
from folding_client.reconstruct import new_job, reconstruct
from folding_client.settings import Settings
from test_client_commands import TURN, save, script


@pytest.mark.slow
def test_a_call_of_the_clients_own_that_is_refused_is_a_clean_stop(tmp_path: Path) -> None:
    shutil.copytree(sequence(2), tmp_path / "plain")
    (tmp_path / "plain" / "frames" / "000001.jpg").write_bytes(b"a letter, not a picture")
    settings = Settings(model=script(tmp_path), variant="vlm-s")
    job = new_job(tmp_path / "plain", tmp_path / "run", settings)
    stopped = asyncio.run(reconstruct(job, Silent()))
    assert (stopped.status, stopped.run["outcome"]["frames_saved"]) == ("stopped", 1)
    assert "000001.jpg" in stopped.reason
    assert [event["status"] for event in events(tmp_path / "run", "ended")] == ["stopped"]
    assert program(tmp_path / "run") == []


def test_an_overview_that_the_server_refuses_does_not_end_the_run(tmp_path: Path) -> None:
    """Photos without a square can be looked at, but nothing can be compared with them."""
    overview = {"tool": "generate_checkpoint_overview", "arguments": {}}
    model = script(tmp_path, [save(1)], [overview], [TURN, save(2)])
    assert run(2, tmp_path / "run", model=model, overview="geometric").status == "complete"
    (analysis,) = events(tmp_path / "run", "overview")
    assert not analysis["readable"]
    assert "cannot be compared with their photos: " in analysis["recommendation"]
