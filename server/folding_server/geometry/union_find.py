"""What belongs together when some pairs do."""

from collections.abc import Iterable


def joined(members: Iterable[int], pairs: Iterable[tuple[int, int]]) -> dict[int, int]:
    """For each member the least of those that a chain of pairs joins it with, itself among them."""
    parent = {member: member for member in members}

    def root(member: int) -> int:
        while parent[member] != member:
            parent[member] = parent[parent[member]]
            member = parent[member]
        return member

    for first, second in pairs:
        a, b = root(first), root(second)
        parent[max(a, b)] = min(a, b)
    return {member: root(member) for member in parent}
