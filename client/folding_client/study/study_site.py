"""The page of a user study: each question shows a photo and two reconstructions under names that tell nothing."""

import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files as package_files
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from folding_client.interrupts import UsageError
from folding_client.record.folder import write_atomically
from folding_client.report.server_pictures import fetch_pictures
from folding_client.report.site import asset
from folding_client.report.site_files import SiteFiles, content_key
from folding_client.study.study_files import KeyedQuestion, StudyKey, StudySide
from folding_client.study.study_questions import JointSequence

_SIDES: tuple[StudySide, StudySide] = ("first", "second")


@dataclass(frozen=True)
class ShownQuestion:
    """A question as the page has it: its id and its three pictures within the site."""

    question: str
    photo: str
    left: str
    right: str


async def write_study(
    sequences: Sequence[JointSequence],
    questions: Sequence[KeyedQuestion],
    key: StudyKey,
    out: Path,
    say: Callable[[str], None],
) -> None:
    """Write the site. UsageError if a picture cannot be made, or the folder holds something else."""
    files = SiteFiles(out, "study")
    with tempfile.TemporaryDirectory() as place:
        made = SiteFiles(Path(place), "study")
        runs = {f"{side}/{each.name}": each.sides[side] for each in sequences for side in _SIDES}
        troubles = await fetch_pictures(runs, made, say, overlays=False)
        if troubles:
            name, why = next(iter(troubles.items()))
            message = f"The pictures of {name.partition('/')[2]} cannot be made: {why[0]}"
            raise UsageError(message)
        chance = random.Random(key.seed)
        by_name = {each.name: each for each in sequences}
        shown = [_shown(each, by_name[each.sequence], made, files, chance) for each in questions]
    files.keep_only({place for each in shown for place in (each.photo, each.left, each.right)})
    page = _environment().get_template("study.html").render(key=key, questions=shown)
    for name, text in (
        ("index.html", page),
        ("assets/report.css", asset("report.css")),
        ("assets/icon.svg", asset("icon.svg")),
        ("assets/study.css", _study_asset("study.css")),
        ("assets/study.js", _study_asset("study.js")),
    ):
        files.write(name, text)


def _shown(
    asked: KeyedQuestion, sequence: JointSequence, made: SiteFiles, files: SiteFiles, chance: random.Random
) -> ShownQuestion:
    """A question with copies of its pictures under names drawn by chance."""
    sides = _SIDES if asked.left == "first" else _SIDES[::-1]
    runs = [sequence.sides[side] for side in sides]
    keys = [runs[0].photo_key(asked.frame), *(run.state_key("diagram", asked.frame) for run in runs)]
    photo, left, right = (_copied(made, key, files, chance) for key in keys)
    return ShownQuestion(asked.question, photo, left, right)


def _copied(made: SiteFiles, key: str, files: SiteFiles, chance: random.Random) -> str:
    source = made.folder / (made.picture(key) or "")
    mime = {".svg": "image/svg+xml", ".png": "image/png"}.get(source.suffix, "image/jpeg")
    return files.keep_picture(content_key("shown", chance.getrandbits(128)), source.read_bytes(), mime)


def write_key(key: StudyKey, file: Path, site: Path) -> None:
    """Write the key beside the site. UsageError if it would lie within."""
    if file.resolve().is_relative_to(site.resolve()):
        message = f"The key {file} would lie in the site {site}, where participants can read it; name another place with --key."
        raise UsageError(message)
    write_atomically(file, (key.model_dump_json(indent=1) + "\n").encode("utf-8"))


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("folding_client.study"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _study_asset(name: str) -> str:
    return (package_files("folding_client.study") / "assets" / name).read_text(encoding="utf-8")
