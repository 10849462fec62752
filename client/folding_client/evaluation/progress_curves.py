"""Curves of the scores along the sequences, as the paper draws them, in SVG."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, floor, log10

from folding_schemas.evaluation import MetricName, ProgressPoint

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Told apart with every kind of colour vision (Okabe and Ito); after them, lines are dashed."""
DASHES = ("none", "6 3", "2 3")
TITLES: dict[MetricName, str] = {
    "SIM": "Similarity (mean of TSS, GS, CS, FFS) ↑",
    "CPD": "Dissimilarity of crease patterns (CPD) ↓",
    "TSS": "Topology (TSS) ↑",
    "GS": "Geometry (GS) ↑",
    "CS": "Constraints (CS) ↑",
    "FFS": "Folded state (FFS) ↑",
}
"""The panels in their order; CV is 0 or 1 and says little as a curve."""
COLUMNS, WIDTH, HEIGHT = 2, 420, 270
LEFT, RIGHT, TOP, BOTTOM = 46, 24, 34, 44
"""Pixels of a panel, and between its frame and the axes."""
LEGEND_LINE = 20
ABOVE_LEGEND = 14
LEAST_TOP = 10.0
"""The lowest end of the axis of CPD, so that next to no dissimilarity looks like it: a vertex unmatched costs 30."""
CURVE_STYLE = (
    "text{font-family:system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;font-size:11px;fill:#333}"
    ".title{font-size:12.5px;font-weight:600;fill:#111}.grid{stroke:#e3e3e3}.axis{stroke:#888}"
    ".line{fill:none;stroke-width:2;stroke-linejoin:round}"
)


@dataclass(frozen=True)
class Curve:
    """A line of each panel: the label of a model and its points."""

    label: str
    points: Sequence[ProgressPoint]


@dataclass(frozen=True)
class _Scale:
    """From progress and score to pixels of a panel."""

    top: float

    def x(self, progress: float) -> float:
        """The column, in units of the picture, of a progress from 0 to 1."""
        return LEFT + progress * (WIDTH - LEFT - RIGHT)

    def y(self, score: float) -> float:
        """The row of a score, from 0 at the bottom."""
        return HEIGHT - BOTTOM - score / self.top * (HEIGHT - TOP - BOTTOM)


def curves_svg(curves: Sequence[Curve]) -> str:
    """A drawing with a panel for each metric, a line in it for each model."""
    rows = ceil(len(TITLES) / COLUMNS)
    legend = ABOVE_LEGEND + LEGEND_LINE * len(curves)
    width, height = COLUMNS * WIDTH, legend + rows * HEIGHT
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="Scores by share of the sequence"><style>{CURVE_STYLE}</style><rect width="100%" height="100%" fill="#fff"/>'
    )
    body = [*_legend(curves)]
    for index, metric in enumerate(TITLES):
        x, y = index % COLUMNS * WIDTH, legend + index // COLUMNS * HEIGHT
        body.append(f'<g transform="translate({x} {y})">{"".join(_panel(metric, curves))}</g>')
    return "\n".join([head, *body, "</svg>", ""])


def _look(index: int) -> str:
    color, dash = COLORS[index % len(COLORS)], DASHES[index // len(COLORS) % len(DASHES)]
    return f'stroke="{color}" stroke-dasharray="{dash}"'


def _legend(curves: Sequence[Curve]) -> Iterator[str]:
    for index, curve in enumerate(curves):
        y = ABOVE_LEGEND + LEGEND_LINE * index
        yield f'<line class="line" x1="{LEFT}" y1="{y}" x2="{LEFT + 26}" y2="{y}" {_look(index)}/>'
        yield f'<text x="{LEFT + 34}" y="{y + 4}">{escape(curve.label)}</text>'


def _panel(metric: MetricName, curves: Sequence[Curve]) -> Iterator[str]:
    """Title, grid with its numbers, and the lines."""
    scale = _Scale(_top(metric, curves))
    yield f'<text class="title" x="{LEFT}" y="{TOP - 14}">{escape(TITLES[metric])}</text>'
    for part in range(5):
        score = scale.top * part / 4
        y = scale.y(score)
        kind = "grid" if part else "axis"
        yield f'<line class="{kind}" x1="{LEFT}" y1="{y:.1f}" x2="{WIDTH - RIGHT}" y2="{y:.1f}"/>'
        yield f'<text x="{LEFT - 7}" y="{y + 4:.1f}" text-anchor="end">{score:g}</text>'
    for part in range(5):
        x = scale.x(part / 4)
        yield f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{25 * part} %</text>'
    middle = (LEFT + WIDTH - RIGHT) / 2
    yield f'<text x="{middle:.1f}" y="{HEIGHT - BOTTOM + 33}" text-anchor="middle">share of the sequence</text>'
    for index, curve in enumerate(curves):
        yield from _line(metric, curve, scale, index)


def _line(metric: MetricName, curve: Curve, scale: _Scale, index: int) -> Iterator[str]:
    points = [
        (scale.x(each.progress), scale.y(each.means[metric])) for each in curve.points if metric in each.means
    ]
    if points:
        placed = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        yield f'<polyline class="line" points="{placed}" {_look(index)}/>'
    color = COLORS[index % len(COLORS)]
    yield from (f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{color}"/>' for x, y in points)


def _top(metric: MetricName, curves: Sequence[Curve]) -> float:
    """Where an axis ends: at 1 for what is from 0 to 1, else at the next round number."""
    if metric != "CPD":
        return 1.0
    most = max((each.means.get(metric, 0.0) for curve in curves for each in curve.points), default=0.0)
    most = max(most, LEAST_TOP)
    power: float = 10.0 ** floor(log10(most))
    return next(step * power for step in (1, 1.2, 1.6, 2, 3, 4, 6, 8, 10) if step * power >= most)
