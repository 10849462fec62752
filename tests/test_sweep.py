"""The sweep of random programs: it finds nothing on a few, repeats itself, and shortens what fails."""

import json
import subprocess
import sys

import pytest
from paths import ROOT

SWEEP = ROOT / "benchmarks" / "sweep.py"


def sweep(*options: str) -> dict[str, object]:
    done = subprocess.run(
        [sys.executable, str(SWEEP), *options, "--jobs", "1"],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    found = json.loads(done.stdout)
    assert done.returncode == (1 if found["failures"] else 0)
    return found


@pytest.mark.slow
def test_a_few_random_programs_stay_valid_and_repeat_exactly():
    first, second = (sweep("--programs", "15", "--folds", "5", "--seed", "0") for _ in range(2))
    assert first["failures"] == {}
    assert first["programs"] == 15
    assert sum(first["refused"].values()) == round(first["refused_share"] * first["actions"])
    assert not any("would put the layers" in refusal for refusal in first["refused"])
    assert {k: v for k, v in first.items() if k != "seconds"} == {
        k: v for k, v in second.items() if k != "seconds"
    }


def test_what_fails_is_shortened_to_the_actions_it_takes(monkeypatch):
    monkeypatch.syspath_prepend(str(SWEEP.parent))
    import sweep as module

    def without_third_fold(paper, action):
        if action.action == "fold" and paper.folds == 2:
            raise RuntimeError("no more folds")
        return apply(paper, action)

    apply = module.apply
    monkeypatch.setattr(module, "apply", without_third_fold)
    run = next(run for run in (module.run_program(0, 8, k) for k in range(20)) if run.failure)
    assert run.failure[0].startswith("RuntimeError")
    shortened = module.shortest(run)
    assert sum(action.action == "fold" for action in shortened) == 3
    assert len(shortened) < len(run.actions)
