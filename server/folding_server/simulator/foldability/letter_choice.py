"""Letters for the unassigned creases around one vertex, so that it folds flat.

Of equal angles between larger ones, k in a row, mountains and valleys of their k + 1 creases are as many, and all fold into the
sector between; or, where their number is odd, they differ by one and leave one crease, of the letter that there is more of. Where all
angles are equal they differ by two. (Hull, "Counting mountain-valley assignments for flat folds", 2003.)
"""

from collections.abc import Sequence
from dataclasses import dataclass

from folding_server.simulator.foldability.pattern import Assignment

MORE_MOUNTAINS: dict[Assignment, int] = {"M": 1, "V": -1}
"""How many more mountains than valleys several creases have of which one is left, by its letter."""


@dataclass(frozen=True)
class _Crease:
    """A crease, or one that is left of several; its letter is U where both letters do."""

    letter: Assignment
    index: int = -1
    of: tuple["_Crease", ...] = ()


def chosen_letters(
    angles: Sequence[float], letters: Sequence[Assignment], equal: float, *, closed: bool
) -> list[Assignment] | None:
    """The letters with M or V in the place of each U, or None if no choice folds flat.

    ``angles`` in radians; crease k lies between sectors k and k + 1; ``equal`` is by how much angles that are meant to be equal
    may differ.
    """
    creases = [_Crease(letter, k) for k, letter in enumerate(letters)]
    left, chosen = list(angles), dict[int, Assignment]()
    while creases:
        start, length = _smallest_run(left, equal, closed=closed)
        if closed and length >= len(left) - 1:
            if not (_settled(creases, 2, chosen) or _settled(creases, -2, chosen)):
                return None
            break
        if closed:
            first = (start - 1) % len(left)
            left, creases = left[first:] + left[:first], creases[first:] + creases[:first]
            start = 1
        if 0 < start < len(left) - length:
            if not _folded_between(left, creases, chosen, start, length):
                return None
        else:
            _fold_end(left, creases, chosen, start, length)
    return [chosen[k] for k in range(len(letters))]


def _smallest_run(angles: Sequence[float], equal: float, *, closed: bool) -> tuple[int, int]:
    """Where the angles equal to the smallest begin that lie beside it, and how many they are; around a closed circle."""
    count = len(angles)
    smallest = min(range(count), key=angles.__getitem__)
    most = angles[smallest] + equal
    start, end = smallest, smallest + 1
    while end - smallest < count and (closed or end < count) and angles[end % count] <= most:
        end += 1
    while end - start < count and (closed or start > 0) and angles[(start - 1) % count] <= most:
        start -= 1
    return start, end - start


def _folded_between(
    angles: list[float], creases: list[_Crease], chosen: dict[int, Assignment], start: int, length: int
) -> bool:
    """Fold equal angles into the larger ones beside them, in place; False if their creases do not allow it."""
    between = slice(start - 1, start + length)
    of = tuple(creases[between])
    if length % 2:
        wide = angles[start - 1] + angles[start + length] - angles[start]
        angles[start - 1 : start + length + 1] = [wide]
        del creases[between]
        return _settled(of, 0, chosen)
    possible = [letter for letter, more in MORE_MOUNTAINS.items() if _new_mountains(of, more) is not None]
    if not possible:
        return False
    del angles[start : start + length]
    creases[between] = [_Crease(possible[0] if len(possible) == 1 else "U", of=of)]
    return True


def _fold_end(
    angles: list[float], creases: list[_Crease], chosen: dict[int, Assignment], start: int, length: int
) -> None:
    """Fold equal angles at an end of an open stretch onto what is beside them, in place: any letters do."""
    at = slice(0, length) if start == 0 else slice(start - 1, start - 1 + length)
    for crease in creases[at]:
        more = MORE_MOUNTAINS["V" if crease.letter == "U" else crease.letter]
        _settled([crease], more, chosen)
    del creases[at]
    del angles[start : start + length]


def _new_mountains(creases: Sequence[_Crease], more: int) -> int | None:
    """How many of the unassigned creases must be mountains for so many more mountains than valleys; None if it cannot be."""
    letters = [crease.letter for crease in creases]
    free = letters.count("U")
    twice = more + free - letters.count("M") + letters.count("V")
    return twice // 2 if twice % 2 == 0 and 0 <= twice <= 2 * free else None


def _settled(creases: Sequence[_Crease], more: int, chosen: dict[int, Assignment]) -> bool:
    """Choose letters with so many more mountains than valleys, also where of several one is left; False if there are none."""
    if _new_mountains(creases, more) is None:
        return False
    waiting = [(creases, more)]
    while waiting:
        creases, more = waiting.pop()
        mountains = _new_mountains(creases, more) or 0
        for crease in creases:
            letter = crease.letter
            if letter == "U":
                letter = "M" if mountains > 0 else "V"
                mountains -= 1
            if crease.of:
                waiting.append((crease.of, MORE_MOUNTAINS[letter]))
            else:
                chosen[crease.index] = letter
    return True
