"""Asking a model for an answer of a given form, with one chance to mend it."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from folding_client.interrupts import ReplyUnreadable
from folding_client.messages import Message, Reply, answered, user
from folding_client.roles.role_client import RoleClient

_Form = TypeVar("_Form")


async def read_answer(
    role_client: RoleClient,
    messages: Sequence[Message],
    read: Callable[[str], _Form],
    again: Callable[[str], str],
    *,
    json_mode: bool = False,
) -> _Form:
    """What ``read`` makes of the model's reply. If it cannot be read it is sent back once, with the words
    that ``again`` finds for the reason. ReplyUnreadable if the second cannot be read either. With ``json_mode`` the
    provider is asked for JSON alone, where it can be.
    """
    reply: Reply | None = None
    try:
        reply = await role_client.query(messages, json_mode=json_mode)
        return read(reply.text)
    except ReplyUnreadable as reason:
        said = [answered(reply)] if reply is not None and reply.text.strip() else []
        repaired = await role_client.query(
            [*messages, *said, user(again(str(reason)))], new_from=len(messages), json_mode=json_mode
        )
    return read(repaired.text)
