"""Numbers as pages say them."""

NOT_KNOWN = "\N{EN DASH}"
"""What stands where a number is not known."""


def seconds_in_words(seconds: float | None) -> str:
    """A span of time, such as ``0.3 s``, ``27 s``, ``3 min 12 s`` or ``2 h 5 min``; a dash for None."""
    if seconds is None:
        return NOT_KNOWN
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def dollars_in_words(cost: float | None) -> str:
    """A price, such as ``$0.42``; a dash where it is not known, which is not the same as free."""
    if cost is None:
        return NOT_KNOWN
    return f"${cost:.2f}" if cost >= 0.1 or cost == 0 else f"${cost:.4f}"


def count_in_words(number: int | None) -> str:
    """A whole number with its thousands apart; a dash for None."""
    return NOT_KNOWN if number is None else f"{number:,}"


def bytes_in_words(size: int) -> str:
    """The size of a file, such as ``82 kB``."""
    return f"{size} B" if size < 1000 else f"{size / 1000:.0f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"


def share_in_words(share: float | None) -> str:
    """A share of 1 in percent, such as ``99.7 %``; a dash for None."""
    return NOT_KNOWN if share is None else f"{100 * share:.1f} %"


def score_in_words(score: float | None) -> str:
    """A score with three decimals; a dash for None."""
    return NOT_KNOWN if score is None else f"{score:.3f}"
