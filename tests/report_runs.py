"""Recorded runs of all sorts for the tests of reports: made by the client from scripts, then damaged or renamed."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from client_runs import ANCHOR, MATCH, MISMATCH, run

HOSTILE_NAME = '"><img src=x onerror=document.title="owned">'
HOSTILE_WORDS = "<script>document.title='owned'</script><img src=x onerror=\"document.title='owned'\">"
PATTERN = {
    "vertices_coords": [[0, 1], [1, 1], [1, 0], [0, 0]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
    "edges_assignment": ["B", "B", "B", "B", "V"],
}
ASK = {"frame": 2, "action_classes": ["rotate"], "fold_anchor": ANCHOR}
SPENT = {"input_tokens": 1000, "output_tokens": 50, "cost": 0.25}


def says(tool: str, **arguments: Any) -> dict[str, Any]:
    """A scripted reply with one call."""
    return {"calls": [{"tool": tool, "arguments": arguments}]}


TURNS: list[dict[str, Any]] = [
    says("save_checkpoint", frame=1),
    {**says("rotate", angle=10), "text": HOSTILE_WORDS, "thinking": HOSTILE_WORDS},
    says("ask_critic", **ASK),
    {"role": "critic", "text": MISMATCH.text},
    says("restore_checkpoint", frame=1),
    says("rotate", angle=45),
    says("ask_critic", **ASK),
    {"role": "critic", "text": MATCH.text},
    says("save_checkpoint", frame=2),
    says("fold", edge=[1, 3], direction=1),
    says("save_checkpoint", frame=3),
]
"""Frame 2 at the second attempt, after a critic refused the first, with reasoning that would be markup."""


def scripted_run(folder: Path, turns: list[dict[str, Any]], frames: int, **settings: Any) -> Path:
    """A run of a plain sequence by a script. Every reply costs the same."""
    script = folder.parent / f"{folder.name}.script.json"
    script.write_text(json.dumps(turns))
    run(frames, folder, model=f"scripted:{script}", **settings)
    script.unlink()
    rewrite_events(folder, lambda event: {**event, "usage": {**event["usage"], **SPENT}}, "reply")
    told = json.loads((folder / "run.json").read_text())
    for each in told["totals"].values():
        each |= {name: value * each["queries"] for name, value in SPENT.items()}
    (folder / "run.json").write_text(json.dumps(told))
    return folder


def agent_run(folder: Path, frames: int = 3) -> Path:
    """A run of the agent with a critic; with more than three frames it stops at the fourth."""
    return scripted_run(folder, TURNS, frames)


def pattern_run(folder: Path) -> Path:
    """A run of the variant that predicts crease patterns."""
    return scripted_run(folder, [{"text": json.dumps(PATTERN)}] * 2, 3, variant="vlm-cp")


def rewrite_events(folder: Path, change: Callable[[dict[str, Any]], dict[str, Any]], kind: str) -> None:
    """Change every event of a kind on record."""
    file = folder / "events.jsonl"
    events = [json.loads(line) for line in file.read_text().splitlines()]
    changed = [change(event) if event["kind"] == kind else event for event in events]
    file.write_text("".join(json.dumps(event) + "\n" for event in changed))


def edited(folder: Path, **changes: Any) -> Path:
    """A run whose ``run.json`` says otherwise; ``name`` renames the sequence."""
    file = folder / "run.json"
    told = json.loads(file.read_text())
    if "name" in changes:
        told["sequence"]["name"] = changes.pop("name")
    file.write_text(json.dumps(told | changes))
    return folder


def damaged(source: Path, folder: Path) -> Path:
    """A copy of a run without a readable description, with a broken line and one that is missing."""
    shutil.copytree(source, folder)
    (folder / "run.json").write_text('{"format": 1, ')
    lines = (folder / "events.jsonl").read_text().splitlines(keepends=True)
    (folder / "events.jsonl").write_text("".join([*lines[:5], "no event\n", *lines[7:], '{"cut off']))
    return folder


def many_sorts(place: Path) -> Path:
    """A batch with a run that is complete, one that stopped, a predicted one, a hostile and a damaged one."""
    agent_run(place / "plain3")
    agent_run(place / "stopped", 4)
    pattern_run(place / "patterns")
    shutil.copytree(place / "plain3", place / "hostile")
    edited(place / "hostile", name=HOSTILE_NAME, models={"agent": HOSTILE_NAME})
    damaged(place / "plain3", place / "damaged")
    return place
