"""The errors a user can cause, as a tree. Each message is one plain sentence that says what to do next.

FoldingError
├── ActionRefused      the simulator cannot do this to this paper
├── AddressError       this address cannot be served on
├── PhotoError         an image or a sequence cannot be used
├── ProgramError       a program or an interchange file cannot be read
├── RunError           a run, checkpoint or attempt does not allow this
├── SettingsRefused    a host's configuration file cannot be changed without breaking it (install/settings_text.py)
└── TokenFileError     a token file cannot be used (mcp/auth.py)
"""


class FoldingError(Exception):
    """A mistake the caller can mend; the message is shown as it stands.

    ``elsewhere`` is what callers on other machines are told instead, where the message names a place of this one.
    """

    def __init__(self, message: str = "", elsewhere: str | None = None) -> None:
        super().__init__(message)
        self.elsewhere = message if elsewhere is None else elsewhere


class ActionRefused(FoldingError):
    """The action is impossible on this paper; the paper is as it was."""


class AddressError(FoldingError):
    """An address that cannot be served on."""


class PhotoError(FoldingError):
    """A photo, video or sequence folder cannot be used."""


class ProgramError(FoldingError):
    """A program or interchange file cannot be read."""


class RunError(FoldingError):
    """The run's history does not allow this."""
