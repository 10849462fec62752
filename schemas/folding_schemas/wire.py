"""The base of every model on the wire."""

from pydantic import BaseModel, ConfigDict


class Wire(BaseModel):
    """A frozen record that refuses keys it does not know."""

    model_config = ConfigDict(extra="forbid", frozen=True)
