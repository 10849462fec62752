"""Web applications that a test serves itself, in a thread of its own."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import anyio
import uvicorn


@contextmanager
def serving_in_a_thread(config: uvicorn.Config, listener: socket.socket) -> Iterator[str]:
    """The protocol's URL on a listening socket, while an application is served there in a thread."""
    web = uvicorn.Server(config)
    thread = threading.Thread(target=anyio.run, args=(web.serve, [listener]))
    thread.start()
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/mcp"
    finally:
        web.should_exit = True
        thread.join()
