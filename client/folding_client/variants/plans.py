"""Action plans as a model writes them in VLM-S and VLM-S-C."""

from folding_schemas.actions import Action
from pydantic import BaseModel, ConfigDict


class ActionPlan(BaseModel):
    """What a model answers: why, and the actions of one step in order."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    reasoning: str = ""
    actions: list[Action]

    def classes(self) -> tuple[str, ...]:
        """The kinds of action in the plan, without the vertices it adds; "none" if nothing else is left."""
        kinds = dict.fromkeys(action.action for action in self.actions if action.action != "add_vertex")
        return tuple(kinds) or ("none",)
