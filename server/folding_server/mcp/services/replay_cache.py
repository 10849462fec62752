"""Papers by the actions that lead to them, so that an action costs one step of folding and not a replay."""

from threading import Lock

from cachetools import LRUCache
from cachetools.keys import hashkey
from folding_schemas.actions import Actions

from folding_server.simulator import Paper, apply, new_paper
from folding_server.store.non_blocking import WouldBlock, may_block

Sheet = tuple[float, float]

BRIEF_FACES = 24
"""The most faces of a paper on which an action is folded in the event loop. With its answer it takes 3 ms at most in the programs that
``benchmarks/simulator.py`` folds, and some 15 ms where all faces lie on one another."""


class ReplayCache:
    """A bounded cache of papers: those used least recently go first. Safe to use from many threads."""

    def __init__(self, size: int = 512) -> None:
        self._papers: LRUCache[tuple[object, ...], Paper] = LRUCache(size)
        self._lock = Lock()

    def after(self, sheet: Sheet, actions: Actions) -> Paper:
        """The paper that the actions make of a flat sheet. ActionRefused if one of them is impossible.

        WouldBlock in a call that may not wait, if that takes more than an action on a small paper.
        """
        known, paper = self._longest_known(sheet, actions)
        if not may_block() and (known < len(actions) - 1 or len(paper.faces) > BRIEF_FACES):
            raise WouldBlock
        for end in range(known, len(actions)):
            paper = apply(paper, actions[end])
            key = hashkey(sheet, *actions[: end + 1])
            with self._lock:
                self._papers[key] = paper
        return paper

    def _longest_known(self, sheet: Sheet, actions: Actions) -> tuple[int, Paper]:
        """How many of the first actions have a paper in the cache, and that paper."""
        with self._lock:
            for end in range(len(actions), 0, -1):
                key = hashkey(sheet, *actions[:end])  # of which the hash is taken once
                if (paper := self._papers.get(key)) is not None:
                    return end, paper
        return 0, new_paper(sheet)
