"""What a run is asked to do, as one frozen value built at the edge."""

import re
from typing import Any, Literal

from folding_schemas.attempt_limits import MOST_ATTEMPTS
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from folding_client.models.retries import RetryPolicy

ToolSet = Literal["paper", "standard", "all"]
Variant = Literal["agent", "vlm-cp", "vlm-s", "vlm-s-c"]
ModelRole = Literal["agent", "critic", "overview", "selector"]
ROLES: tuple[ModelRole, ...] = ("agent", "critic", "overview", "selector")

HYBRID = "hybrid:"
"""What ids of models begin with that are asked only where the geometric solver does not see clearly."""
WITHOUT_ASKING = frozenset({"geometric", "random", "search"})
"""The models that ask nobody: the geometric solver and two baselines."""
_BASELINES = WITHOUT_ASKING - {"geometric"}
LEAST_THINKING = 1024
"""The smallest budget that providers take."""
_DURATION = re.compile(r"(\d+(?:\.\d*)?) ?([smh]?)")
_SECONDS = {"": 1, "s": 1, "m": 60, "h": 3600}


class Settings(BaseModel):
    """Everything that shapes a run beside its sequence. Critic, overview critic and selector default to the
    kind of the agent: geometric for the models that ask nobody, else the agent's own model (paper, section
    "Implementation Details").
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    model: str = "geometric"
    critic: str | None = None
    overview: str | None = None
    selector: str | None = None
    variant: Variant = "agent"
    few_shot: bool = False
    seed: int = 0
    attempts: int | None = Field(default=None, ge=1, le=MOST_ATTEMPTS)
    tools: ToolSet | None = None
    keep_images: bool = False
    keep_results: bool = False
    full_descriptions: bool = False
    max_cost: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    max_tokens_total: int | None = Field(default=None, ge=1)
    max_time: float | None = Field(default=None, gt=0)
    prices: str | None = None
    max_queries: int = Field(default=300, ge=1)
    thinking_budget: int = Field(default=8192, ge=0)
    max_tokens: int = Field(default=32768, ge=1)
    failures_per_step: int = Field(default=10, ge=1)
    timeout: float = Field(default=600.0, gt=0, allow_inf_nan=False)
    search_depth: int = Field(default=2, ge=1)
    search_width: int = Field(default=4, ge=1)
    search_tries: int = Field(default=300, ge=1)
    search_time: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    api_base: str | None = None
    server_url: str | None = None
    retries: RetryPolicy = RetryPolicy()
    max_wait: float | None = Field(default=None, ge=0, allow_inf_nan=False)

    @field_validator("retries", mode="before")
    @classmethod
    def _tries_of(cls, given: object) -> object:
        """A number is how often a query is sent again after its first try."""
        return {"tries": given + 1} if isinstance(given, int) else given

    @model_validator(mode="after")
    def _is_no_hybrid_without_tools(self) -> "Settings":
        if role := next((role for role in ROLES[1:] if (getattr(self, role) or "").startswith(HYBRID)), None):
            message = f"--{role} cannot be a hybrid; give it geometric, or the model alone"
            raise ValueError(message)
        if role := next((role for role in ROLES[1:] if getattr(self, role) in _BASELINES), None):
            message = f"--{role} cannot be a baseline; give it geometric, or a language model"
            raise ValueError(message)
        if (self.hybrid or self.is_baseline) and self.variant != "agent":
            message = (
                f"{self.model} works as an agent; leave out --variant {self.variant}, or name another model"
            )
            raise ValueError(message)
        return self

    @field_validator("max_time", "search_time", mode="before")
    @classmethod
    def _in_seconds(cls, given: object) -> object:
        """Text is a number with a unit."""
        if not isinstance(given, str):
            return given
        found = _DURATION.fullmatch(given.strip())
        if found is None:
            message = "give a time such as 90s, 15m or 2h"
            raise ValueError(message)
        return float(found[1]) * _SECONDS[found[2]]

    @field_validator("api_base", "server_url")
    @classmethod
    def _is_of_the_web(cls, given: str | None) -> str | None:
        if given is not None and not given.startswith(("http://", "https://")):
            message = "give an address that begins with http:// or https://"
            raise ValueError(message)
        return given

    @model_validator(mode="after")
    def _leaves_room_to_answer(self) -> "Settings":
        if 0 < self.thinking_budget < LEAST_THINKING:
            message = (
                f"A thinking budget of {self.thinking_budget} tokens is not possible: give 0, or {LEAST_THINKING} "
                "and more"
            )
            raise ValueError(message)
        if self.thinking_budget >= self.max_tokens and "thinking_budget" in self.model_fields_set:
            message = (
                f"A thinking budget of {self.thinking_budget} tokens leaves nothing of the {self.max_tokens} that a "
                "reply may have: give less"
            )
            raise ValueError(message)
        return self

    @property
    def retry_policy(self) -> RetryPolicy:
        """The policy of ``retries``, which waits no longer than ``max_wait`` where that is given."""
        longest = {} if self.max_wait is None else {"longest_wait": self.max_wait}
        return self.retries.model_copy(update=longest)

    def role(self, role: ModelRole) -> str:
        """The model id for a role."""
        if role == "agent":
            return self.asked_model
        by_itself = "geometric" if self.asked_model in WITHOUT_ASKING else self.asked_model
        return getattr(self, role) or by_itself

    @property
    def hybrid(self) -> bool:
        """Whether the geometric solver works before the model."""
        return self.model.startswith(HYBRID)

    @property
    def query_limit(self) -> int | None:
        """The most queries of the agent. A search counts comparisons, so that it has a limit only if one is given."""
        limited = self.model != "search" or "max_queries" in self.model_fields_set
        return self.max_queries if limited else None

    @property
    def is_baseline(self) -> bool:
        """Whether no photo is explained: actions are drawn, or searched through."""
        return self.model in _BASELINES

    @property
    def asked_model(self) -> str:
        """The model that is asked: that behind a hybrid, which is a litellm id unless it says otherwise."""
        behind = self.model.removeprefix(HYBRID)
        known = not self.hybrid or behind.startswith(("litellm/", "scripted:"))
        return behind if known else f"litellm/{behind}"

    @property
    def tool_set(self) -> ToolSet:
        """The tools that the model is offered: the standard ones if it is a language model, else all."""
        return self.tools or ("standard" if self.asked_model.startswith("litellm/") else "all")

    def described(self) -> dict[str, dict[str, Any]]:
        """The settings as ``run.json`` states them: those given, and those that defaulted."""
        values = self.model_dump(mode="json")
        given = {name: values[name] for name in values if name in self.model_fields_set}
        return {"given": given, "defaulted": {name: values[name] for name in values if name not in given}}
