"""A run frame by frame: what was done, how well it fits the photo, and what it took."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from folding_schemas.actions import action_text
from folding_schemas.event_record import (
    RecordedEvent,
    RecordedPicture,
    ReplyEvent,
    RequestEvent,
    ResultEvent,
    StepStartedEvent,
    UnreadableEvent,
)

from folding_client.report.attempt_tree import AttemptNode, AttemptTree, ReachedFrame
from folding_client.report.recorded_runs import RecordedRun

MOST_FRAMES = 2_000
"""Frames that are shown of one run, whatever its record says: a film is allowed 500 keyframes."""
RECORDED_PICTURE = re.compile(r"images/[0-9a-f]{20}\.(?:png|jpg|webp|svg)")
"""How a record names a picture; anything else that claims to be one is not looked at."""
_PHOTO = re.compile(r"photo of frame (\d+)")


@dataclass(frozen=True)
class FrameUsage:
    """What the work towards a frame took. ``cost`` in US dollars is None while no price is known."""

    queries: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    cost: float | None = None
    seconds: float = 0.0
    calls: int = 0

    @property
    def tokens(self) -> int:
        """Tokens sent and received."""
        return self.input_tokens + self.output_tokens

    def plus(self, event: RecordedEvent, seconds: float) -> "FrameUsage":
        """With one event more, which came so many seconds after the one before."""
        usage = replace(self, seconds=self.seconds + seconds)
        if isinstance(event, ResultEvent):
            return replace(usage, calls=usage.calls + 1)
        if not isinstance(event, ReplyEvent | UnreadableEvent):
            return usage
        price = event.usage.cost
        return replace(
            usage,
            queries=usage.queries + 1,
            input_tokens=usage.input_tokens + event.usage.input_tokens,
            output_tokens=usage.output_tokens + event.usage.output_tokens,
            cost=usage.cost if price is None else (usage.cost or 0.0) + price,
        )


@dataclass(frozen=True)
class FrameReport:
    """One frame of a run. ``saved`` is None for a frame that is not reached; ``photo`` and ``overlay`` name recorded
    pictures, None where the record has none.
    """

    frame: int
    saved: ReachedFrame | None
    verdict: str | None
    agreement: float | None
    judged_by: str | None
    decided: str | None
    attempts: int
    usage: FrameUsage
    photo: str | None
    overlay: str | None

    @property
    def actions(self) -> list[str]:
        """The actions in words."""
        return [action_text(action) for action in self.saved.actions] if self.saved else []

    @property
    def mark(self) -> str:
        """``match``, ``doubt``, ``unseen`` (saved, and nobody looked), ``start`` (frame 1) or ``missing``."""
        if self.saved is None and self.decided is None:
            return "missing"
        if self.frame == 1:
            return "start"
        if self.verdict is None:
            return "unseen" if self.judged_by is None else "doubt"
        return "match" if self.verdict == "MATCH" else "doubt"


def frame_reports(run: RecordedRun, tree: AttemptTree) -> list[FrameReport]:
    """All frames of a run's sequence, those that it did not reach among them."""
    usage, attempts = usage_by_frame(run.events), _attempts_by_frame(tree.root)
    saved = tree.saved
    photos = dict(_recorded_photos(run.events))
    return [
        _frame_report(run, frame, saved.get(frame), usage, attempts, photos)
        for frame in range(1, _frame_count(run, saved) + 1)
    ]


def _frame_report(
    run: RecordedRun,
    frame: int,
    saved: ReachedFrame | None,
    usage: dict[int, FrameUsage],
    attempts: dict[int, int],
    photos: dict[int, str],
) -> FrameReport:
    fit = run.about.fits.get(str(frame)) if run.about else None
    return FrameReport(
        frame,
        saved,
        fit.verdict if fit else None,
        fit.agreement if fit else None,
        fit.by if fit else None,
        _decided(run, frame),
        attempts.get(frame, 0),
        usage.get(frame, FrameUsage()),
        photos.get(frame),
        saved.overlay if saved and RECORDED_PICTURE.fullmatch(saved.overlay or "") else None,
    )


def _decided(run: RecordedRun, frame: int) -> str | None:
    """Who decided a frame; predicted patterns begin with that of the flat sheet, which nobody decides."""
    if run.about is None:
        return None
    begun = run.variant.startswith("vlm-cp") and frame == 1 and run.about.outcome.frames_saved > 0
    return run.about.decided.get(str(frame)) or ("the start" if begun else None)


def _frame_count(run: RecordedRun, saved: dict[int, ReachedFrame]) -> int:
    told = max(run.about.outcome.frames, run.about.sequence.frames or 0) if run.about else 0
    return min(max(told, *saved, 0), MOST_FRAMES)


def _attempts_by_frame(root: AttemptNode) -> dict[int, int]:
    counts: dict[int, int] = {}
    left = [root]
    while left:
        node = left.pop()
        left += node.grown
        counts[node.frame] = counts.get(node.frame, 0) + (node.attempt > 0)
    return counts


def usage_by_frame(events: Iterable[RecordedEvent]) -> dict[int, FrameUsage]:
    """What was used from the beginning of each step towards a frame to the next step."""
    found: dict[int, FrameUsage] = {}
    frame, before = 0, 0.0
    for event in events:
        seconds = event.elapsed - before if event.elapsed >= before else event.elapsed
        before = event.elapsed
        if frame:
            found[frame] = found.get(frame, FrameUsage()).plus(event, seconds)
        if isinstance(event, StepStartedEvent):
            frame = event.frame
    return found


def _recorded_photos(events: Iterable[RecordedEvent]) -> Iterator[tuple[int, str]]:
    """The frames whose photos are on record, with their files; the last of a frame comes last."""
    for event in events:
        for picture in _pictures_of(event):
            if (told := _PHOTO.fullmatch(picture.subject)) and RECORDED_PICTURE.fullmatch(picture.file):
                yield int(told[1]), picture.file


def _pictures_of(event: RecordedEvent) -> list[RecordedPicture]:
    """The pictures of a result, or of the messages of a query."""
    if isinstance(event, ResultEvent):
        return event.images
    return (
        [picture for message in event.new for picture in message.images]
        if isinstance(event, RequestEvent)
        else []
    )
