"""Make what hosts and the registry take: a bundle for Claude Desktop and a ``server.json`` for the MCP registry.

python packaging/make.py DIR [--bundle-url URL]

DIR/foldingagent-mcp-VERSION.mcpb is a zip archive of type "uv": the wheel of this project, a pyproject.toml that names it and
the locked versions of what it needs, and a script that starts the server. DIR/server.json describes the package on the
index, and with --bundle-url also the bundle at that address, with its SHA-256. Everything is made from this checkout; the same
checkout gives the same bytes.
"""

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from folding_server.diagram import draw_svg, rasterise
from folding_server.diagram.palette import colors_of
from folding_server.diagram.view import centred_view
from folding_server.interchange.programs import load_program
from folding_server.mcp.catalogue import tools
from folding_server.simulator import apply, new_paper

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
ICON_SIDE = 512
"""Pixels, as Claude Desktop recommends."""
ZIP_TIME = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a zip archive can give its files, instead of now."""


def project() -> dict[str, Any]:
    """The project's own description."""
    found: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def template(name: str) -> dict[str, Any]:
    """One of the documents beside this script, without what depends on the version."""
    found: dict[str, Any] = json.loads((HERE / name).read_text(encoding="utf-8"))
    return found


def manifest(version: str) -> dict[str, Any]:
    """The bundle's manifest, with the server's tools."""
    listed = [
        {"name": tool.name, "description": _first_sentence(tool.description or "")}
        for tool in tools(reading_files=True)
    ]
    return {**template("manifest.json"), "version": version, "tools": listed}


def _first_sentence(text: str) -> str:
    return " ".join(text.split()).partition(". ")[0].removesuffix(".") + "."


def bundle_project(version: str, python: str, wheel: str) -> str:
    """The bundle's pyproject.toml: the wheel beside it, with what it needs in the locked versions."""
    locked = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    constraints = "".join(f"    {json.dumps(line)},\n" for line in locked if line)
    return (
        f'[project]\nname = "foldingagent-mcp-bundle"\nversion = "{version}"\nrequires-python = "{python}"\n'
        'dependencies = ["foldingagent-mcp[video]"]\n\n'
        f"[tool.uv]\npackage = false\nconstraint-dependencies = [\n{constraints}]\n\n"
        f'[tool.uv.sources]\nfoldingagent-mcp = {{ path = "{wheel}" }}\n'
    )


def icon() -> bytes:
    """The cat of the examples, as PNG."""
    program = load_program((ROOT / "examples/programs/cat.json").read_text(encoding="utf-8"))
    paper = new_paper(program.sheet)
    for step in program.steps:
        for action in step:
            paper = apply(paper, action)
    colors = colors_of(program.front_color, program.back_color)
    return rasterise(draw_svg(paper, colors, size=ICON_SIDE, view=centred_view(paper, ICON_SIDE)))


def wheel_of_the_project() -> tuple[str, bytes]:
    """The wheel's file name and content."""
    with tempfile.TemporaryDirectory() as folder:
        build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, str(ROOT)]
        subprocess.run(build, check=True, capture_output=True, cwd=ROOT)
        (wheel,) = Path(folder).glob("*.whl")
        return wheel.name, wheel.read_bytes()


def bundle(version: str) -> bytes:
    """The archive."""
    name, wheel = wheel_of_the_project()
    described = bundle_project(version, project()["requires-python"], name)
    with tempfile.TemporaryFile() as file:
        _write_zip(
            zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED),
            {
                "manifest.json": _json(manifest(version)),
                "pyproject.toml": described.encode(),
                "main.py": (HERE / "bundle/main.py").read_bytes(),
                "icon.png": icon(),
                "LICENSE": (ROOT / "LICENSE").read_bytes(),
                name: wheel,
            },
        )
        file.seek(0)
        return file.read()


def _write_zip(archive: zipfile.ZipFile, contents: Mapping[str, bytes]) -> None:
    with archive:
        for name, content in contents.items():
            about = zipfile.ZipInfo(name, ZIP_TIME)
            about.external_attr = 0o644 << 16
            archive.writestr(about, content, zipfile.ZIP_DEFLATED)


def server_json(version: str, archive: bytes, url: str | None) -> dict[str, Any]:
    """The registry's description of this server; with a ``url``, also of the bundle there."""
    described = template("server.json")
    packages = [{**package, "version": version} for package in described["packages"]]
    if url:
        digest = hashlib.sha256(archive).hexdigest()
        packages.append(
            {"registryType": "mcpb", "identifier": url, "fileSha256": digest, "transport": {"type": "stdio"}}
        )
    return {**described, "version": version, "packages": packages}


def _json(document: Mapping[str, Any]) -> bytes:
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def main() -> None:
    """Write both."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--bundle-url", metavar="URL", help="where the bundle will be published")
    given = parser.parse_args()
    version = project()["version"]
    archive = bundle(version)
    given.folder.mkdir(parents=True, exist_ok=True)
    written = {
        given.folder / f"foldingagent-mcp-{version}.mcpb": archive,
        given.folder / "server.json": _json(server_json(version, archive, given.bundle_url)),
    }
    for file, content in written.items():
        file.write_bytes(content)
        print(f"wrote {file}")


if __name__ == "__main__":
    main()
