"""`keyframes.json`: which images of a sequence are its keyframes, and what paper was folded."""

import json
from pathlib import Path
from typing import Annotated, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StrictInt, ValidationError, model_validator

from folding_server.errors import FoldingError, PhotoError
from folding_server.frames.color_names import color_rgb

FILE_NAME = "keyframes.json"
MAX_MANIFEST_BYTES = 4_000_000
NAME_LENGTH = 200


def check_name(name: str) -> str:
    """`name` if it can name a sequence: one to 200 printable characters, no path. Raises PhotoError."""
    shown = ascii(name) if len(name) <= NAME_LENGTH else f"{name[:40]!a}..."
    if not name.strip() or len(name) > NAME_LENGTH or not name.isprintable():
        raise PhotoError(
            f"the sequence name {shown} is not usable: use 1 to {NAME_LENGTH} printable characters"
        )
    if "/" in name or "\\" in name or name in (".", ".."):
        raise PhotoError(
            f"the sequence name {shown} is a path: use a plain name, as the list of sequences shows it"
        )
    return name


def _plain(text: str) -> str:
    try:
        return check_name(text)
    except FoldingError as error:
        raise ValueError(str(error)) from error


def _inside(text: str) -> str:
    parts = Path(text).parts
    if text == ".":
        return text
    if not parts or "\0" in text or "\\" in text or Path(text).is_absolute() or ".." in parts:
        raise ValueError(f"{text!a} is not a place inside the sequence's folder")
    return text


def _file_name(text: str) -> str:
    if Path(text).name != text or text in (".", "..") or "\0" in text or "\\" in text:
        raise ValueError(f"{text!a} is no plain file name")
    return text


def _color(text: str) -> str:
    try:
        color_rgb(text)
    except FoldingError as error:
        raise ValueError(str(error)) from error
    return text


Index = Annotated[StrictInt, Field(ge=0, le=99_999_999)]
Color = Annotated[str, AfterValidator(_color)]
Place = Annotated[str, AfterValidator(_inside)]


FileName = Annotated[str, Field(min_length=1, max_length=255), AfterValidator(_file_name)]


class Manifest(BaseModel):
    """The contents of `keyframes.json`. Keyframes are indices of images, strictly increasing, or names of files in order.

    `moving` lists those keyframes of a film at which something still moves, since nothing rests there.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Annotated[str, AfterValidator(_plain)] | None = None
    frames: Place | None = None
    video: Place | None = None
    front_color: Color | None = None
    back_color: Color | None = None
    keyframes: Annotated[tuple[Index, ...] | tuple[FileName, ...], Field(min_length=1, max_length=10_000)]
    moving: Annotated[tuple[Index, ...], Field(max_length=10_000)] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The keyframes that are names of files; empty if they are indices."""
        return tuple(name for name in self.keyframes if isinstance(name, str))

    @property
    def indices(self) -> tuple[int, ...]:
        """The keyframes as indices; of names, their places from 1."""
        return tuple(k if isinstance(k, int) else place for place, k in enumerate(self.keyframes, start=1))

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.frames is not None and self.video is not None:
            raise ValueError("give either 'frames' (a folder of images) or 'video' (a file), not both")
        if self.names and self.video is not None:
            raise ValueError("keyframes of a video are numbers of its images, not names of files")
        if len(set(self.names)) < len(self.names):
            raise ValueError("a file is named twice among the keyframes")
        if strange := sorted(set(self.moving) - set(self.keyframes)):
            raise ValueError(f"'moving' lists {strange[0]}, which is no keyframe")
        for before, after in zip(self.indices, self.indices[1:], strict=False):
            if after <= before:
                raise ValueError(f"keyframes must increase, but {after} comes after {before}")
        return self


def read_manifest(folder: Path) -> Manifest:
    """The manifest of the sequence in `folder`; PhotoError, one sentence, for whatever is wrong with it."""
    if not folder.is_dir():
        raise PhotoError(
            f"there is no folder {folder}: give the folder that holds {FILE_NAME}",
            f"there is no folder {folder.name} any more: give another sequence",
        )
    path = folder / FILE_NAME
    if not path.is_file():
        raise PhotoError(f"the folder {folder.name} is no sequence: it has no {FILE_NAME}")
    try:
        return Manifest.model_validate(_json(path))
    except ValidationError as error:
        raise PhotoError(f"{folder.name}/{FILE_NAME}: {_sentence(error)}") from error


def _json(path: Path) -> object:
    if path.stat().st_size > MAX_MANIFEST_BYTES:
        raise PhotoError(
            f"{path.parent.name}/{FILE_NAME} is larger than {MAX_MANIFEST_BYTES // 10**6} MB: it is no manifest"
        )
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise PhotoError(
            f"{path.parent.name}/{FILE_NAME} is not JSON ({error}); put that right, or write it anew"
        ) from error
    except OSError as error:
        raise PhotoError(
            f"{path.parent.name}/{FILE_NAME} cannot be read: {error.strerror or error}"
        ) from error


_KEYS = "name, frames, video, front_color, back_color, keyframes, moving"
_SENTENCES = {
    "extra_forbidden": f"the key {{where!r}} is not known; known are {_KEYS}",
    "missing": "the key {where!r} is missing; write the indices of the keyframes, such as [4, 10, 15]",
    "too_short": "'keyframes' is empty; list at least one image",
    "int_type": "{where} is {value}, but keyframes are whole numbers: indices of images in the video",
    "model_type": f"it must hold an object with the keys {_KEYS}",
    "value_error": "{reason}",
}


def _sentence(error: ValidationError) -> str:
    """The first complaint of pydantic in plain words."""
    first = error.errors(include_url=False)[0]
    where = ".".join(
        str(part) for part in first["loc"] if "[" not in str(part)
    )  # not the kind of list it was read as
    reason = first.get("ctx", {}).get("error", first["msg"].lower())
    template = _SENTENCES.get(first["type"], "{where} is {value}: {reason}")
    return template.format(where=where, value=ascii(first["input"])[:60], reason=reason)
