"""The site of many runs: how large its overview is, how long building and showing it takes.

``python benchmarks/report_site.py [--runs 200] [--events 140] [--frames 13]`` writes that many synthetic run folders, each with
photos and overlays of its own, builds the site twice without a folding server, has headless Chromium show the overview from
files, and prints JSON. A folding server's part, drawing states, is not measured: it depends on the paper. The photos of the paper's
data set are 12.5 a sequence on average (337 of 27).
"""

import argparse
import asyncio
import hashlib
import io
import json
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from folding_client.report.server_pictures import PicturedRun
from folding_client.report.site import ReportOptions, SiteBuilder
from folding_client.report.site_files import MEDIA, SiteFiles
from PIL import Image, ImageDraw

SHOWN_TIMES = 5
"""How often the overview is shown; the first is told apart, the others are a median."""
STATES = ("complete", "complete", "complete", "stopped")
FIRST_VIEW = """() => new Promise((done) => {
  const inWindow = ({ top, left }) => top < innerHeight && left < innerWidth;
  const wait = () => {
    const near = [...document.querySelectorAll("#list img")].filter((each) => inWindow(each.getBoundingClientRect()));
    if (near.length && near.every((each) => each.complete && each.naturalWidth)) done(performance.now());
    else requestAnimationFrame(wait);
  };
  wait();
})"""
"""Milliseconds from the beginning of the navigation until every picture in the window is there."""


def picture(text: str, side: int) -> bytes:
    """A JPEG that no other run has."""
    drawn = Image.new("RGB", (side, side), f"hsl({sum(text.encode()) % 360}, 30%, 40%)")
    ImageDraw.Draw(drawn).polygon(
        [(side * 0.2, side * 0.3), (side * 0.8, side * 0.4), (side * 0.5, side * 0.8)], fill="white"
    )
    ImageDraw.Draw(drawn).text((4, 4), text, fill="white")
    file = io.BytesIO()
    drawn.save(file, "JPEG", quality=80)
    return file.getvalue()


def drawing(text: str) -> bytes:
    """An SVG that no other run has."""
    shape = '<polygon points="10,20 90,30 50,80" fill="#c44" stroke="#222"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><title>{text}</title>{shape}</svg>'.encode()


def events(count: int, frames: int, overlays: list[str]) -> Iterator[dict[str, Any]]:
    """So many events: in turn queries, calls and results, with steps spread among them; and a save for each frame besides."""
    every = max(count // frames, 4)
    frame = 0
    usage = {
        "input_tokens": 9000,
        "output_tokens": 700,
        "cached_tokens": 0,
        "thinking_tokens": 300,
        "cost": 0.03,
    }
    for number in range(count):
        place = number % every
        if place == 0 and frame < frames:
            frame += 1
            yield {"kind": "step_started", "frame": frame, "saved": list(range(1, frame))}
        elif place == every - 2:
            yield {
                "kind": "call",
                "by": "agent",
                "id": None,
                "name": "compare_to_frame",
                "arguments": {"frame": frame},
            }
        elif place == every - 1:
            answer = {"frame": frame, "verdict": "MATCH", "agreement": 0.98}
            seen = [{"file": overlays[frame - 1], "subject": f"overlay on the photo of frame {frame}"}]
            yield {
                "kind": "result",
                "by": "agent",
                "name": "compare_to_frame",
                "seconds": 0.2,
                "is_error": False,
                "text": "",
                "structured": answer,
                "images": seen,
            }
            for kind, told in (("call", {"id": None, "arguments": {}}), ("result", saved(frame))):
                yield {"kind": kind, "by": "agent", "name": "save_checkpoint", **told}
        elif place % 4 == 1:
            new = [{"role": "user", "text": f"Frame {frame}: what was done? " * 20}]
            yield {"kind": "request", "role": "agent", "messages": 3, "new_from": 2, "new": new}
        elif place % 4 == 2:
            said = {"text": "The flap goes to the right edge. " * 12, "thinking": "First the symmetry. " * 40}
            call = {"id": str(number), "name": "rotate", "arguments": '{"angle": 45}'}
            yield {
                "kind": "reply",
                "role": "agent",
                "seconds": 4.2,
                **said,
                "calls": [call],
                "finish_reason": "stop",
                "usage": usage,
                "native": None,
            }
        else:
            yield {"kind": "call", "by": "agent", "id": None, "name": "get_current_state", "arguments": {}}


def saved(frame: int) -> dict[str, Any]:
    """The answer to the save of a frame."""
    answer = {"frame": frame}
    return {"seconds": 0.01, "is_error": False, "text": "", "structured": answer, "images": []}


def write_run(folder: Path, name: str, count: int, frames: int, status: str) -> None:
    """A run folder with its record, and its sequence's folder beside."""
    (folder / "images").mkdir(parents=True)
    overlays = []
    for frame in range(1, frames + 1):
        data = picture(f"{name} overlay {frame}", 256)
        overlays.append(f"images/{hashlib.sha256(data).hexdigest()[:20]}.jpg")
        (folder / overlays[-1]).write_bytes(data)
    lines = [
        {"seq": number, "time": "2026-01-01T00:00:00.000+00:00", "elapsed": number * 1.5, **event}
        for number, event in enumerate(events(count, frames, overlays), start=1)
    ]
    (folder / "events.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    (folder / "run.json").write_text(json.dumps(about(folder, name, count, frames, status)))
    (folder / "program.json").write_text(json.dumps({"name": name, "steps": []}))


def about(folder: Path, name: str, count: int, frames: int, status: str) -> dict[str, Any]:
    """What ``run.json`` says."""
    total = {
        "queries": count // 4,
        "input_tokens": 300_000,
        "output_tokens": 20_000,
        "cached_tokens": 0,
        "thinking_tokens": 9_000,
        "cost": 1.0,
        "seconds": 150.0,
    }
    outcome = {
        "status": status,
        "reason": "" if status == "complete" else "the limit of queries is reached",
        "frames_saved": frames,
        "frames": frames,
        "seconds": count * 1.5,
        "updated": "2026-01-01T00:00:00Z",
    }
    fit = {"verdict": "MATCH", "agreement": 0.98, "by": "comparison"}
    return {
        "format": 1,
        "created": "2026-01-01T00:00:00+00:00",
        "sequence": {
            "name": name,
            "folder": str(folder.parent.parent / "sequences" / name),
            "frames": frames,
        },
        "models": {"agent": "litellm/provider/model"},
        "settings": {"given": {}, "defaulted": {}},
        "versions": {},
        "outcome": outcome,
        "decided": {str(frame): "litellm/provider/model" for frame in range(1, frames + 1)},
        "fits": {str(frame): fit for frame in range(2, frames + 1)},
        "tally": {},
        "totals": {"agent": total},
    }


def write_sequence(folder: Path, name: str) -> None:
    """A sequence's manifest; the photos themselves are in the site already."""
    folder.mkdir(parents=True)
    (folder / "keyframes.json").write_text(json.dumps({"name": name}))


def write_pictures(files: SiteFiles, run: PicturedRun) -> None:
    """The photos, thumbnails and drawings that a folding server would have made, in the sizes that it makes."""
    for frame in range(1, run.frames + 1):
        files.keep_picture(run.photo_key(frame), picture(f"{run.sequence} {frame}", 512), "image/jpeg")
        files.keep_picture(run.thumbnail_key(frame), picture(f"{run.sequence} {frame}", 160), "image/jpeg")
        for kind in ("diagram", "pattern"):
            files.keep_picture(
                run.state_key(kind, frame), drawing(f"{run.sequence} {kind} {frame}"), "image/svg+xml"
            )


def shown(overview: Path) -> list[float]:
    """Seconds until all that the window holds is there, each time in a fresh browser context."""
    from playwright.sync_api import sync_playwright

    found = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            args=["--no-sandbox", "--disable-gpu"], executable_path=chromium()
        )
        for _ in range(SHOWN_TIMES):
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(overview.as_uri(), wait_until="commit")
            found.append(page.evaluate(FIRST_VIEW) / 1000)
            page.close()
        browser.close()
    return found


def chromium() -> str | None:
    """The Chromium of the system, None for playwright's own."""
    import shutil

    return shutil.which("chromium") or shutil.which("chromium-browser")


def measure(place: Path, runs: int, count: int, frames: int) -> dict[str, Any]:
    """Write, build, show."""
    for number in range(runs):
        name = f"sequence {number:03d}"
        write_run(place / "runs" / name, name, count, frames, STATES[number % len(STATES)])
        write_sequence(place / "sequences" / name, name)
    builder = SiteBuilder([place / "runs"], place / "site", ReportOptions(server=False), lambda _: None)
    for number in range(runs):
        name = f"sequence {number:03d}"
        write_pictures(builder.files, PicturedRun(place / "sequences" / name, name, frames, ((),) * frames))
    started = time.perf_counter()
    asyncio.run(builder.build())
    built = time.perf_counter() - started
    started = time.perf_counter()
    changed = asyncio.run(builder.build())
    again = time.perf_counter() - started
    overview = place / "site" / "index.html"
    first, *others = shown(overview)
    pages = [page.stat().st_size for page in (place / "site" / "runs").iterdir()]
    thumbnails = [file.stat().st_size for file in (place / "site" / MEDIA).iterdir()]
    return {
        "runs": runs,
        "events_a_run": count,
        "frames_a_run": frames,
        "overview_bytes": overview.stat().st_size,
        "overview_shown_seconds_first": round(first, 3),
        "overview_shown_seconds_median": round(statistics.median(others), 3),
        "run_page_bytes_median": statistics.median(pages),
        "picture_files": len(thumbnails),
        "build_seconds": round(built, 2),
        "build_again_unchanged_seconds": round(again, 2),
        "pages_changed_then": len(changed),
    }


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--events", type=int, default=140)
    parser.add_argument("--frames", type=int, default=13)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        print(json.dumps(measure(Path(place), given.runs, given.events, given.frames), indent=1))


if __name__ == "__main__":
    main()
