"""Commands of the server in the tests' own process: a process of its own takes seconds to start."""

from typing import NamedTuple

import pytest
from folding_server.cli import main


class Ended(NamedTuple):
    """How a command ended, and what it said."""

    code: int
    out: str
    err: str


def run_here(capsys: pytest.CaptureFixture[str], *words: object) -> Ended:
    """Run ``foldingagent-server`` with these words."""
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    said = capsys.readouterr()
    return Ended(int(end.value.code or 0), said.out, said.err)
