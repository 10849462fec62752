"""The overview critic: where in the reconstruction so far did it go wrong?"""

from dataclasses import dataclass
from functools import partial
from typing import Protocol

from folding_prompts import prompt
from folding_schemas.results import CheckpointSaved, Comparison, RunInfo

from folding_client.interrupts import ReplyUnreadable, ToolRefused
from folding_client.messages import ToolResult, system, user
from folding_client.protocol.acting import carry_out
from folding_client.protocol.server_client import ServerClient
from folding_client.roles.reply_parsing import OverviewReply, read_form, with_words
from folding_client.roles.reply_repair import read_answer
from folding_client.roles.role_client import RoleClient


@dataclass(frozen=True)
class OverviewAnalysis:
    """Frames and notes; ``readable`` is False if there is no analysis that can be read, and the recommendation says
    why.
    """

    last_correct_frame: int | None
    first_suspicious_frame: int | None
    per_frame_notes: tuple[str, ...]
    recommendation: str
    readable: bool = True


class OverviewCritic(Protocol):
    """Analyses the checkpoint overview."""

    async def analyse(self, overview: ToolResult) -> OverviewAnalysis:
        """What the overview, as the server answered it, shows."""
        ...


class GeometricOverview:
    """Compares every saved frame with its photo, on a scratch run."""

    def __init__(self, server: ServerClient) -> None:
        self._server = server

    async def analyse(self, overview: ToolResult) -> OverviewAnalysis:  # noqa: ARG002
        """The first frame whose comparison is no match is suspicious, the one before it the last correct. Not readable
        if the server refuses the scratch run or a comparison.
        """
        try:
            comparisons = await self._comparisons(await self._server.where())
        except ToolRefused as refusal:
            unread = f"The saved frames cannot be compared with their photos: {refusal}"
            return OverviewAnalysis(None, None, (), unread, readable=False)
        notes = tuple(
            f"frame {item.frame}: {item.verdict}, agreement {item.agreement:.4f}" for item in comparisons
        )
        suspicious = next((item.frame for item in comparisons if item.verdict != "MATCH"), None)
        if suspicious is None:
            last = comparisons[-1].frame if comparisons else None
            return OverviewAnalysis(
                last, None, notes, "Every saved frame matches its photo; go on from the last."
            )
        return OverviewAnalysis(
            suspicious - 1 or None,
            suspicious,
            notes,
            f"Restore checkpoint {max(suspicious - 1, 1)} and redo frame {suspicious}.",
        )

    async def _comparisons(self, info: RunInfo) -> list[Comparison]:
        found = []
        async with self._server.another_run(info.sequence):
            for frame, actions in enumerate(((), *info.program.steps), start=1):
                await carry_out(self._server, actions)
                found.append((await self._server.ask(Comparison, "compare_to_frame", frame=frame))[0])
                await self._server.ask(CheckpointSaved, "save_checkpoint", frame=frame)
        return found


class ModelOverview:
    """Asks a vision-language model that sees the overview picture."""

    def __init__(self, role_client: RoleClient, colors: tuple[str, str]) -> None:
        self._role_client = role_client
        self._colors = colors

    async def analyse(self, overview: ToolResult) -> OverviewAnalysis:
        """The model's analysis; a reply that cannot be read is sent back once."""
        front, back = self._colors
        messages = [
            system(prompt("overview/system", front=front, back=back)),
            user(prompt("overview/user", frames=overview.text), overview.pictures),
        ]
        try:
            read = partial(read_form, OverviewReply)
            form = await read_answer(self._role_client, messages, read, _repair, json_mode=True)
        except ReplyUnreadable as reason:
            unread = f"The overview critic gave no analysis that can be read ({reason})."
            return OverviewAnalysis(None, None, (), with_words(unread, reason.text), readable=False)
        return OverviewAnalysis(
            form.last_correct_frame,
            form.first_suspicious_frame,
            tuple(form.per_frame_notes),
            form.recommendation,
        )


def _repair(reason: str) -> str:
    return prompt("overview/repair", reason=reason)
