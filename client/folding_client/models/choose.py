"""From a model id on the command line to a model."""

from collections.abc import Callable, Iterable
from pathlib import Path

from folding_client.interrupts import UsageError
from folding_client.models.geometric import GeometricModel
from folding_client.models.model import Model
from folding_client.models.scripted import ScriptedModel, load_script
from folding_client.record.event_log import Event
from folding_client.settings import Settings

IDS = (
    "geometric, scripted:FILE, litellm/PROVIDER/MODEL such as litellm/gemini/gemini-3.1-pro-preview, or "
    "hybrid:PROVIDER/MODEL"
)


def make_model(spec: str, role: str, settings: Settings, note: Callable[[str, float], None]) -> Model:
    """The model of an id, for a role; ``note`` hears of retries. UsageError for an id that is none."""
    if spec == "geometric":
        return GeometricModel(consults=settings.role("critic") != "geometric")
    if spec.startswith("scripted:"):
        path = Path(spec.removeprefix("scripted:"))
        return ScriptedModel(spec, load_script(path, role))
    if spec.startswith("litellm/") and len(spec) > len("litellm/"):
        from folding_client.models.litellm_model import LitellmModel

        return LitellmModel(spec, settings, note)
    message = f"There is no model {spec!r}; the ids are {IDS}."
    raise UsageError(message)


def continued(model: Model, role: str, events: Iterable[Event]) -> bool:
    """Put a model that has a memory where it stood in a recorded run: a scripted one where the last step
    began, a geometric one with all that it has tried. False if it cannot be, since the record is not its own.
    """
    if isinstance(model, GeometricModel):
        return model.relive(events)
    if isinstance(model, ScriptedModel):
        model.position = _replies_before_the_last_step(role, events)
    return True


def _replies_before_the_last_step(role: str, events: Iterable[Event]) -> int:
    replies = before = 0
    for event in events:
        if event["kind"] == "step_started":
            before = replies
        replies += event["kind"] == "reply" and event["role"] == role
    return before
