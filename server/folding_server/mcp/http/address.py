"""Where to listen, and whether other machines can reach it."""

import ipaddress
import os
import re
import socket
from typing import NamedTuple

from folding_server.errors import AddressError

_HOST_NAME = re.compile(r"[A-Za-z0-9._-]{1,253}|\[[0-9A-Fa-f:.]+\]")


class Address(NamedTuple):
    """Where to listen; port 0 lets the system choose one."""

    host: str
    port: int

    @property
    def in_url(self) -> str:
        """The host as URLs and Host headers write it."""
        return f"[{self.host}]" if ":" in self.host else self.host


def is_host_name(text: str) -> bool:
    """Whether a text can be the host in a Host header: a name, an IPv4 address, or an IPv6 address in brackets."""
    return _HOST_NAME.fullmatch(text) is not None


def parse_address(text: str) -> Address:
    """``HOST:PORT`` as an address, ``[HOST]:PORT`` for IPv6. AddressError if it is neither."""
    host, colon, port = text.rpartition(":")
    bracketed = host.startswith("[") and host.endswith("]")
    if (
        not colon
        or not host
        or ("[" in host and not bracketed)
        or not port.isascii()
        or not port.isdigit()
        or int(port) > 65535
    ):
        raise AddressError(f"{text!r} is no address to serve on; give HOST:PORT such as 127.0.0.1:8000.")
    return Address(host.strip("[]"), int(port))


def listen(address: Address) -> socket.socket:
    """A socket that listens on the address. AddressError with the system's reason if that cannot be.

    It carries the protocol number of TCP, which ``socket.create_server`` leaves out: asyncio sets TCP_NODELAY
    only on connections whose socket has it, and without that option the last packet of an answer waits for
    the client's delayed acknowledgement, 40 ms on Linux.
    """
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        made = socket.create_server(tuple(address), family=family)
    except OSError as error:
        reason = error.strerror or os.strerror(error.errno) if error.errno else str(error)
        reason = reason.partition(" (while ")[0]  # Python's own words repeat the address
        raise AddressError(
            f"Cannot serve on {address.in_url}:{address.port} ({reason}); choose another address with --http."
        ) from error
    return socket.socket(made.family, made.type, socket.IPPROTO_TCP, fileno=made.detach())


def is_local(listener: socket.socket) -> bool:
    """Whether only this machine can reach a socket: it is bound to a loopback address."""
    return ipaddress.ip_address(listener.getsockname()[0]).is_loopback
