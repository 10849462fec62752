"""The text of a crease pattern's file, in the encodings that origami programs have written."""

from pathlib import Path

from folding_server.errors import FoldingError

ENCODINGS = ("utf-8-sig", "cp932", "latin-1")
"""Tried in turn: UTF-8, Shift-JIS with what Windows adds, and Latin-1, which reads any bytes."""
BINARY_STARTS = (b"\xff\xd8\xff", b"\x89PNG", b"GIF8", b"%PDF", b"PK\x03\x04", b"\x1f\x8b")
"""How JPEG, PNG, GIF, PDF, zip and gzip files begin, which Latin-1 would read as text."""
BYTE_ORDER_MARKS = (b"\xff\xfe", b"\xfe\xff")
LARGEST_FILE = 200_000_000
"""Bytes; published crease patterns have up to three million."""


def pattern_text_in(path: Path) -> str:
    """The text of a file. FoldingError if it cannot be read, is too large, or holds no text."""
    advice = "give the path of a FOLD or .cp file"
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FoldingError(
                f"{path} is larger than {LARGEST_FILE:,} bytes, too large for a crease pattern; {advice}."
            )
        content = path.read_bytes()
    except OSError as error:
        raise FoldingError(f"{path} cannot be read ({error.strerror}); {advice}.") from error
    text = decoded(content)
    if text is None:
        raise FoldingError(f"{path} is not a text file; {advice}.")
    return text


def decoded(content: bytes) -> str | None:
    """Bytes as text: UTF-16 where they begin so or every other one is 0, else the first encoding that reads them."""
    if content.startswith(BINARY_STARTS):
        return None
    for encoding in (*_wide(content), *ENCODINGS):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        return None if "\0" in text else text
    return None


def _wide(content: bytes) -> tuple[str, ...]:
    if content.startswith(BYTE_ORDER_MARKS):
        return ("utf-16",)
    if content[:1] and content[1:2] == b"\0":
        return ("utf-16-le",)
    return ("utf-16-be",) if content[:1] == b"\0" else ()
