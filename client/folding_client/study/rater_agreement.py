"""How far raters agree beyond chance, for answers that are names and have no order."""

from collections import Counter
from collections.abc import Hashable, Sequence

Ratings = Sequence[Sequence[Hashable]]
"""For each item, the answers that it got, in any order; an item may have any number."""


def fleiss_kappa(ratings: Ratings) -> float | None:
    """Fleiss' kappa: 1 for full agreement, 0 for that of chance. None unless every item got the same number of answers, at least
    two, and not all answers are the same.

    J. L. Fleiss, "Measuring nominal scale agreement among many raters", Psychological Bulletin 76 (1971).
    """
    counts = [Counter(item) for item in ratings]
    sizes = {count.total() for count in counts}
    if len(sizes) != 1 or (raters := sizes.pop()) < 2:
        return None
    observed = sum(
        sum(number * (number - 1) for number in count.values()) / (raters * (raters - 1)) for count in counts
    ) / len(counts)
    shares = _sum(counts)
    expected = sum((number / shares.total()) ** 2 for number in shares.values())
    return None if len(shares) < 2 else (observed - expected) / (1 - expected)


def krippendorff_alpha(ratings: Ratings) -> float | None:
    """Krippendorff's alpha for nominal data, which takes items with any number of answers; those with one tell nothing. None
    where no item got two, or all answers are the same.

    K. Krippendorff, "Computing Krippendorff's alpha-reliability" (2011), section on nominal data with missing values.
    """
    counts = [count for count in map(Counter, ratings) if count.total() > 1]
    totals = _sum(counts)
    pairable = totals.total()
    if len(totals) < 2:
        return None
    disagreeing = sum(
        sum(number * (count.total() - number) for number in count.values()) / (count.total() - 1)
        for count in counts
    )
    by_chance = sum(number * (pairable - number) for number in totals.values()) / (pairable - 1)
    return 1 - disagreeing / by_chance


def _sum(counts: Sequence[Counter[Hashable]]) -> Counter[Hashable]:
    total: Counter[Hashable] = Counter()
    for count in counts:
        total.update(count)
    return total
