"""What tests start once and share: it ends with the session, and with the process wherever there is none."""

import atexit
from contextlib import ExitStack

LASTING = ExitStack()
"""Closed by ``conftest`` after the last test. Whoever starts something that others share says here how it ends."""

atexit.register(LASTING.close)
