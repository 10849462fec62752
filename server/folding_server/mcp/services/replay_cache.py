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
        keys = _Keys(sheet, actions)
        known, paper = self._longest_known(keys)
        if not may_block() and (known < len(actions) - 1 or len(paper.faces) > BRIEF_FACES):
            raise WouldBlock
        for end in range(known, len(actions)):
            paper = apply(paper, actions[end])
            with self._lock:
                self._papers[keys[end + 1]] = paper
        return paper

    def _longest_known(self, keys: "_Keys") -> tuple[int, Paper]:
        """How many of the first actions have a paper in the cache, and that paper."""
        with self._lock:
            for end in range(len(keys.actions), 0, -1):
                if (paper := self._papers.get(keys[end])) is not None:
                    return end, paper
        return 0, new_paper(keys.sheet)


class _Keys(dict[int, tuple[object, ...]]):
    """The keys of the papers after so many actions, each made once, since to take the hash of actions takes long."""

    def __init__(self, sheet: Sheet, actions: Actions) -> None:
        super().__init__()
        self.sheet = sheet
        self.actions = actions

    def __missing__(self, end: int) -> tuple[object, ...]:
        key = self[end] = hashkey(self.sheet, *self.actions[:end])
        return key
