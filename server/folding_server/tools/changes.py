"""What an action did to the paper, read off the papers before and after it."""

from typing import NamedTuple

from folding_server.simulator import Paper, moved_faces


class Change(NamedTuple):
    """Ids that are new, and the faces (of the paper after) that lie elsewhere than before."""

    new_vertices: list[int]
    new_faces: list[int]
    moved_faces: list[int]


def change(before: Paper, after: Paper) -> Change:
    """What differs between two states of the same sheet."""
    return Change(
        sorted(after.places.keys() - before.places.keys()),
        sorted(after.faces.keys() - before.faces.keys()),
        list(moved_faces(before, after)),
    )
