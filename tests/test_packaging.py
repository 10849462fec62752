"""What the packaging script makes: a bundle that Claude Desktop takes, and a description that the MCP registry takes."""

import hashlib
import importlib.util
import io
import json
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
from folding_server.mcp.catalogue import tools
from jsonschema import Draft7Validator
from paths import ROOT
from PIL import Image

URL = "https://example.org/foldingagent-mcp.mcpb"
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the script has filled."""
    folder = tmp_path_factory.mktemp("packages")
    script = [sys.executable, str(ROOT / "packaging/make.py"), str(folder), "--bundle-url", URL]
    subprocess.run(script, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="session")
def bundle(made: Path) -> zipfile.ZipFile:
    """The bundle."""
    return zipfile.ZipFile(made / f"foldingagent-mcp-{VERSION}.mcpb")


@pytest.fixture(scope="session")
def manifest(bundle: zipfile.ZipFile) -> dict[str, Any]:
    """What the bundle says of itself."""
    found: dict[str, Any] = json.loads(bundle.read("manifest.json"))
    return found


@pytest.fixture(scope="session")
def registered(made: Path) -> dict[str, Any]:
    """What the registry is told."""
    found: dict[str, Any] = json.loads((made / "server.json").read_text(encoding="utf-8"))
    return found


def schema(name: str) -> Draft7Validator:
    """The validator of a published schema."""
    document = json.loads((ROOT / "tests/data" / name).read_text(encoding="utf-8"))
    Draft7Validator.check_schema(document)
    return Draft7Validator(document)


def test_the_manifest_follows_its_schema_and_is_of_the_uv_type(manifest: dict[str, Any]) -> None:
    check = schema("mcpb_manifest_0.4.schema.json")
    assert [error.message for error in check.iter_errors(manifest)] == []
    assert not check.is_valid({**manifest, "tolls": []})
    assert (manifest["manifest_version"], manifest["server"]["type"]) == ("0.4", "uv")
    assert manifest["version"] == VERSION


def test_the_manifest_names_every_tool_of_the_server(manifest: dict[str, Any]) -> None:
    assert [tool["name"] for tool in manifest["tools"]] == [tool.name for tool in tools(reading_files=True)]
    assert all(re.fullmatch(r"[A-Z].*\.", tool["description"]) for tool in manifest["tools"])


def test_the_files_that_the_manifest_names_are_in_the_bundle(
    bundle: zipfile.ZipFile, manifest: dict[str, Any]
) -> None:
    assert {manifest["server"]["entry_point"], manifest["icon"], "pyproject.toml"} <= set(bundle.namelist())
    assert manifest["server"]["entry_point"] in manifest["server"]["mcp_config"]["args"]
    assert Image.open(io.BytesIO(bundle.read(manifest["icon"]))).size == (512, 512)


def test_the_bundle_installs_its_own_wheel_with_what_is_locked(bundle: zipfile.ZipFile) -> None:
    described = tomllib.loads(bundle.read("pyproject.toml").decode())
    wheel = described["tool"]["uv"]["sources"]["foldingagent-mcp"]["path"]
    assert described["project"]["dependencies"] == ["foldingagent-mcp[video]"]
    assert "folding_server/cli.py" in zipfile.ZipFile(io.BytesIO(bundle.read(wheel))).namelist()
    locked = (ROOT / "requirements.lock").read_text().splitlines()
    assert described["tool"]["uv"]["constraint-dependencies"] == locked


@pytest.mark.parametrize(
    ("words", "options"),
    [
        (["/a b", "/c"], ["--sequences", "/a b", "--sequences", "/c"]),
        ([""], []),
        (["${user_config.sequences}"], []),
        (["/a", "--allow", "/c d", "/e"], ["--sequences", "/a", "--allow", "/c d", "--allow", "/e"]),
        (["--allow", "/c"], ["--allow", "/c"]),
        (["${user_config.sequences}", "--allow", "${user_config.films}"], []),
        ([], []),
    ],
)
def test_the_entry_point_serves_the_chosen_folders(words: list[str], options: list[str]) -> None:
    spec = importlib.util.spec_from_file_location("bundle_main", ROOT / "packaging/bundle/main.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.options(words) == options


def test_the_registry_document_follows_its_schema(registered: dict[str, Any]) -> None:
    check = schema("server_json_2025-12-11.schema.json")
    assert [error.message for error in check.iter_errors(registered)] == []
    assert not check.is_valid({**registered, "name": "no-namespace"})
    assert not check.is_valid({**registered, "packages": [{"registryType": "pypi"}]})
    assert check.schema["$id"] == registered["$schema"]


def test_the_registry_is_told_of_this_version_and_of_the_bundle(
    made: Path, registered: dict[str, Any]
) -> None:
    package, bundle = registered["packages"]
    assert (package["identifier"], package["version"], registered["version"]) == (
        "foldingagent-mcp",
        VERSION,
        VERSION,
    )
    digest = hashlib.sha256((made / f"foldingagent-mcp-{VERSION}.mcpb").read_bytes()).hexdigest()
    assert (bundle["registryType"], bundle["identifier"], bundle["fileSha256"]) == ("mcpb", URL, digest)


def test_the_options_told_to_the_registry_are_the_servers(registered: dict[str, Any]) -> None:
    from folding_server.cli import app
    from typer.main import get_command

    taken = {name for parameter in get_command(app).params for name in parameter.opts}
    named = {argument["name"] for argument in registered["packages"][0]["packageArguments"]}
    assert named <= taken


def test_uvx_finds_a_command_by_the_name_of_the_package(registered: dict[str, Any]) -> None:
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    assert scripts[registered["packages"][0]["identifier"]] == scripts["foldingagent-server"]


def test_the_readme_proves_to_the_registry_whose_package_it_is(registered: dict[str, Any]) -> None:
    assert f"mcp-name: {registered['name']}" in (ROOT / "README.md").read_text(encoding="utf-8")
