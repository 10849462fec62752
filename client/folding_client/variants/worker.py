"""What carries a run out: the agent, or one of the paper's variants."""

from typing import Protocol

from folding_schemas.results import RunInfo


class Worker(Protocol):
    """Works on a run until every frame is done. ``simulates`` says whether its results are states of the
    server.
    """

    simulates: bool

    async def run(self) -> RunInfo:
        """Where the run stands at its end. RunStopped or ToolRefused if something ends it before."""
        ...
