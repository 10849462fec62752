"""A share of cases, and how far that tells of the share of all cases there are."""

from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist

CONFIDENCE = 0.95
"""How often the true share lies within the interval."""


@dataclass(frozen=True)
class Share:
    """``count`` cases ``of`` so many, from 0 to 1, and Wilson's interval; None without cases.

    E. B. Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22 (1927).
    """

    count: int
    of: int
    share: float | None
    low: float | None
    high: float | None

    @property
    def text(self) -> str:
        """The share in words, such as ``88.0 % (22 of 25; 70.0 % to 95.8 %)``."""
        if self.share is None or self.low is None or self.high is None:
            return "no cases"
        return f"{self.share:.1%} ({self.count} of {self.of}; {self.low:.1%} to {self.high:.1%})"


def share_of(count: int, of: int) -> Share:
    """The share with its interval."""
    if of == 0:
        return Share(count, of, None, None, None)
    z = NormalDist().inv_cdf((1 + CONFIDENCE) / 2)
    share = count / of
    scale = 1 + z * z / of
    middle = (share + z * z / (2 * of)) / scale
    half = z * sqrt(share * (1 - share) / of + z * z / (4 * of * of)) / scale
    return Share(count, of, share, max(middle - half, 0.0), min(middle + half, 1.0))
