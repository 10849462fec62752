"""A real PostgreSQL server for tests, in a temporary folder, on a free port of the loopback address.

The programs ``initdb`` and ``postgres`` are found on the PATH or where Debian's package ``postgresql`` puts them. Where
they are missing and CI is set, root installs that package with apt-get; otherwise the tests that need them are skipped.
PostgreSQL refuses to run as root, so root starts it as the user ``postgres`` or ``nobody``. The environment variable
FOLDINGAGENT_TEST_DATABASE may name the URL of another server, whose user may create databases.
"""

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest
from lasting import LASTING
from sqlalchemy import create_engine, make_url
from sqlalchemy.exc import OperationalError

GIVEN = "FOLDINGAGENT_TEST_DATABASE"
START_SECONDS = 60.0
"""How long the server may take to answer; it takes one or two where nothing else runs."""


@contextmanager
def database() -> Iterator[str]:
    """The URL of an empty database, dropped afterwards. Skips the test where there is no PostgreSQL."""
    server, name = server_url(), f"folding_{uuid4().hex}"
    engine = create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    try:
        yield make_url(server).set(database=name).render_as_string(hide_password=False)
    finally:
        with engine.connect() as connection:
            connection.exec_driver_sql(f"DROP DATABASE {name} WITH (FORCE)")
        engine.dispose()


@contextmanager
def empty_database(kind: str, folder: Path) -> Iterator[str]:
    """The URL of an empty database, of ``kind`` "sqlite" (a file in the folder) or "postgresql"."""
    if kind == "sqlite":
        yield f"sqlite:///{folder / 'runs.sqlite3'}"
    else:
        with database() as url:
            yield url


@cache
def server_url() -> str:
    """The URL of a server that runs until the session ends."""
    if given := os.environ.get(GIVEN):
        return given
    programs = _programs()
    if programs is None:
        pytest.skip(f"there is no PostgreSQL here: install it, or name a database with {GIVEN}")
    return LASTING.enter_context(_running(programs))


def _programs() -> Path | None:
    """The folder with initdb and postgres."""
    found = _found()
    if found is None and os.environ.get("CI") and os.geteuid() == 0 and shutil.which("apt-get"):
        subprocess.run(["apt-get", "update", "-qq"], check=True)
        install = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", "postgresql"]
        subprocess.run(install, check=True, env={**os.environ, "DEBIAN_FRONTEND": "noninteractive"})
        found = _found()
    return found


def _found() -> Path | None:
    on_path = shutil.which("initdb")
    folders = [Path(on_path).parent] if on_path else sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    return next((folder for folder in reversed(folders) if (folder / "postgres").is_file()), None)


@contextmanager
def _running(programs: Path) -> Iterator[str]:
    """A server on a new cluster, without a password, and without syncing: its machine is not to fail."""
    folder = Path(tempfile.mkdtemp(prefix="folding-postgresql-"))
    as_whom = _unprivileged(folder)
    try:
        initdb = [
            programs / "initdb",
            "-D",
            folder / "data",
            "-U",
            "folding",
            "-A",
            "trust",
            "-E",
            "UTF8",
            "--no-sync",
        ]
        subprocess.run([*map(str, initdb)], check=True, stdout=subprocess.DEVNULL, cwd=folder, **as_whom)
        port = _free_port()
        settings = {
            "listen_addresses": "127.0.0.1",
            "port": port,
            "unix_socket_directories": "",
            "fsync": "off",
        }
        options = [word for name, value in settings.items() for word in ("-c", f"{name}={value}")]
        command = [str(programs / "postgres"), "-D", str(folder / "data"), *options]
        with (
            (folder / "log").open("wb") as log,
            subprocess.Popen(command, stderr=log, cwd=folder, **as_whom) as server,
        ):
            try:
                _wait_for(port, server, folder / "log")
                yield f"postgresql+psycopg://folding@127.0.0.1:{port}/postgres"
            finally:
                server.send_signal(2)  # end now, and cleanly
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _unprivileged(folder: Path) -> dict[str, Any]:
    """As whom to start the server, as arguments of Popen, and the folder given to that user."""
    if os.geteuid() != 0:
        return {}
    names = {entry.pw_name for entry in pwd.getpwall()}
    user = pwd.getpwnam("postgres" if "postgres" in names else "nobody")
    os.chown(folder, user.pw_uid, user.pw_gid)
    return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def _wait_for(port: int, server: "subprocess.Popen[bytes]", log: Path) -> None:
    """Wait until the server answers."""
    engine = create_engine(f"postgresql+psycopg://folding@127.0.0.1:{port}/postgres")
    deadline = time.monotonic() + START_SECONDS
    while True:
        try:
            engine.connect().close()
        except OperationalError:
            if server.poll() is not None or time.monotonic() > deadline:
                pytest.fail(f"PostgreSQL did not start: {log.read_text()}")
            time.sleep(0.1)
        else:
            engine.dispose()
            return
