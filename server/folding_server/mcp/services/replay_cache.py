"""Papers by the actions that lead to them, so that an action costs one step of folding and not a replay."""

from threading import Lock

from cachetools import LRUCache
from folding_schemas.actions import Actions

from folding_server.simulator import Paper, apply, new_paper

Sheet = tuple[float, float]


class ReplayCache:
    """A bounded cache of papers: those used least recently go first. Safe to use from many threads."""

    def __init__(self, size: int = 512) -> None:
        self._papers: LRUCache[tuple[Sheet, Actions], Paper] = LRUCache(size)
        self._lock = Lock()

    def after(self, sheet: Sheet, actions: Actions) -> Paper:
        """The paper that the actions make of a flat sheet. ActionRefused if one of them is impossible."""
        known, paper = self._longest_known(sheet, actions)
        for end in range(known, len(actions)):
            paper = apply(paper, actions[end])
            with self._lock:
                self._papers[sheet, actions[: end + 1]] = paper
        return paper

    def _longest_known(self, sheet: Sheet, actions: Actions) -> tuple[int, Paper]:
        """How many of the first actions have a paper in the cache, and that paper."""
        with self._lock:
            for end in range(len(actions), 0, -1):
                if (paper := self._papers.get((sheet, actions[:end]))) is not None:
                    return end, paper
        return 0, new_paper(sheet)
