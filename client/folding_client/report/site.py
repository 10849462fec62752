"""Building the site: gathers runs, has the pictures made that are missing, writes the pages that changed."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as package_files
from pathlib import Path

from folding_schemas.actions import action_text
from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from folding_client.report import in_words
from folding_client.report.frame_reports import FrameUsage
from folding_client.report.recorded_runs import find_runs
from folding_client.report.run_pages import (
    RunPage,
    copy_downloads,
    copy_trace_pictures,
    gather_page,
    name_groups,
    place_pictures,
)
from folding_client.report.run_scores import Evaluations, evaluation_files
from folding_client.report.server_pictures import fetch_pictures
from folding_client.report.site_files import SiteFiles
from folding_client.report.trace import Trace, TraceEntry

VERSIONS_FILE = "versions.json"
"""The file that tells a page which is being watched whether it changed."""
_ASSETS = ("report.css", "report.js", "icon.svg")
_WATCHED = ("run.json", "events.jsonl", "program.json", "checkpoints.json", "patterns.json")
"""The files by which a run folder is known to have changed."""
_Stamp = tuple[tuple[str, int, int], ...]


@dataclass(frozen=True)
class ReportOptions:
    """What goes into a site. ``evaluation`` is a file of scores; without ``server``, only recorded pictures are shown;
    without ``overlays``, the server makes none. ``live`` pages look for newer versions of themselves.
    """

    evaluation: Path | None = None
    server: bool = True
    overlays: bool = True
    live: bool = False


@dataclass(frozen=True)
class GroupTotals:
    """A row of the table of groups: sums over its runs, and means of scores. ``seeds`` are those of its runs; where there are
    several, ``score_ranges`` has the least and the greatest of the means of one seed.
    """

    name: str
    runs: int
    complete: int
    frames_saved: int
    frames: int
    matching: int
    steps: int
    usage: FrameUsage
    seeds: tuple[int, ...]
    scores: dict[str, float]
    score_ranges: dict[str, tuple[float, float]]


class SiteBuilder:
    """Builds a site of runs, and builds it again when they changed. UsageError as ``find_runs`` and ``SiteFiles``."""

    def __init__(
        self, roots: Sequence[Path], out: Path, options: ReportOptions, say: Callable[[str], None]
    ) -> None:
        self._roots = [root.expanduser().resolve() for root in roots]
        self._options = options
        self._say = say
        self._stamps: dict[Path, _Stamp] = {}
        self._pages: dict[Path, RunPage] = {}
        find_runs(self._roots)
        self.files = SiteFiles(out, "report")

    async def build(self) -> list[str]:
        """Bring the site up to date; the names of the pages that are new or changed."""
        self.files.changed.clear()
        places = find_runs(self._roots)
        scored = evaluation_files(self._roots, self._options.evaluation)
        stamps = {place: _stamp_of([*scored, *_watched_files(place.folder)]) for place in places}
        changed = [place for place in places if self._stamps.get(place.folder) != stamps[place]]
        evaluations = Evaluations(scored if changed else ())
        for place in changed:
            self._stamps[place.folder] = stamps[place]
            self._pages[place.folder] = gather_page(place, evaluations)
        pages = [self._pages[place.folder] for place in places]
        name_groups(pages)
        await self._complete_pictures([self._pages[place.folder] for place in changed])
        for place in changed:
            self._write_run(self._pages[place.folder])
        self._write_overview(pages)
        self._write_assets()
        return [name for name in self.files.changed if name.endswith(".html")]

    async def _complete_pictures(self, pages: Sequence[RunPage]) -> None:
        if self._options.server:
            pictured = {page.slug: page.pictured for page in pages}
            troubles = await fetch_pictures(pictured, self.files, self._say, overlays=self._options.overlays)
            for page in pages:
                page.troubles += troubles.get(page.slug, [])
        for page in pages:
            place_pictures(page, self.files)
            copy_downloads(page, self.files)

    def _write_run(self, page: RunPage) -> None:
        trace = Trace(page.run.events)
        names = [name for step in trace.steps for entry in step.entries for name in _pictures_in(entry)]
        shown = copy_trace_pictures(names, page, self.files)
        text = page_template("run.html").render(
            page=page, steps=trace.steps, shown=shown, up="../", live=self._options.live
        )
        self.files.write(f"runs/{page.slug}.html", text)

    def _write_overview(self, pages: Sequence[RunPage]) -> None:
        groups = group_totals(pages)
        metrics = list(dict.fromkeys(name for group in groups for name in group.scores))
        text = page_template("overview.html").render(
            pages=pages,
            groups=groups,
            metrics=metrics,
            seeded=any(len(group.seeds) > 1 for group in groups),
            up="",
            live=self._options.live,
        )
        self.files.write("index.html", text)

    def _write_assets(self) -> None:
        for name in _ASSETS:
            self.files.write(f"assets/{name}", asset(name))
        if self._options.live:
            self.files.write(VERSIONS_FILE, json.dumps(self.files.versions, indent=0))


def asset(name: str) -> str:
    """The text of a packaged file that pages load."""
    return (package_files("folding_client.report") / "assets" / name).read_text(encoding="utf-8")


@cache
def page_environment() -> Environment:
    """The templates of reports; whatever is put into one is escaped."""
    environment = Environment(
        loader=PackageLoader("folding_client.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "action_text": action_text,
        "seconds": in_words.seconds_in_words,
        "dollars": in_words.dollars_in_words,
        "count": in_words.count_in_words,
        "size": in_words.bytes_in_words,
        "share": in_words.share_in_words,
        "score": in_words.score_in_words,
    }
    return environment


def page_template(name: str) -> Template:
    """A template by its file's name."""
    return page_environment().get_template(name)


def group_totals(pages: Sequence[RunPage]) -> list[GroupTotals]:
    """The groups of runs, in the order in which they first come."""
    names = dict.fromkeys(page.group for page in pages)
    return [_totals_of(name, [page for page in pages if page.group == name]) for name in names]


def _totals_of(name: str, pages: Sequence[RunPage]) -> GroupTotals:
    costs = [page.usage.cost for page in pages if page.usage.cost is not None]
    seeds = tuple(sorted({page.seed for page in pages}))
    scores = _mean_scores(pages)
    return GroupTotals(
        name,
        len(pages),
        sum(page.run.status == "complete" for page in pages),
        sum(page.frames_saved for page in pages),
        sum(len(page.frames) for page in pages),
        sum(page.fits.matching for page in pages),
        sum(max(len(page.frames) - 1, 0) for page in pages),
        FrameUsage(
            sum(page.usage.queries for page in pages),
            sum(page.usage.input_tokens for page in pages),
            sum(page.usage.output_tokens for page in pages),
            sum(costs) if costs else None,
            sum(page.usage.seconds for page in pages),
        ),
        seeds,
        scores,
        _score_ranges(pages, seeds, scores) if len(seeds) > 1 else {},
    )


def _mean_scores(pages: Sequence[RunPage]) -> dict[str, float]:
    """The means of the scores of the last frames, over the runs that were evaluated."""
    scored = [page.scores.last for page in pages if page.scores.last]
    metrics = dict.fromkeys(metric for page in pages for metric in page.scores.metrics)
    return {
        metric: sum(scores.get(metric, 0.0) for scores in scored) / len(scored)
        for metric in metrics
        if scored
    }


def _score_ranges(
    pages: Sequence[RunPage], seeds: Sequence[int], metrics: Iterable[str]
) -> dict[str, tuple[float, float]]:
    """By metric, the least and the greatest mean of one seed."""
    means = [_mean_scores([page for page in pages if page.seed == seed]) for seed in seeds]
    found = {metric: [each[metric] for each in means if metric in each] for metric in metrics}
    return {metric: (min(values), max(values)) for metric, values in found.items() if len(values) > 1}


def _pictures_in(entry: TraceEntry) -> Iterator[str]:
    yield from (picture.file for picture in entry.pictures)
    for child in entry.entries:
        yield from _pictures_in(child)


def _watched_files(folder: Path) -> Iterator[Path]:
    yield from (folder / name for name in _WATCHED)


def _stamp_of(files: Iterable[Path]) -> _Stamp:
    """What tells files from themselves before they changed."""
    found = []
    for file in files:
        try:
            told = file.stat()
        except OSError:
            continue
        found.append((file.name, told.st_size, told.st_mtime_ns))
    return tuple(found)
