"""The text of a file that the user named."""

from pathlib import Path

from folding_server.errors import FoldingError


def text_in(path: Path, advice: str) -> str:
    """The text of a file, in UTF-8. FoldingError, which ends in the advice, if it is no text or cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FoldingError(f"{path} cannot be read ({error.strerror}); {advice}.") from error
    except UnicodeDecodeError as error:
        raise FoldingError(f"{path} is not a text file; {advice}.") from error
