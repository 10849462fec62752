"""From a model id on the command line to a model."""

from collections.abc import Iterable
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from folding_client.interrupts import UsageError
from folding_client.models.geometric import GeometricModel
from folding_client.models.model import Model
from folding_client.models.scripted import ScriptedModel, load_script
from folding_client.record.event_log import Event, read_events
from folding_client.record.recorder import Recorder
from folding_client.search.search_file import known_search, write_search
from folding_client.settings import ModelRole, Settings

IDS = (
    "geometric, scripted:FILE, litellm/PROVIDER/MODEL such as litellm/gemini/gemini-3.1-pro-preview, or "
    "hybrid:PROVIDER/MODEL"
)


def make_model(role: ModelRole, settings: Settings, recorder: Recorder) -> Model:
    """The model that the settings name for a role. In a run that is resumed, a scripted one stands where the last
    step began, and a geometric one knows what it has tried. UsageError for an id that is none.
    """
    spec = settings.role(role)
    if spec == "geometric":
        consults = settings.role("critic") != "geometric"
        keep = partial(write_search, recorder.folder)
        return GeometricModel(consults=consults, state=known_search(recorder), keep=keep)
    if spec.startswith("scripted:"):
        replies = load_script(Path(spec.removeprefix("scripted:")), role)
        said = _replies_before_the_last_step(role, read_events(recorder.folder.events))
        return ScriptedModel(spec, replies, said)
    if spec.startswith("litellm/") and len(spec) > len("litellm/"):
        from folding_client.models.litellm_model import LitellmModel

        if find_spec("litellm") is None:
            message = (
                f"The model {spec!r} needs litellm, which is not installed; install it with "
                "pip install 'foldingagent-mcp[agent]', or use the model geometric."
            )
            raise UsageError(message)
        model = LitellmModel(spec, settings, partial(_note_retry, recorder, role))
        recorder.about.setdefault("requests", {})[role] = model.sent
        recorder.event("request_options", role=role, model=spec, options=model.sent)
        return model
    message = f"There is no model {spec!r}; the ids are {IDS}."
    raise UsageError(message)


def _note_retry(recorder: Recorder, role: ModelRole, reason: str, seconds: float) -> None:
    recorder.event("retry", role=role, reason=reason, wait=round(seconds, 3))


def _replies_before_the_last_step(role: ModelRole, events: Iterable[Event]) -> int:
    replies = before = 0
    for event in events:
        if event["kind"] == "step_started":
            before = replies
        replies += event["kind"] == "reply" and event["role"] == role
    return before
