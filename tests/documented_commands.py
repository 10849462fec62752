"""The commands that README and pages give in their blocks, and why some of them are not run by a test."""

import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from paths import ROOT

PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
PROGRAMS = frozenset(
    {
        *("foldingagent", "foldingagent-server", "foldingagent-mcp", "python", "python3.11"),
        *("scripts/setup", "scripts/test", "scripts/lint", "scripts/peers"),
        *("claude", "docker", "npx", "pip", "uv", "uvx"),
    }
)
"""What a command of ours begins with, less the folder of the virtual environment."""
OTHER_BLOCKS = frozenset({"photos", "[{text:", "#", "--limit", "folder/keyframes.json"})
"""The first words of blocks that are no commands: a flow, files, options, a script of a model."""

NOT_RUN: Mapping[str, str] = {
    r"scripts/(setup|test|lint|peers)\b": "installs packages, or runs the tests of which this is one",
    r"(pip|uvx|uv) ": "installs packages from a registry",
    r"\S+/oldest/bin/": "uses an environment that the line before it makes",
    r"npx ": "installs a package from a registry; scripts/peers runs it",
    r"claude ": "needs Claude Code",
    r"OTEL_EXPORTER_OTLP_ENDPOINT=": "needs a collector; the tests of exports start one",
    r"foldingagent batch (EXPERIMENT|sequences/ --models)": "makes many runs; the tests of experiments make some",
    r"foldingagent run SEQUENCE --model (random|search)": "the tests of baselines run them",
    r"docker ": "needs a container engine and pulls images",
    r"(python\S* )?(benchmarks|scripts|packaging)/\S+\.py": "measures or builds, for minutes",
    r"PYTHONPATH=tests python tests/contract/": "writes what other tests compare with",
    r"foldingagent report .*--watch": "goes on until it is ended; a test of the report serves it",
    r"foldingagent study": "needs two folders of completed runs, or the answers of people; the tests of the study make them",
    r".*--model (litellm/|hybrid:)": "needs the key of a provider",
    r".*import-purelandfold ": "needs a file of the data set; a test of the import makes one",
    r".*--dask ": "needs a cluster; tests of the cluster start one",
    r".*--database postgresql": "needs a PostgreSQL server; tests of the store start one",
    r".*--server-url https://": "needs a server elsewhere",
    r".* 0\.0\.0\.0:": "listens to other machines",
}
"""Commands that are only checked for programs, options and paths, as regular expressions, each with the reason."""


IN_TEXT = "stands within a sentence, often as a part of a command"


@dataclass(frozen=True)
class Command:
    """A command of a page: its words, and the assignments before them."""

    page: str
    words: tuple[str, ...]
    variables: tuple[str, ...] = ()
    in_text: bool = False

    @property
    def text(self) -> str:
        """The command in one line, its program without the folder of the virtual environment."""
        return " ".join((*self.variables, *self.words))

    @property
    def shape(self) -> tuple[str, ...]:
        """Program, subcommand and options, without the names of files and their kind of placeholder."""
        return (*self.words[:2], *(word for word in self.words if word.startswith("-")))

    @property
    def why_not_run(self) -> str | None:
        """The reason why no test runs it; None if one does."""
        if self.in_text:
            return IN_TEXT
        return next((why for pattern, why in NOT_RUN.items() if re.match(pattern, self.text)), None)


def blocks(page: Path) -> Iterator[list[str]]:
    """The lines of each indented block and of each fenced block of a shell."""
    text = page.read_text(encoding="utf-8")
    for body in re.findall(r"^```(?:sh|bash|console)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield body.splitlines()
    without_fences = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    for found in re.finditer(r"(?:\A|\n)[ ]*\n((?:    [^\n]*(?:\n|\Z))+)", without_fences):
        yield [line[4:] for line in found[1].splitlines()]


def commands_in(page: Path) -> Iterator[Command]:
    """The commands of a page's blocks, one for each that stands between ``&&``, and then those within its sentences."""
    for block in blocks(page):
        if not is_other(block):
            for line in block:
                yield from _commands(page.name, line)
    text = re.sub(
        r"^(```.*?^```|    .*?$)", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )
    for span in re.findall(r"`([^`]+)`", text):
        words = span.removeprefix(".venv/bin/").split()
        if len(words) > 1 and (
            words[0] in PROGRAMS or re.match(r"(benchmarks|packaging|scripts)/", words[0])
        ):
            yield Command(page.name, tuple(words), in_text=True)


def is_other(block: list[str]) -> bool:
    """Whether a block is known to hold no commands."""
    return block[0].split()[0].replace('"', "") in OTHER_BLOCKS


def _commands(page: str, line: str) -> Iterator[Command]:
    """The commands of a line, without what is said about it after two spaces."""
    for part in re.split(r"\s{2,}", line)[0].split(" && "):
        words = shlex.split(part)
        count = next((at for at, word in enumerate(words) if not re.match(r"[A-Z_]+=", word)), len(words))
        words[count] = words[count].removeprefix(".venv/bin/")
        yield Command(page, tuple(words[count:]), tuple(words[:count]))


@cache
def documented() -> tuple[Command, ...]:
    """All commands, those that read alike once."""
    found: dict[str, Command] = {}
    for page in PAGES:
        for command in commands_in(page):
            found.setdefault(command.text, command)
    return tuple(found.values())
