"""A folded state against a photo: how well it explains what is seen, and in words where it does not."""

from dataclasses import dataclass

import cv2
import numpy as np
from folding_schemas.results import Verdict

from folding_server.arrays import ByteMask, Float32s, Mask
from folding_server.simulator.paper import Paper
from folding_server.vision.discrepancies import (
    Discrepancy,
    box_about,
    discrepancies,
    place_of,
    thin_discrepancies,
)
from folding_server.vision.inner_lines import NO_LINES, LineMatch, match_lines, thick_core
from folding_server.vision.labels import BACK, FRONT, UNKNOWN, LabelImage, as_one_colour, is_paper
from folding_server.vision.raster import draw_paper
from folding_server.vision.registration.paper_alignment import Alignment, align_paper
from folding_server.vision.registration.scene import Scene
from folding_server.vision.seeing import Observation

MATCHING_AGREEMENT = 0.965
"""Share of agreeing pixels that a match needs."""
DIVERGED_AGREEMENT = 0.5
"""Share of agreeing pixels below which the state is another model altogether."""
MATCHING_WIDTH = 0.04
"""Sheet units that the widest disagreement of a match may measure across."""
MATCHING_OUTLINE = 0.02
"""Mean distance of the outlines of a match, in sheet units, at most."""
CUT_LIMIT = 0.05
"""Sheet units along which the paper may reach to the edge of a photo that still shows all of it, and share of it that may lie
beyond.
"""
CUT = "the paper reaches beyond the edge of the photo, so it shows only a part: use a photo that shows all of it"
HARDLY_ANY = 0.003
"""Area, in sheet units squared, below which a class counts as shown by neither photo nor diagram."""
MISPLACED_LINES = 0.3
"""Agreement of inner lines below which, if a long one is missing too, the layers lie in another way."""
MISSING_LENGTH = 0.3
"""Sheet units of one seen inner line from which it is long."""
MISSING = "the photo shows a crease or layer edge about {:.2f} long that the diagram lacks"
HIDDEN_LIMIT = 0.9
"""Share of the paper that something must hide for a photo to tell nothing."""
MOSTLY_HIDDEN = 0.5
"""Share of the paper that something must hide for it to be said first why nothing matches."""
HIDES_OR_CUT = "something hides {:.0%} of it, or the paper reaches beyond the edge of the photo: use a photo that shows all of it"
OUTLINE_OFF = "the outline is {:.3f} sheet units off on average; a match is off by {:g} at most"
HIDES = "something hides {:.0%} of the paper in the photo, so it tells nothing: look at another frame"
MOST_WORDS = 5
"""Sentences that are said of a comparison."""


@dataclass(frozen=True)
class Match:
    """The answer of :func:`compare`.

    ``iou`` has front, back and paper (only paper if the sides look alike); a class that neither photo nor
    diagram shows counts as 1. ``outline_distance`` is the mean symmetric distance of the silhouettes in sheet
    units, ``outline_worst`` its 95 % quantile; both are 1 if either shows no paper. ``predicted`` is the
    aligned label image. ``lines`` (-1 to 1) says how well the state explains creases and layer edges inside
    the paper, ``missing_lines`` which of them it lacks, ``longest_missing`` the length of the longest in
    sheet units, see :class:`folding_server.vision.inner_lines.LineMatch`. ``hidden`` is the share of the predicted
    paper that something hides in the photo: from HIDDEN_LIMIT on the verdict is never more than a MISMATCH either way.
    ``cut`` is along how much of its outline, in sheet units, the paper reaches to the edge of the photo, or which share of
    the predicted paper lies beyond it, whichever is more: from CUT_LIMIT on
    nothing is a MATCH, and neither is what has an outline further off than MATCHING_OUTLINE.
    """

    verdict: Verdict
    agreement: float
    iou: dict[str, float]
    outline_distance: float
    outline_worst: float
    alignment: Alignment
    discrepancies: tuple[Discrepancy, ...]
    predicted: LabelImage
    lines: float
    missing_lines: tuple[str, ...]
    longest_missing: float
    hidden: float = 0.0
    cut: float = 0.0

    @property
    def words(self) -> list[str]:
        """The largest discrepancies, one sentence each, regions first, largest first."""
        if self.hidden >= HIDDEN_LIMIT:
            return [HIDES.format(self.hidden)]
        if self.cut >= CUT_LIMIT:
            return [CUT, *(str(d) for d in self.discrepancies)][:MOST_WORDS]
        words = [*(str(d) for d in self.discrepancies), *self.missing_lines]
        if self.verdict != "MATCH" and self.hidden >= MOSTLY_HIDDEN:
            words.insert(0, HIDES_OR_CUT.format(self.hidden))
        if self.verdict != "MATCH" and not words:
            words.append(OUTLINE_OFF.format(self.outline_distance, MATCHING_OUTLINE))
        return words[:MOST_WORDS]


def compare(paper: Paper, seen: Observation) -> Match:
    """Compare a folded sheet with a photo after the best small motion."""
    scene = Scene(seen.grid, seen.labels, seen.two_coloured)
    alignment = align_paper(paper, scene, seen.scales)
    predicted = draw_paper(paper, seen.grid, alignment.motion)
    if not seen.two_coloured:
        predicted = as_one_colour(predicted)
    mean, worst = outline_distances(predicted, seen.labels, seen.grid.pixels_per_unit)
    found = discrepancies(predicted, seen.labels, seen.grid.pixels_per_unit)
    core = thick_core(
        is_paper(predicted) & (predicted == seen.labels), seen.grid.pixels_per_unit, seen.shaded
    )
    lines = match_lines(paper, alignment.motion, seen.edges, seen.grid, core, seen.sheet_lines)
    beyond = outside_share(predicted, seen.outside)
    hidden, cut = hidden_share(predicted, seen.labels) - beyond, max(seen.cut, beyond)
    tells = hidden < HIDDEN_LIMIT and cut < CUT_LIMIT and mean <= MATCHING_OUTLINE
    verdict = judge(alignment.agreement, found, lines)
    if (verdict == "MATCH" and not tells) or hidden >= HIDDEN_LIMIT:
        verdict = "MISMATCH"
    if verdict != "MATCH" and not found:
        found = thin_discrepancies(predicted, seen.labels, seen.grid.pixels_per_unit)
    where = box_about(is_paper(predicted) | is_paper(seen.labels))
    missing = tuple(f"{place_of(line, where)}: {MISSING.format(line[2])}" for line in lines.missing)
    iou = class_iou(predicted, seen)
    return Match(
        verdict,
        alignment.agreement,
        iou,
        mean,
        worst,
        alignment,
        found,
        predicted,
        lines.agreement,
        missing,
        lines.longest_missing,
        hidden,
        cut,
    )


def hidden_share(predicted: LabelImage, seen: LabelImage) -> float:
    """The share of the predicted paper at which the photo shows something unknown; 0 if none is predicted."""
    paper = is_paper(predicted)
    return float((seen == UNKNOWN)[paper].mean()) if paper.any() else 0.0


def outside_share(predicted: LabelImage, outside: Mask | None) -> float:
    """The share of the predicted paper that lies beyond the edges of the photo; 0 if none is predicted."""
    paper = is_paper(predicted)
    return float(outside[paper].mean()) if outside is not None and paper.any() else 0.0


def judge(agreement: float, found: tuple[Discrepancy, ...], lines: LineMatch = NO_LINES) -> Verdict:
    """The verdict for an agreement, the regions that disagree, and how well inner lines are explained."""
    if agreement < DIVERGED_AGREEMENT:
        return "EXTREME DIVERGENCE"
    widest = max((d.width for d in found), default=0.0)
    other_layers = lines.agreement < MISPLACED_LINES and lines.longest_missing >= MISSING_LENGTH
    matches = agreement >= MATCHING_AGREEMENT and widest <= MATCHING_WIDTH and not other_layers
    return "MATCH" if matches else "MISMATCH"


def class_iou(predicted: LabelImage, seen: Observation) -> dict[str, float]:
    """Intersection over union by class where the photo's class is known."""
    known = seen.labels != UNKNOWN
    smallest = max(1.0, HARDLY_ANY * seen.grid.pixels_per_unit**2)
    result = {"paper": _iou(is_paper(predicted) & known, is_paper(seen.labels), smallest)}
    if seen.two_coloured:
        for name, value in (("front", FRONT), ("back", BACK)):
            result[name] = _iou((predicted == value) & known, seen.labels == value, smallest)
    return result


def _iou(first: Mask, second: Mask, smallest: float) -> float:
    union = int(np.count_nonzero(first | second))
    return int(np.count_nonzero(first & second)) / union if union >= smallest else 1.0


def outline_distances(predicted: LabelImage, seen: LabelImage, pixels_per_unit: float) -> tuple[float, float]:
    """Mean and 95 % quantile of the distance between two silhouettes, both ways, in sheet units.

    Outline that lies at something unknown is left out.
    """
    hidden = cv2.dilate((seen == UNKNOWN).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    first, second = (_outline(is_paper(labels).astype(np.uint8)) for labels in (predicted, seen))
    if not (first & ~hidden).any() or not (second & ~hidden).any():
        return 1.0, 1.0
    there = _distance_to(second | hidden)[first & ~hidden]
    back = _distance_to(first | hidden)[second & ~hidden]
    both = np.concatenate([there, back]) / pixels_per_unit
    return float(both.mean()), float(np.quantile(both, 0.95))


def _outline(mask: ByteMask) -> Mask:
    """The pixels of a mask that touch its outside."""
    return np.asarray((mask > 0) & (cv2.erode(mask, np.ones((3, 3), np.uint8)) == 0))


def _distance_to(mask: Mask) -> Float32s:
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
