"""Pieces of SVG that all our pictures share."""

from collections.abc import Iterable
from html import escape

FONT = "DejaVu Sans, Verdana, Arial, sans-serif"


def svg_document(width: float, height: float, background: str, body: Iterable[str]) -> str:
    """A complete document of the given size in pixels with a plain background."""
    area = f'width="{width:g}" height="{height:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {area} viewBox="0 0 {width:g} {height:g}">'
    return "\n".join([head, f'<rect {area} fill="{background}"/>', *body, "</svg>\n"])


def svg_text(x: float, y: float, text: str, size: float, ink: str, extra: str = "") -> str:
    """A line of text with its baseline at (x, y); ``extra`` holds further attributes, such as the anchor."""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-family="{FONT}" font-size="{size:.1f}" fill="{ink}"'
        f"{' ' if extra else ''}{extra}>{escape(text)}</text>"
    )
