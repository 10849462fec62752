"""A sheet as SVG: every step a group that says its number and kind, every symbol of a class of its own."""

import base64
from collections.abc import Iterable
from html import escape

from folding_server.diagram.svg import svg_text
from folding_server.geometry.line import Point
from folding_server.instructions.marks import Drawn, DrawnPath, DrawnPhoto, DrawnText, Segment
from folding_server.instructions.sheet_layout import InstructionSheet, SheetPage, SheetStep, words_height

PAGE_GAP = 24.0
"""Points between pages that stand under each other."""
PIXELS_PER_POINT = 96 / 72
"""CSS has 96 pixels an inch, so that a sheet is printed as large as its paper."""


def sheet_svg(sheet: InstructionSheet) -> str:
    """The pages under each other in one picture, in points."""
    width = max(page.width for page in sheet.pages)
    height = sum(page.height for page in sheet.pages) + PAGE_GAP * (len(sheet.pages) - 1)
    body, y = list[str](), 0.0
    for page in sheet.pages:
        body += [f'<g transform="translate(0 {y:.2f})">', *_page_elements(page), "</g>"]
        y += page.height + PAGE_GAP
    return _document(width, height, sheet.title, body)


def step_svg(step: SheetStep, width: float, *, with_words: bool = True) -> str:
    """One step as a picture of its own, ``width`` points wide."""
    height = step.own_height + (words_height(len(step.lines)) if with_words else 0.0)
    group = _group(step, (0.0, 0.0), step.own_height, with_words=with_words)
    return _document(width, height, f"Step {step.number}. {step.text}", [group])


def _document(width: float, height: float, title: str, body: Iterable[str]) -> str:
    pixels = f'width="{width * PIXELS_PER_POINT:.2f}" height="{height * PIXELS_PER_POINT:.2f}"'
    area = f'{pixels} viewBox="0 0 {width:.2f} {height:.2f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" role="img" {area}><title>{escape(title)}</title>'
    ground = f'<rect width="{width:.2f}" height="{height:.2f}" fill="#ffffff"/>'
    return "\n".join([head, ground, *body, "</svg>\n"])


def _page_elements(page: SheetPage) -> Iterable[str]:
    yield f'<rect class="page" width="{page.width:.2f}" height="{page.height:.2f}" fill="#ffffff"/>'
    yield from map(svg_element, page.drawn)
    yield from (_group(placed.step, placed.at, placed.height) for placed in page.steps)


def _group(step: SheetStep, at: Point, height: float, *, with_words: bool = True) -> str:
    said = f'data-step="{step.number}" data-move="{step.kind}"'
    drawn = "\n".join(map(svg_element, step.drawn(height, with_words=with_words)))
    return f'<g class="step" {said} transform="translate({at[0]:.2f} {at[1]:.2f})">\n{drawn}\n</g>'


def svg_element(drawn: Drawn) -> str:
    """An element of what is drawn, its kind as its class."""
    if isinstance(drawn, DrawnText):
        weight = ' font-weight="bold"' if drawn.bold else ""
        extra = f'class="{drawn.kind}" text-anchor="{drawn.anchor}"{weight}'
        return svg_text(*drawn.at, drawn.text, drawn.size, drawn.ink, extra)
    if isinstance(drawn, DrawnPhoto):
        left, top, right, bottom = drawn.box
        data = base64.b64encode(drawn.jpeg).decode("ascii")
        place = f'x="{left:.2f}" y="{top:.2f}" width="{right - left:.2f}" height="{bottom - top:.2f}"'
        return f'<image class="{drawn.kind}" {place} href="data:image/jpeg;base64,{data}"/>'
    return _path(drawn)


def _path(drawn: DrawnPath) -> str:
    way = "".join(map(_command, drawn.segments)) + ("Z" if drawn.closed else "")
    stroke = (
        f'stroke="{drawn.stroke}" stroke-width="{drawn.width:g}" stroke-linejoin="round"'
        if drawn.stroke
        else ""
    )
    dashes = (
        f' stroke-dasharray="{" ".join(f"{d:g}" for d in drawn.dashes)}"'
        if drawn.dashes
        else ' stroke-linecap="round"'
    )
    return f'<path class="{drawn.kind}" d="{way}" fill="{drawn.fill or "none"}" fill-rule="evenodd" {stroke}{dashes}/>'


def _command(segment: Segment) -> str:
    letter = {1: "M", 2: "L", 4: "C"}[len(segment)]
    points = segment if len(segment) == 1 else segment[1:]
    return letter + " ".join(f"{x:.2f} {y:.2f}" for x, y in points)
