"""How far layers may reach into each other: chosen so that what touches what does not hang on it."""

from collections.abc import Iterator

from folding_server.geometry.tolerance import TOLERANCE
from folding_server.simulator.foldability.constraints import Contacts
from folding_server.simulator.foldability.flat_faces import FlatFaces
from folding_server.simulator.foldability.near_contacts import HALVINGS

OTHER_TOLERANCES = (0.25, 3.0)
"""Times the chosen one: what is tried where that finds no order."""


def contacts_to_try(flat: FlatFaces) -> Iterator[Contacts]:
    """The contacts at the stable tolerance, then at those that are tried where it finds no order of the layers.

    The first tolerance is the simulator's, or twice what the faces disagree by if that is more. It is halved until twice
    in a row the same faces overlap, with as many equations: a coarse tolerance drops overlaps that are there, a fine one
    takes edges that should coincide for two. If nothing is stable, the first counts.
    """
    first = first_tolerance(flat)
    chosen = stable_contacts(flat, first)
    yield chosen
    for times in OTHER_TOLERANCES:
        yield Contacts(flat, times * chosen.tolerance)
    if chosen.tolerance != first:
        yield Contacts(flat, first)


def first_tolerance(flat: FlatFaces) -> float:
    """The simulator's tolerance, or twice what the faces disagree by if that is more."""
    return max(TOLERANCE, 2 * flat.spread)


def stable_contacts(flat: FlatFaces, first: float) -> Contacts:
    """The contacts at the coarsest of ``first``, its half, ... of which the next finer has the same."""
    coarsest = coarse = Contacts(flat, first)
    for _ in range(HALVINGS):
        fine = Contacts(flat, coarse.tolerance / 2, coarse)
        if fine.as_many(coarse):
            return coarse
        coarse = fine
    return coarsest
