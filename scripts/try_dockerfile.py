"""Carry out the Dockerfile's own COPY and ``pip install`` lines in a clean environment, without a container engine.

``python3.11 scripts/try_dockerfile.py`` makes a folder with only the files that the Dockerfile copies, and a new virtual
environment for its ``pip``; installs; and runs both commands with ``--version`` in an environment without variables.
What the machine or the image provides (packages of the system, users) is left out and named.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CARRIED_OUT = ("pip", "python")
"""The programs whose RUN lines are carried out."""
KEPT = (
    "HTTPS_PROXY",
    "HTTP_PROXY",
    "NO_PROXY",
    "PIP_CONFIG_FILE",
    "PIP_INDEX_URL",
    "PIP_CERT",
    "SSL_CERT_FILE",
    "HOME",
)
"""The variables that pip needs where a network is only reached in a certain way."""


def main() -> None:
    """Install as the Dockerfile does, and see that the commands run. The exit code is that of what fails."""
    with tempfile.TemporaryDirectory() as folder:
        app, environment = Path(folder) / "app", Path(folder) / "environment"
        app.mkdir()
        venv.create(environment, with_pip=True)
        variables = {name: os.environ[name] for name in KEPT if name in os.environ}
        path = f"{environment / 'bin'}{os.pathsep}{os.defpath}"
        for instruction, arguments in instructions((ROOT / "Dockerfile").read_text()):
            if instruction == "COPY":
                copy(shlex.split(arguments), app)
            elif instruction == "RUN" and shlex.split(arguments)[0] in CARRIED_OUT:
                said(f"RUN {arguments}")
                subprocess.run(
                    ["/bin/sh", "-c", arguments], cwd=app, env={**variables, "PATH": path}, check=True
                )
            elif instruction == "RUN":
                said(f"left out: RUN {arguments}")
            elif instruction == "CMD":
                for command in dict.fromkeys([json.loads(arguments)[0], "foldingagent", "dask"]):
                    subprocess.run(
                        [str(environment / "bin" / command), "--version"], env={}, cwd=folder, check=True
                    )
        subprocess.run(
            [str(environment / "bin/python"), "-c", "import distributed, psycopg"], env={}, check=True
        )
    said("installed, and the commands run")


def instructions(dockerfile: str) -> Iterator[tuple[str, str]]:
    """The instructions of a Dockerfile with their arguments; continued lines are joined."""
    for line in re.sub(r"\\\n\s*", "", dockerfile).splitlines():
        if line and not line.startswith("#"):
            instruction, _, arguments = line.partition(" ")
            yield instruction, arguments


def copy(paths: list[str], app: Path) -> None:
    """Copy files and folders of the project as COPY does: the content of a folder, and files into a folder."""
    *sources, target = paths
    for source in sources:
        if (ROOT / source).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / source, app / target, dirs_exist_ok=True, ignore=ignored)
        else:
            shutil.copy(ROOT / source, app / target)


def said(line: str) -> None:
    """Say it on stderr."""
    sys.stderr.write(f"{line}\n")


if __name__ == "__main__":
    main()
