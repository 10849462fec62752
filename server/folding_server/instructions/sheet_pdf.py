"""A sheet as PDF, by reportlab: vectors throughout, with the fonts of the diagrams in it.

Japanese is set in a font that readers of PDF bring (Adobe-Japan1), since the packaged fonts do not have it.
"""

from collections.abc import Iterable
from functools import cache
from io import BytesIO
from itertools import groupby
from typing import TYPE_CHECKING

from folding_server.diagram.rasterise import COVERED
from folding_server.instructions.lettering import font_file, text_width
from folding_server.instructions.marks import Drawn, DrawnPath, DrawnPhoto, DrawnText
from folding_server.instructions.sheet_layout import InstructionSheet, all_drawn

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

REGULAR, BOLD, JAPANESE = "DejaVuSans", "DejaVuSans-Bold", "HeiseiKakuGo-W5"
ROUND, BUTT = 1, 0
"""Caps and joins of lines as PDF numbers them (ISO 32000-1, 8.4.3.3)."""


def sheet_pdf(sheet: InstructionSheet) -> bytes:
    """The file, the same for the same sheet."""
    from reportlab.pdfgen.canvas import Canvas

    _register_fonts()
    file = BytesIO()
    canvas = Canvas(file, invariant=1, pageCompression=1)
    canvas.setTitle(sheet.title)
    canvas.setSubject("Folding instructions")
    for page in sheet.pages:
        canvas.setPageSize((page.width, page.height))
        for drawn in all_drawn(page):
            _put(canvas, drawn, page.height)
        canvas.showPage()
    canvas.save()
    return file.getvalue()


@cache
def _register_fonts() -> None:
    from reportlab.pdfbase.cidfonts import UnicodeCIDFont
    from reportlab.pdfbase.pdfmetrics import registerFont
    from reportlab.pdfbase.ttfonts import TTFont

    registerFont(TTFont(REGULAR, str(font_file(bold=False))))
    registerFont(TTFont(BOLD, str(font_file(bold=True))))
    registerFont(UnicodeCIDFont(JAPANESE))


def _put(canvas: "Canvas", drawn: Drawn, height: float) -> None:
    """Draw one thing; the y of PDF points up."""
    if isinstance(drawn, DrawnText):
        _put_text(canvas, drawn, height)
    elif isinstance(drawn, DrawnPhoto):
        from reportlab.lib.utils import ImageReader

        left, top, right, bottom = drawn.box
        canvas.drawImage(ImageReader(BytesIO(drawn.jpeg)), left, height - bottom, right - left, bottom - top)
    else:
        _put_path(canvas, drawn, height)


def _put_text(canvas: "Canvas", drawn: DrawnText, height: float) -> None:
    canvas.setFillColor(drawn.ink)
    x = drawn.at[0] - {"start": 0.0, "middle": 0.5, "end": 1.0}[drawn.anchor] * text_width(
        drawn.text, drawn.size, bold=drawn.bold
    )
    for font, piece in _by_font(drawn.text, BOLD if drawn.bold else REGULAR):
        canvas.setFont(font, drawn.size)
        canvas.drawString(x, height - drawn.at[1], piece)
        x += text_width(piece, drawn.size, bold=drawn.bold)


def _by_font(text: str, font: str) -> Iterable[tuple[str, str]]:
    """The pieces of a text, each with a font that has its letters."""
    for covered, letters in groupby(text, lambda letter: letter <= COVERED):
        yield font if covered else JAPANESE, "".join(letters)


def _put_path(canvas: "Canvas", drawn: DrawnPath, height: float) -> None:
    path = canvas.beginPath()
    for segment in drawn.segments:
        ends = [(x, height - y) for x, y in segment]
        if len(ends) == 1:
            path.moveTo(*ends[0])
        elif len(ends) == 2:
            path.lineTo(*ends[1])
        else:
            path.curveTo(*ends[1], *ends[2], *ends[3])
    if drawn.closed:
        path.close()
    if drawn.stroke:
        canvas.setStrokeColor(drawn.stroke)
        canvas.setLineWidth(drawn.width)
    canvas.setLineJoin(ROUND)
    canvas.setLineCap(BUTT if drawn.dashes else ROUND)
    canvas.setDash(*((list(drawn.dashes),) if drawn.dashes else ()))
    if drawn.fill:
        canvas.setFillColor(drawn.fill)
    canvas.drawPath(path, stroke=int(drawn.stroke is not None), fill=int(drawn.fill is not None), fillMode=0)
