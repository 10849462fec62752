"""Plans that a photo cannot tell apart: the photos after it are explained from each, as far as it takes."""

from collections.abc import Callable

from folding_schemas.actions import Flip
from folding_server.geometry.isometry import IDENTITY
from folding_server.simulator import Paper, apply, new_paper
from folding_server.vision.solver.look_ahead import DECIDED, MOST_AHEAD, behind
from folding_server.vision.solver.plan import Plan

LAID, TURNED = new_paper(), apply(new_paper(), Flip(axis="x"))


def plan(paper: Paper, agreement: float) -> Plan:
    """A plan that needs no action."""
    return Plan((), "none", paper, IDENTITY, agreement, "")


TIED = [plan(LAID, 0.98), plan(TURNED, 0.98)]


def following(agreements: dict[tuple[bool, int], float], asked: list[int]) -> Callable[[Paper, int], Plan]:
    """Explanations of the photos to come: by whether the sheet was turned over, and the photo; others explain it all."""

    def explain(paper: Paper, frame: int) -> Plan:
        asked.append(frame)
        return plan(paper, agreements.get((paper == TURNED, frame), 1.0))

    return explain


def ahead(frame: int, last: int, explain: Callable[[Paper, int], Plan]) -> list[float]:
    """How far the tied plans fall behind if a thorough look finds no more than a quick one."""
    return behind(TIED, frame, last, explain, explain)


def test_a_photo_that_nothing_usual_explains_is_looked_at_thoroughly() -> None:
    quick = following({(False, 3): 0.7, (True, 3): 0.8}, [])
    lost = behind(TIED, 2, 3, quick, following({(True, 3): 0.9}, []))
    assert [round(x, 6) for x in lost] == [0.0, 0.1]


def test_the_next_photo_decides_where_it_can() -> None:
    asked: list[int] = []
    lost = ahead(2, 9, following({(True, 3): 0.9}, asked))
    assert [round(x, 6) for x in lost] == [0.0, 0.1]
    assert set(asked) == {3}


def test_what_the_next_photo_leaves_open_a_later_one_decides() -> None:
    asked: list[int] = []
    assert ahead(2, 9, following({(False, 4): 0.8}, asked))[1] == 0.0
    assert set(asked) == {3, 4}


def test_small_differences_add_up_until_they_decide() -> None:
    little = 0.6 * DECIDED
    lost = ahead(2, 9, following({(True, 3): 1 - little, (True, 4): 1 - little}, []))
    assert round(lost[1], 6) == round(2 * little, 6)


def test_no_more_photos_are_looked_at_than_there_are_or_than_is_worth_it() -> None:
    asked: list[int] = []
    assert ahead(2, 3, following({}, asked)) == [0.0, 0.0]
    assert set(asked) == {3}
    assert ahead(2, 2, following({}, [])) == [0.0, 0.0]
    ahead(2, 99, following({}, asked))
    assert max(asked) == 2 + MOST_AHEAD
