"""Building what works on a run, from its settings: models by role, critics, selector, agent."""

from dataclasses import dataclass
from functools import partial

from folding_client.agent.loop import Agent, Habits
from folding_client.agent.offer import PROPOSING
from folding_client.agent.savings import Kept
from folding_client.agent.solver import Solver
from folding_client.agent.toolbox import Toolbox
from folding_client.critic import Critic, GeometricCritic, ModelCritic
from folding_client.models.base import Model
from folding_client.models.choose import continued, make_model
from folding_client.overview import GeometricOverview, ModelOverview, OverviewCritic
from folding_client.progress import Progress
from folding_client.record.events import read_events
from folding_client.record.recorder import Recorder
from folding_client.selector import GeometricSelector, ModelSelector, Selector
from folding_client.server import FoldingServer
from folding_client.settings import Role, Settings
from folding_client.variants.few_shot import solved_examples
from folding_client.variants.vlm_cp import PatternPerStep
from folding_client.variants.vlm_s import PlanPerStep
from folding_client.variants.worker import Worker
from folding_client.voice import Voice


@dataclass(frozen=True)
class Cast:
    """The models of a run by role; None where geometry does the work without a model."""

    agent: Model
    critic: Model | None
    overview: Model | None
    selector: Model | None


def make_cast(settings: Settings, recorder: Recorder) -> Cast:
    """The models that the settings name, each where it stood if the run is resumed. UsageError for an unknown
    id.
    """
    return Cast(
        _made("agent", settings, recorder),
        _asked("critic", settings, recorder),
        _asked("overview", settings, recorder),
        _asked("selector", settings, recorder),
    )


def _asked(role: Role, settings: Settings, recorder: Recorder) -> Model | None:
    """The model that plays a role, None if geometry does."""
    return None if settings.role(role) == "geometric" else _made(role, settings, recorder)


def _made(role: Role, settings: Settings, recorder: Recorder) -> Model:
    model = make_model(settings.role(role), role, settings, partial(_note_retry, recorder, role))
    if not continued(model, role, read_events(recorder.folder.events)):
        recorder.event("memory_lost", role=role, reason="another version of the model made this record")
    return model


def _note_retry(recorder: Recorder, role: Role, reason: str, seconds: float) -> None:
    recorder.event("retry", role=role, reason=reason, wait=round(seconds, 3))


def make_critic(cast: Cast, server: FoldingServer, recorder: Recorder) -> Critic:
    """The critic of a cast."""
    return ModelCritic(Voice("critic", cast.critic, recorder)) if cast.critic else GeometricCritic(server)


def make_selector(cast: Cast, server: FoldingServer, recorder: Recorder) -> Selector:
    """The selector of a cast."""
    return (
        ModelSelector(Voice("selector", cast.selector, recorder), server)
        if cast.selector
        else GeometricSelector(server)
    )


def make_worker(
    cast: Cast,
    settings: Settings,
    server: FoldingServer,
    recorder: Recorder,
    progress: Progress,
    colors: tuple[str, str],
) -> Worker:
    """What the settings' variant names, on a server whose run is open."""
    voice = Voice("agent", cast.agent, recorder, settings.max_queries)
    examples = solved_examples(settings.variant) if settings.few_shot else ()
    match settings.variant:
        case "agent":
            return _agent(cast, settings, server, recorder, progress, colors)
        case "vlm-cp":
            return PatternPerStep(voice, server, recorder, progress, examples)
        case "vlm-s":
            return PlanPerStep(voice, server, recorder, progress, examples=examples)
        case "vlm-s-c":
            return PlanPerStep(
                voice,
                server,
                recorder,
                progress,
                make_critic(cast, server, recorder),
                make_selector(cast, server, recorder),
                examples,
            )


def _agent(
    cast: Cast,
    settings: Settings,
    server: FoldingServer,
    recorder: Recorder,
    progress: Progress,
    colors: tuple[str, str],
) -> Agent:
    overview: OverviewCritic = (
        ModelOverview(Voice("overview", cast.overview, recorder))
        if cast.overview
        else GeometricOverview(server)
    )
    kept = Kept(settings.keep_images, settings.keep_results, settings.full_descriptions)
    toolbox = Toolbox(
        server,
        make_critic(cast, server, recorder),
        overview,
        recorder,
        colors,
        tools=settings.tool_set,
        kept=kept,
        also=PROPOSING if settings.hybrid else frozenset(),
    )
    voice = Voice("agent", cast.agent, recorder, settings.max_queries)
    examples = solved_examples("agent") if settings.few_shot else ()
    habits = Habits(settings.failures_per_step, kept, examples)
    solver = Solver(server, recorder) if settings.hybrid else None
    selector = make_selector(cast, server, recorder)
    return Agent(voice, server, toolbox, selector, recorder, progress, habits, solver)
