"""What interrupts a run, as a tree. Each branch has one catcher, and each message says what to do next.

Interrupt
├── NothingCalled        a reply without a tool call: the model is nudged, the third time rewound
├── CallRefused          a call that cannot be sent: the reason goes back to the model as the call's result
├── ToolRefused          the server refused a call of the client's own: where nothing else can be done, a clean stop
├── ConnectionLost       the server went away before it answered: it is started again and asked again
├── StepOver             a frame was saved: the next step starts from a fresh context
├── AttemptsUsedUp       the frame's budget is spent: the selector picks among the attempts
├── StepFailed           the step goes back to its checkpoint and starts again; counted
│   ├── ContextExceeded  the conversation is longer than the model takes; twice in a row, the run stops
│   ├── ReplyCutOff      the reply ran into its token limit
│   ├── ReplyEmpty       the reply holds neither text nor a tool call
│   └── ReplyUnreadable  the reply cannot be parsed
├── RunStopped           a clean stop: the run folder is complete and resumable
│   ├── QueriesUsedUp    the limit of queries for a sequence is reached
│   ├── LimitReached     the limit of cost, tokens or time for a sequence is reached
│   ├── StepHopeless     one step failed again and again
│   ├── ProviderDown     the model's provider did not answer after several tries
│   ├── ProviderRefused  the provider refuses the key, the model or the request: trying again is useless
│   ├── ScriptEnded      a scripted model has no reply left
│   └── ServerGone       the folding server died twice in a row, or does not start
└── UsageError           the command cannot be carried out as given
"""

from folding_client.messages import NO_USAGE, Usage


class Interrupt(Exception):
    """Anything that takes the loop out of query, execute, append."""


class NothingCalled(Interrupt):
    """The reply has text and no tool call."""


class CallRefused(Interrupt):
    """The call names no tool, or its arguments do not fit the tool's schema."""


class ToolRefused(Interrupt):
    """The server answered a call of the client's own with an error; the message is the server's."""


class ConnectionLost(Interrupt):
    """The server went away before it answered."""


class StepOver(Interrupt):
    """A checkpoint was saved by whoever ``by`` names; ``complete`` says that no frame is left."""

    def __init__(self, frame: int, *, complete: bool, by: str) -> None:
        super().__init__(f"frame {frame} is saved")
        self.frame = frame
        self.complete = complete
        self.by = by


class AttemptsUsedUp(Interrupt):
    """No attempt is left for ``frame``."""

    def __init__(self, frame: int) -> None:
        super().__init__(f"the attempts for frame {frame} are used up")
        self.frame = frame


class StepFailed(Interrupt):
    """The step cannot go on from here."""


class ContextExceeded(StepFailed):
    """The conversation is longer than the model takes, without its older pictures too."""


class ReplyCutOff(StepFailed):
    """The reply ended at its token limit, so nothing in it can be trusted."""


class ReplyEmpty(StepFailed):
    """The reply holds neither text nor a tool call."""


class ReplyUnreadable(StepFailed):
    """The provider or the client could not parse the reply; ``usage`` is what it cost all the same, ``text`` what it
    says, if anything.
    """

    def __init__(self, reason: str, usage: Usage = NO_USAGE, text: str = "") -> None:
        super().__init__(reason)
        self.usage = usage
        self.text = text


class RunStopped(Interrupt):
    """The run ends here, whole and resumable."""


class QueriesUsedUp(RunStopped):
    """The limit of queries for a sequence is reached."""


class LimitReached(RunStopped):
    """The limit of cost, tokens or time for a sequence is reached."""


class StepHopeless(RunStopped):
    """One step failed as often as the settings allow."""


class ProviderDown(RunStopped):
    """The provider did not answer within the retries allowed."""


class ProviderRefused(RunStopped):
    """The provider refuses this request however often it is sent."""


class ScriptEnded(RunStopped):
    """The scripted model has no reply left for its role."""


class ServerGone(RunStopped):
    """The folding server cannot be reached."""


class UsageError(Interrupt):
    """The command cannot be carried out as given; one sentence says why and what to do."""
