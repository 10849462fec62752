"""From a model id on the command line to a model."""

from functools import partial
from pathlib import Path

from folding_client.baselines.breadth_first import SEARCH, SearchBounds, searched_frame
from folding_client.baselines.random_actions import RANDOM, random_frame
from folding_client.baselines.stepwise import StepwiseModel
from folding_client.models.geometric import GeometricModel
from folding_client.models.model import Model
from folding_client.models.requirements import require_known
from folding_client.models.scripted import SCRIPTED, ScriptedModel, load_script
from folding_client.record.event_log import Event, read_events
from folding_client.record.recorder import Recorder
from folding_client.search.search_file import known_search, write_search
from folding_client.settings import ModelRole, Settings


def make_model(role: ModelRole, settings: Settings, recorder: Recorder) -> Model:
    """The model that the settings name for a role. In a run that is resumed, a scripted one stands where the last
    step began, and a geometric one knows what it has tried. UsageError for an id that is none.
    """
    spec = settings.role(role)
    require_known(spec)
    if spec == "geometric":
        consults = settings.role("critic") != "geometric"
        keep = partial(write_search, recorder.folder)
        return GeometricModel(consults=consults, state=known_search(recorder), keep=keep)
    if spec == RANDOM:
        return StepwiseModel(spec, partial(random_frame, settings.seed))
    if spec == SEARCH:
        return StepwiseModel(spec, partial(searched_frame, _bounds(settings)))
    if spec.startswith(SCRIPTED):
        replies = load_script(Path(spec.removeprefix(SCRIPTED)), role)
        return ScriptedModel(spec, replies, partial(_replies_said, role, recorder.folder.events))
    from folding_client.models.litellm_model import LitellmModel

    model = LitellmModel(spec, settings, partial(_note_retry, recorder, role), role)
    recorder.about.setdefault("requests", {})[role] = model.sent
    recorder.event("request_options", role=role, model=spec, options=model.sent)
    return model


def _bounds(settings: Settings) -> SearchBounds:
    return SearchBounds(
        settings.search_depth, settings.search_width, settings.search_tries, settings.search_time
    )


def _note_retry(recorder: Recorder, role: ModelRole, reason: str, seconds: float) -> None:
    recorder.event("retry", role=role, reason=reason, wait=round(seconds, 3))


def _replies_said(role: ModelRole, events: Path) -> int:
    """Where a role stands in its script: a run that is resumed goes back to the beginning of the step that was cut short."""
    said = before_step = 0
    for event in read_events(events):
        if _parts_steps(event):
            before_step = said
        if event["kind"] == "resumed":
            said = before_step
        said += event["kind"] == "reply" and event["role"] == role
    return said


def _parts_steps(event: Event) -> bool:
    """Whether a step begins or ends with an event."""
    committed = event["kind"] == "result" and event["name"] == "commit_attempt" and not event["is_error"]
    return committed or event["kind"] in {"step_started", "step_over"}
