"""A sheet as one HTML page for screens: steps flow in as many columns as fit; nothing is loaded from elsewhere."""

from collections.abc import Sequence
from html import escape

from folding_server.instructions.sheet_layout import SheetStep
from folding_server.instructions.sheet_svg import step_svg

STYLE = """
:root { color-scheme: light; }
body { margin: 2rem auto; max-width: 70rem; padding: 0 1rem; font: 1rem/1.4 "DejaVu Sans", Verdana, Arial, sans-serif; color: #1d1d1f; background: #fff; }
ol { list-style: none; margin: 0; padding: 0; display: grid; gap: 2rem; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); }
li { break-inside: avoid; }
figure { margin: 0; }
svg { width: 100%; height: auto; display: block; }
"""


def sheet_html(title: str, steps: Sequence[SheetStep], width: float, language: str = "en") -> str:
    """The page. ``width`` is that of the steps' drawings in points, ``language`` that of the words."""
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    items = "\n".join(
        f"<li><figure>{step_svg(step, width, with_words=False)}<figcaption>{escape(step.text)}</figcaption></figure></li>"
        for step in steps
    )
    return (
        f'<!doctype html>\n<html lang="{escape(language)}">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{escape(title)}</h1>\n"
        f"<ol>\n{items}\n</ol>\n</main>\n</body>\n</html>\n"
    )
