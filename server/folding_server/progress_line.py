"""How far a command is, on stderr."""

import sys


class ProgressLine:
    """ProgressLine on stderr: one line that fills up on a terminal, a line at every quarter elsewhere."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._quarter = 0

    def tell(self, part: float) -> None:
        """Say what part of the work is done, 0 to 1."""
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{self._what}: {part:.0%}" + ("\n" if part >= 1 else ""))
            sys.stderr.flush()
        elif int(4 * part) > self._quarter:
            self._quarter = int(4 * part)
            sys.stderr.write(f"{self._what}: {part:.0%}\n")
