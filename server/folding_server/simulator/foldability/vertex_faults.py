"""The vertices of a crease pattern around which the paper does not fold flat, whatever lies beyond."""

from folding_server.simulator.foldability.big_little_big import big_little_big
from folding_server.simulator.foldability.fault import Fault
from folding_server.simulator.foldability.local import OFF, longer_side
from folding_server.simulator.foldability.pattern import CreasePattern
from folding_server.simulator.foldability.sectors import VertexSectors, sectors_around
from folding_server.simulator.foldability.single_vertex import sector_stack, tolerances

FEWEST_CREASES = 2
"""Creases at a vertex below which any letters fold flat."""


def unfoldable_vertices(pattern: CreasePattern) -> list[Fault]:
    """The vertices around which the paper cannot be folded flat with these letters; of a pattern of which every vertex obeys
    Maekawa and Kawasaki. Those at which big-little-big fails say how, and come first.
    """
    off = OFF * longer_side(pattern)
    alone = [
        _fault(pattern, each) for each in sectors_around(pattern, FEWEST_CREASES) if not _foldable(each, off)
    ]
    if not alone:
        return []
    known = {fault.vertices for fault in alone}
    explained = [fault for fault in big_little_big(pattern) if fault.vertices in known]
    return explained + [
        fault for fault in alone if fault.vertices not in {each.vertices for each in explained}
    ]


def _foldable(around: VertexSectors, off: float) -> bool:
    """Whether some tolerance of angles finds a way; coordinates may be off by ``off``."""
    return any(sector_stack(around, equal) is not None for equal in tolerances(off / around.shortest))


def _fault(pattern: CreasePattern, around: VertexSectors) -> Fault:
    mountains, valleys, free = (around.letters.count(letter) for letter in "MVU")
    where = "" if around.closed else " at the edge of the sheet"
    without = f" and {free} without direction" if free else ""
    detail = (
        f"The {len(around.letters)} creases that meet here{where}, {mountains} mountains and {valleys} valleys{without}, cannot be "
        "folded flat in this order even by themselves."
    )
    return Fault(
        "Single-vertex folding", detail, (pattern.name(around.vertex),), (pattern.place(around.vertex),)
    )
