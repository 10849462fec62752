"""What a picture in an answer shows: travels as ``_meta`` of its image content."""

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import ConfigDict, Field, ValidationError

from folding_schemas.wire import Wire

META_PREFIX = "foldingagent/"
"""What the keys of ours in a ``_meta`` begin with, as the protocol asks of whoever adds keys."""
PictureRole = Literal["photo", "diagram", "filmstrip", "overlay", "overview"]


def _meta_key(name: str) -> str:
    return META_PREFIX + name


class PictureMeta(Wire):
    """What a picture shows, in words, and of which frame; pictures with the same words show the same thing.

    ``frame`` is None where no single keyframe is shown, or that of the current state.
    """

    model_config = ConfigDict(alias_generator=_meta_key, populate_by_name=True)

    subject: str = Field(min_length=1)
    frame: int | None = None
    role: PictureRole

    def to_meta(self) -> dict[str, Any]:
        """The ``_meta`` of the image."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    @classmethod
    def from_meta(cls, meta: Mapping[str, Any] | None) -> Self | None:
        """What a ``_meta`` says, whatever else is in it; None if it does not say what the picture shows."""
        ours = {key: value for key, value in (meta or {}).items() if key.startswith(META_PREFIX)}
        try:
            return cls.model_validate(ours)
        except ValidationError:
            return None
