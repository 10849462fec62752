"""The files around the code: what is built, what is deployed, what the README promises."""

import json
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import click
import pytest
import yaml
from distributed.cli.dask_scheduler import main as dask_scheduler
from distributed.cli.dask_worker import main as dask_worker
from folding_client.cli import app as client
from folding_server.cli import app as server
from jsonschema import Draft201909Validator
from paths import ROOT
from typer.main import get_command

PACKAGES = ("folding_schemas", "folding_prompts", "folding_server", "folding_client")
TEXTS = {".py", ".md", ".toml", ".yml", ".json", ".lock", ".js", ".txt", ""}
HOSTS = ("pypi" + ".org", "pythonhosted" + ".org", "npmjs" + ".org", "npmjs" + ".com")
PLACES = ("/" + "work/", "/" + "root/", "/" + "home/")


def tracked() -> list[Path]:
    """The files of the project, as git lists them."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.split("\0") if name]


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel that users install."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (file,) = folder.glob("foldingagent_mcp-*.whl")
    return zipfile.ZipFile(file)


def test_the_wheel_holds_the_four_packages_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    tops = {name.split("/")[0] for name in wheel.namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == set(PACKAGES)


def test_the_wheel_holds_every_file_of_the_packages(wheel: zipfile.ZipFile) -> None:
    names = set(wheel.namelist())
    parents = {package: ROOT / package.removeprefix("folding_") for package in PACKAGES}
    wanted = {
        file.relative_to(parent).as_posix()
        for package, parent in parents.items()
        for file in tracked()
        if file.is_relative_to(parent / package) and file.exists()
    }
    assert {f"{package}/py.typed" for package in PACKAGES} <= wanted
    assert any(name.startswith("folding_prompts/tools/") for name in wanted)
    assert wanted <= names


def test_the_wheel_installs_both_commands_and_the_licence(wheel: zipfile.ZipFile) -> None:
    info = next(name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    commands = wheel.read(info).decode()
    assert "foldingagent = folding_client.cli:main" in commands
    assert "foldingagent-server = folding_server.cli:main" in commands
    assert any(name.endswith("licenses/LICENSE") for name in wheel.namelist())


def test_every_requirement_is_locked() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *extras["test"], *extras["dask"], *extras["postgres"]]
    lock = (ROOT / "requirements.lock").read_text()
    assert "://" not in lock
    names = {re.split(r"[<>=\[; ]", requirement)[0] for requirement in wanted}
    locked = {line.split("==")[0] for line in lock.splitlines()}
    assert names <= locked


def test_no_file_names_a_registry_or_a_place_on_a_machine() -> None:
    wrong = []
    for file in tracked():
        if file.suffix not in TEXTS or not file.is_file():
            continue
        text = file.read_text(encoding="utf-8")
        wrong += [f"{file.relative_to(ROOT)}: {word}" for word in (*HOSTS, *PLACES) if word in text]
    assert wrong == []


def compose() -> dict[str, Any]:
    """The compose file."""
    document: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    return document


def test_the_compose_file_follows_the_compose_specification() -> None:
    schema = json.loads((ROOT / "tests/data/compose_spec.json").read_text())
    Draft201909Validator.check_schema(schema)
    check = Draft201909Validator(schema)
    assert [error.message for error in check.iter_errors(compose())] == []
    broken = compose()
    broken["services"]["server"]["prots"] = []
    assert not check.is_valid(broken)


def test_volumes_and_services_that_the_compose_file_uses_are_declared() -> None:
    document = compose()
    for service in document["services"].values():
        assert set(service.get("depends_on", {})) <= set(document["services"])
        named = {volume.split(":")[0] for volume in service.get("volumes", ()) if volume[0] not in ".$/"}
        assert named <= set(document["volumes"])
        assert set(service.get("secrets", ())) <= set(document["secrets"])


def test_every_container_has_no_more_rights_than_it_needs() -> None:
    user = re.search(r"^USER (\w+)$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    assert user is not None
    for name, service in compose()["services"].items():
        assert service["read_only"] is True, name
        assert service["cap_drop"] == ["ALL"], name
        assert service["security_opt"] == ["no-new-privileges:true"], name
        assert service.get("user", user.group(1)) != "root", name
        assert all(str(port).startswith("127.0.0.1:") for port in service.get("ports", ())), name


def test_what_starts_by_itself_says_whether_it_is_well_and_others_wait_for_it() -> None:
    services = compose()["services"]
    assert {name for name, service in services.items() if "profiles" not in service} == {"server", "database"}
    for service in services.values():
        for needed, how in service.get("depends_on", {}).items():
            assert ("healthcheck" in services[needed]) is (how["condition"] == "service_healthy")


def test_the_server_of_the_image_starts_with_a_token_file_that_compose_hands_it() -> None:
    words = deployed()[-1]
    assert words[words.index("--token-file") + 1] == "/run/secrets/tokens"
    assert compose()["services"]["server"]["secrets"] == ["tokens"]


def deployed() -> list[list[str]]:
    """The commands that containers run."""
    commands = [service["command"] for service in compose()["services"].values() if "command" in service]
    own: list[str] = json.loads((ROOT / "Dockerfile").read_text().rpartition("\nCMD ")[2])
    return [*commands, own]


COMMANDS: dict[str, Any] = {
    "foldingagent": get_command(client),
    "foldingagent-server": get_command(server),
    "dask": click.Group(commands={"scheduler": dask_scheduler, "worker": dask_worker}),
}


@pytest.mark.parametrize("words", deployed(), ids=" ".join)
def test_containers_run_commands_that_exist_with_options_they_take(words: list[str]) -> None:
    command, arguments = COMMANDS[words[0]], words[1:]
    if arguments[0] in getattr(command, "commands", {}):
        command, arguments = command.commands[arguments[0]], arguments[1:]
    known = {name for option in command.params for name in (*option.opts, *option.secondary_opts)}
    assert {word for word in arguments if word.startswith("--")} <= known


def test_the_readme_gives_commands_and_pictures_that_exist() -> None:
    text = (ROOT / "README.md").read_text()
    pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)
    links = re.findall(r"[^!]\[[^]]*\]\((?!http)([^)#]+)\)", text)
    assert pictures
    assert [path for path in (*pictures, *links) if not (ROOT / path).exists()] == []
    scripts = set(re.findall(r"\b((?:scripts|benchmarks)/[\w/]+(?:\.py)?)", text))
    assert {"scripts/setup", "scripts/test"} <= scripts
    assert [path for path in scripts if not (ROOT / path).exists()] == []


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def anchors(page: Path) -> set[str]:
    """What links may name in a page: its headings, in small letters, without signs, words joined."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\[[^]]*\]\((?!http)([^)\s]+)\)", page.read_text(encoding="utf-8"))
    wrong = []
    for link in links:
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            wrong.append(link)
    assert wrong == []


def test_every_page_is_reached_from_the_readme() -> None:
    reached, left = {ROOT / "README.md"}, [ROOT / "README.md"]
    while left:
        page = left.pop()
        for link in re.findall(r"\]\((?!http)([^)#\s]+\.md)", page.read_text(encoding="utf-8")):
            target = (page.parent / link).resolve()
            if target not in reached:
                reached.add(target)
                left.append(target)
    assert set(PAGES) - reached == set()
