"""A batch as a YAML file says it: sequences, models, variants, seeds, and how they are done."""

from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from folding_client.batch.sequence_lists import iter_sequences
from folding_client.interrupts import UsageError
from folding_client.setting_files import read_mapping
from folding_client.settings import Settings, Variant

EXPERIMENT_SUFFIXES = frozenset({".yaml", ".yml"})


class Experiment(BaseModel):
    """What an experiment file may say. Paths are relative to the file; options of the command line win over it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    sequences: list[Path] = Field(min_length=1)
    models: list[str] = []
    variants: list[Variant] = []
    seeds: list[int] = []
    out: Path | None = None
    jobs: int | None = Field(default=None, ge=1)
    tries: int | None = Field(default=None, ge=1)
    max_batch_cost: float | None = Field(default=None, gt=0)
    dask: str | None = None
    settings: dict[str, Any] = {}

    @field_validator("sequences", "models", "variants", "seeds", mode="before")
    @classmethod
    def _listed(cls, given: object) -> object:
        """One value stands for a list of it."""
        return given if isinstance(given, list) else [given]


def read_experiment(file: Path) -> Experiment:
    """What a file says. UsageError if it cannot be read, or says something else."""
    given = {name.replace("-", "_"): value for name, value in read_mapping(file).items()}
    try:
        found = Experiment.model_validate(given)
    except ValidationError as error:
        raise _unfit(file, error) from error
    settings = {name.replace("-", "_"): value for name, value in found.settings.items()}
    try:
        Settings.model_validate(settings)
    except ValidationError as error:
        raise _unfit(file, error, "settings.") from error
    placed = [file.parent / path.expanduser() for path in found.sequences]
    out = None if found.out is None else file.parent / found.out.expanduser()
    return found.model_copy(update={"sequences": placed, "out": out, "settings": settings})


def experiment_sequences(experiment: Experiment) -> chain[Path]:
    """The sequences of all its folders and lists, one by one."""
    return chain.from_iterable(iter_sequences(path) for path in experiment.sequences)


def _unfit(file: Path, error: ValidationError, part: str = "") -> UsageError:
    first = error.errors()[0]
    name = part + ".".join(map(str, first["loc"]))
    known = Settings.model_fields if part else Experiment.model_fields
    if first["type"] == "extra_forbidden":
        return UsageError(f"{file} gives {name}, which is not known; it may give {', '.join(known)}.")
    if first["type"] == "missing":
        return UsageError(f"{file} names no {name}; give a folder of sequences, or a list of them.")
    why = first["msg"].removeprefix("Value error, ")
    return UsageError(f"{name.rstrip('.')} in {file} cannot be {first['input']!r}: {why}.")
