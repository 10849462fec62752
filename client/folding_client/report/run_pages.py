"""What the pages of a site show of a run, gathered from its record, its scores and its pictures."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from folding_client.record.fits import FitSummary, fit_summary
from folding_client.report.attempt_tree import AttemptTree
from folding_client.report.frame_reports import FrameReport, FrameUsage, frame_reports
from folding_client.report.predicted_patterns import predicted_patterns
from folding_client.report.recorded_runs import RecordedRun, RunPlace, read_run
from folding_client.report.run_scores import Evaluations, RunScores
from folding_client.report.server_pictures import FramePictures, PicturedRun, saved_steps
from folding_client.report.site_files import SiteFiles, content_key, page_name

DOWNLOADS: tuple[tuple[str, str], ...] = (
    ("program.json", "folding program"),
    ("final.fold", "folded model (FOLD)"),
    ("crease_pattern.fold", "crease pattern (FOLD)"),
    ("crease_pattern.svg", "crease pattern (SVG)"),
    ("patterns.json", "predicted crease patterns"),
    ("checkpoints.json", "saved states"),
    ("search.json", "what the geometric search tried"),
    ("run.json", "settings, versions, sums"),
    ("events.jsonl", "every event"),
)
"""The files of a run folder that a site offers, and what they are."""
MOST_IN_ROW = 12
"""Frames that the row of a run in the overview shows. With all 21 in each of 200 rows the overview had 1.15 MB, with 12 it has
0.83 MB (``benchmarks/report_site.py --frames 21``).
"""
_RESULTS = ("program.json", "final.fold", "crease_pattern.fold", "crease_pattern.svg")


@dataclass
class RunPage:
    """A run as its page and its row in the overview show it. ``troubles`` are the sentences on what is missing."""

    run: RecordedRun
    slug: str
    group: str
    tree: AttemptTree
    frames: list[FrameReport]
    scores: RunScores
    pictured: PicturedRun
    pictures: dict[int, FramePictures] = field(default_factory=dict)
    downloads: list[tuple[str, str, int]] = field(default_factory=list)
    troubles: list[str] = field(default_factory=list)

    @property
    def seed(self) -> int:
        """The seed of what was drawn."""
        return int(self.run.settings.get("seed") or 0)

    @property
    def usage(self) -> FrameUsage:
        """What the whole run took, by the sums of its record, or of its events where that cannot be read."""
        about = self.run.about
        if about is None:
            return _sum(frame.usage for frame in self.frames)
        totals = about.totals.values()
        costs = [each.cost for each in totals if each.cost is not None]
        return FrameUsage(
            sum(each.queries for each in totals),
            sum(each.input_tokens for each in totals),
            sum(each.output_tokens for each in totals),
            sum(costs) if costs else None,
            about.outcome.seconds,
            sum(frame.usage.calls for frame in self.frames),
        )

    @property
    def fits(self) -> FitSummary:
        """How the steps fit their photos."""
        about = self.run.about
        return fit_summary({k: v.model_dump() for k, v in about.fits.items()} if about else {})

    @property
    def frames_saved(self) -> int:
        """How many frames are saved."""
        return self.run.about.outcome.frames_saved if self.run.about else len(self.tree.saved)

    @property
    def in_row(self) -> list[FrameReport]:
        """The frames that the row in the overview shows: first and last, those that do not match, and others evenly."""
        if len(self.frames) <= MOST_IN_ROW:
            return self.frames
        first, *between, last = self.frames
        doubtful = _evenly([each for each in between if each.mark in {"doubt", "missing"}], MOST_IN_ROW - 2)
        others = [each for each in between if each.mark not in {"doubt", "missing"}]
        shown = [first, *doubtful, *_evenly(others, MOST_IN_ROW - 2 - len(doubtful)), last]
        return sorted(shown, key=lambda each: each.frame)

    @property
    def match_share(self) -> float:
        """The matching steps over all steps of the sequence, 0 where there are none."""
        steps = max(len(self.frames) - 1, 0)
        return self.fits.matching / steps if steps else 0.0


def _evenly(frames: Sequence[FrameReport], count: int) -> list[FrameReport]:
    """So many of the frames, evenly spread over them; all if there are fewer."""
    if len(frames) <= count:
        return list(frames)
    return [frames[(2 * number + 1) * len(frames) // (2 * count)] for number in range(count)]


def gather_page(place: RunPlace, evaluations: Evaluations) -> RunPage:
    """A run without its pictures."""
    run = read_run(place)
    tree = AttemptTree(run.events, run.run_id)
    frames = frame_reports(run, tree)
    pictured = _pictured(run, tree, frames)
    page = RunPage(
        run,
        page_name(run.sequence, place.batch, place.within),
        "",
        tree,
        frames,
        evaluations.of(place.folder, run.sequence),
        pictured,
    )
    page.troubles += [*run.problems, *_what_is_missing(page)]
    return page


def _pictured(run: RecordedRun, tree: AttemptTree, frames: Sequence[FrameReport]) -> PicturedRun:
    saved = tree.saved
    count = saved_steps(saved) if run.settings.get("variant") != "vlm-cp" else 0
    return PicturedRun(
        Path(run.about.sequence.folder) if run.about else Path(),
        run.sequence,
        len(frames),
        tuple(saved[frame].actions for frame in range(1, count + 1)),
        frozenset(frame.frame for frame in frames if frame.overlay),
    )


def _what_is_missing(page: RunPage) -> Iterable[str]:
    """Sentences on what a reader would look for in vain."""
    run, frames = page.run, page.frames
    if run.status in {"stopped", "interrupted"} and run.about and run.about.outcome.reason:
        yield f"The run ended early: {run.about.outcome.reason}"
    unreached = [frame.frame for frame in frames if frame.mark == "missing"]
    if unreached and run.status != "running":
        yield f"Frames without a solution: {_ranges(unreached)}."
    if run.about and not page.pictured.has_photos:
        yield f"The photos are not where the run had them ({run.about.sequence.folder})."
    if run.status == "complete" and run.settings.get("variant") != "vlm-cp":
        lost = [name for name in _RESULTS if not (run.place.folder / name).is_file()]
        if lost:
            yield f"Results that the folder lacks: {', '.join(lost)}."


def _ranges(numbers: Sequence[int]) -> str:
    """Numbers in order as ``2, 5 to 8``."""
    spans: list[list[int]] = []
    for number in numbers:
        if spans and spans[-1][-1] == number - 1:
            spans[-1].append(number)
        else:
            spans.append([number])
    return ", ".join(f"{s[0]} to {s[-1]}" if len(s) > 1 else f"{s[0]}" for s in spans)


def _sum(usages: Iterable[FrameUsage]) -> FrameUsage:
    total = FrameUsage()
    for each in usages:
        cost = total.cost if each.cost is None else (total.cost or 0.0) + each.cost
        total = FrameUsage(
            total.queries + each.queries,
            total.input_tokens + each.input_tokens,
            total.output_tokens + each.output_tokens,
            cost,
            total.seconds + each.seconds,
            total.calls + each.calls,
        )
    return total


def name_groups(pages: Sequence[RunPage]) -> None:
    """Give each run the name of its group: batch, model and variant, as far as they differ between the runs."""
    batches = {page.run.place.batch for page in pages}
    variants = {page.run.variant for page in pages}
    for page in pages:
        parts = [page.run.place.batch] if len(batches) > 1 else []
        parts.append(page.run.model)
        if len(variants) > 1:
            parts.append(page.run.variant)
        page.group = " · ".join(parts)


def place_pictures(page: RunPage, files: SiteFiles) -> None:
    """Say where the pictures of a run are, after the recorded ones and the predicted patterns are copied."""
    folder = page.run.place.folder
    predicted = predicted_patterns(folder) if page.run.settings.get("variant") == "vlm-cp" else {}
    for frame, found in page.pictured.found(files).items():
        report = page.frames[frame - 1] if frame <= len(page.frames) else None
        photo, overlay = found.photo, found.overlay
        if report and report.overlay:
            overlay = files.copy_picture(folder / report.overlay) or overlay
        if photo is None and report and report.photo:
            photo = files.copy_picture(folder / report.photo)
        pattern = found.pattern
        if frame in predicted:
            key = content_key("predicted", predicted[frame])
            pattern = files.picture(key) or files.keep_picture(
                key, predicted[frame].encode("utf-8"), "image/svg+xml"
            )
        page.pictures[frame] = FramePictures(photo, found.thumbnail or photo, found.diagram, pattern, overlay)


def copy_downloads(page: RunPage, files: SiteFiles) -> None:
    """Copy the files that a page offers; each with what it is and its bytes."""
    folder = page.run.place.folder
    page.downloads = [
        (name, what, (folder / name).stat().st_size)
        for name, what in DOWNLOADS
        if (folder / name).is_file() and files.copy(folder / name, f"files/{page.slug}/{name}")
    ]


def copy_trace_pictures(names: Iterable[str], page: RunPage, files: SiteFiles) -> Mapping[str, str]:
    """Copy recorded pictures; where each is within the site, without those that are missing."""
    found = {name: files.copy_picture(page.run.place.folder / name) for name in set(names)}
    return {name: place for name, place in found.items() if place}
