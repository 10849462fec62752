"""Building what works on a run, from its settings: models by role, critics, selector, agent."""

from dataclasses import dataclass, field

from folding_client.agent.context_compaction import ContextPolicy
from folding_client.agent.loop import Agent, AgentSettings
from folding_client.agent.tool_selection import PROPOSING
from folding_client.agent.toolbox import Toolbox
from folding_client.models.choose import make_model
from folding_client.models.model import Model
from folding_client.models.prices import Prices, pricing_of, read_prices
from folding_client.progress import Progress
from folding_client.protocol.acting import ACTIONS
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder
from folding_client.roles.critic import Critic, GeometricCritic, ModelCritic
from folding_client.roles.overview import GeometricOverview, ModelOverview, OverviewCritic
from folding_client.roles.role_client import RoleClient
from folding_client.roles.selector import GeometricSelector, ModelSelector, Selector
from folding_client.run_limits import UNLIMITED, SharedLimit, SpendingLimits, spending_limits
from folding_client.search.hybrid import HybridSolver
from folding_client.search.search_file import known_search
from folding_client.settings import ROLES, WITHOUT_ASKING, ModelRole, Settings
from folding_client.variants.few_shot import solved_examples
from folding_client.variants.vlm_cp import PatternPerStep
from folding_client.variants.vlm_s import PlanPerStep
from folding_client.variants.worker import Worker

CONNECTING = frozenset({"open_run", "get_run"})
"""The tools of the server without which there is no run."""
SAVING = frozenset(
    {
        "save_checkpoint",
        "restore_checkpoint",
        "get_checkpoint_state",
        "list_attempts",
        "commit_attempt",
        "export_state",
    }
)
"""The tools by which frames are saved and results written."""


@dataclass(frozen=True)
class RoleModels:
    """The models of a run by role, None where geometry does the work without a model, and what they may spend."""

    agent: Model
    critic: Model | None
    overview: Model | None
    selector: Model | None
    limits: SpendingLimits = UNLIMITED
    prices: Prices = field(default_factory=dict)

    def client(self, role: ModelRole, recorder: Recorder, limit: int | None = None) -> RoleClient:
        """Whoever asks the model of a role, at most ``limit`` times. The role has a model."""
        model: Model | None = getattr(self, role)
        assert model is not None, f"no model plays the {role}"
        pricing = pricing_of(model.name, self.prices)
        return RoleClient(role, model, recorder, limit, self.limits, pricing)


def make_role_models(settings: Settings, recorder: Recorder, shared: SharedLimit | None = None) -> RoleModels:
    """The models that the settings name, each where it stood if the run is resumed, within the limits of the run and one that
    it may share. UsageError for an unknown id.
    """
    return RoleModels(
        make_model("agent", settings, recorder),
        _asked("critic", settings, recorder),
        _asked("overview", settings, recorder),
        _asked("selector", settings, recorder),
        spending_limits(settings, shared),
        read_prices(settings.prices),
    )


def _asked(role: ModelRole, settings: Settings, recorder: Recorder) -> Model | None:
    """The model that plays a role, None if geometry does."""
    return None if settings.role(role) == "geometric" else make_model(role, settings, recorder)


def needed_tools(settings: Settings) -> frozenset[str]:
    """The tools of the server that the client calls for itself, or that a search does."""
    if settings.variant == "vlm-cp":
        return CONNECTING | {"view_frame"}
    needed = CONNECTING | SAVING | ACTIONS
    if settings.variant != "agent":
        needed |= {"get_current_state", "view_frame", "render_current"}
    if settings.hybrid or settings.model == "geometric":
        needed |= {"propose_actions", "compare_to_frame"}
    if settings.is_baseline:
        needed |= {"compare_to_frame", "get_current_state", "undo"}
    if "geometric" in {settings.role(role) for role in ROLES[1:]}:
        needed |= {"compare_to_frame"}
    return needed | ({"critic_grid"} if settings.role("critic") != "geometric" else frozenset())


def make_critic(role_models: RoleModels, server: ServerClient, recorder: Recorder) -> Critic:
    """The critic of a run: a model in that role, or geometry."""
    return (
        ModelCritic(role_models.client("critic", recorder)) if role_models.critic else GeometricCritic(server)
    )


def make_selector(role_models: RoleModels, server: ServerClient, recorder: Recorder) -> Selector:
    """The selector of a run: a model in that role, or geometry."""
    return (
        ModelSelector(role_models.client("selector", recorder), server)
        if role_models.selector
        else GeometricSelector(server)
    )


def make_worker(
    role_models: RoleModels,
    settings: Settings,
    server: ServerClient,
    recorder: Recorder,
    progress: Progress,
    colors: tuple[str, str],
) -> Worker:
    """What the settings' variant names, on a server whose run is open."""
    role_client = role_models.client("agent", recorder, settings.query_limit)
    examples = solved_examples(settings.variant) if settings.few_shot else ()
    match settings.variant:
        case "agent":
            return _agent(role_models, settings, server, recorder, progress, colors)
        case "vlm-cp":
            return PatternPerStep(role_client, server, recorder, progress, examples)
        case "vlm-s":
            return PlanPerStep(role_client, server, recorder, progress, examples=examples)
        case "vlm-s-c":
            return PlanPerStep(
                role_client,
                server,
                recorder,
                progress,
                make_critic(role_models, server, recorder),
                make_selector(role_models, server, recorder),
                examples,
            )


def _agent(
    role_models: RoleModels,
    settings: Settings,
    server: ServerClient,
    recorder: Recorder,
    progress: Progress,
    colors: tuple[str, str],
) -> Agent:
    overview: OverviewCritic = (
        ModelOverview(role_models.client("overview", recorder), colors)
        if role_models.overview
        else GeometricOverview(server)
    )
    policy = ContextPolicy(settings.keep_images, settings.keep_results, settings.full_descriptions)
    toolbox = Toolbox(
        server,
        make_critic(role_models, server, recorder),
        overview,
        recorder,
        colors,
        tools=settings.tool_set,
        policy=policy,
        also=PROPOSING if settings.hybrid else frozenset(),
        unseen=frozenset({"compare_to_frame"}) if settings.model == "search" else frozenset(),
    )
    role_client = role_models.client("agent", recorder, settings.query_limit)
    examples = solved_examples("agent") if settings.few_shot else ()
    agent_settings = AgentSettings(
        settings.failures_per_step, policy, examples, looks=settings.asked_model not in WITHOUT_ASKING
    )
    solver = HybridSolver(server, recorder, known_search(recorder)) if settings.hybrid else None
    selector = make_selector(role_models, server, recorder)
    return Agent(role_client, server, toolbox, selector, recorder, progress, agent_settings, solver)
