"""Action plans as a model writes them in VLM-S and VLM-S-C."""

from folding_schemas.actions import Action
from pydantic import BaseModel, ConfigDict

from folding_client.roles.critic import FoldAnchor


class ActionPlan(BaseModel):
    """What a model answers: why, the actions of one step in order, and for a fold how to check it in the photo."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    reasoning: str = ""
    actions: list[Action]
    fold_anchor: FoldAnchor | None = None

    def classes(self) -> tuple[str, ...]:
        """The kinds of action in the plan, without the vertices it adds; "none" if nothing else is left."""
        kinds = dict.fromkeys(action.action for action in self.actions if action.action != "add_vertex")
        return tuple(kinds) or ("none",)
