"""What is tried for a photo framed anew where neither a landmark nor a line through a vertex explains it."""

import pytest
from exactness import exactness
from folding_schemas.actions import Action, AddVertex, Flip, Fold, Rotate
from folding_server.simulator import apply, new_paper, replay
from folding_server.vision.any_camera import compare_with_photo
from folding_server.vision.grid import Grid
from folding_server.vision.pose_estimation.estimate import estimates
from folding_server.vision.seeing import see_sequence
from folding_server.vision.solver import propose
from folding_server.vision.solver.hypotheses import further_hypotheses, hypotheses
from folding_server.vision.solver.hypothesis_judge import WHOLE_MOVES
from framed_anew import Standpoint, photo
from paper_drawings import label_image, label_polygons
from vision_scenes import PhotoList, share_right

FIRST, SECOND = Standpoint(roll=3.0, tilt=4.0), Standpoint(3.0, 20.0, 8.0, 200.0)
MOVED = Standpoint(2.8, 50.0, 12.0, 30.0, (40.0, -30.0))
STRIP = (
    AddVertex(edge=(4, 1), position=0.2),
    AddVertex(edge=(3, 2), position=0.2),
    Fold(edge=(5, 6), direction=-1),
)
BOTH_SIDES = (
    AddVertex(edge=(1, 2), position=0.5),
    Fold(edge=(5, 7), direction=1),
    Fold(edge=(7, 6), direction=1),
)
BLINTZ = (
    AddVertex(edge=(1, 2), position=0.5),
    AddVertex(edge=(4, 1), position=0.5),
    Fold(edge=(5, 6), direction=1),
    AddVertex(edge=(2, 3), position=0.5),
    Fold(edge=(7, 5), direction=1),
    AddVertex(edge=(3, 4), position=0.5),
    Fold(edge=(6, 8), direction=-1),
    Fold(edge=(8, 7), direction=-1),
    Flip(axis="y=-x"),
)
"""All corners to the middle, and turned over."""
OPPOSITE_CORNERS = (
    AddVertex(edge=(8, 6), position=0.5),
    AddVertex(edge=(6, 5), position=0.5),
    Fold(edge=(9, 10), direction=1),
    AddVertex(edge=(5, 7), position=0.5),
    AddVertex(edge=(7, 8), position=0.5),
    Fold(edge=(13, 14), direction=-1),
)
TIP = (
    AddVertex(edge=(2, 4), position=0.1),
    AddVertex(edge=(1, 2), position=0.9),
    Fold(edge=(5, 6), direction=1),
)
HALVED = (AddVertex(edge=(2, 4), position=0.5), Fold(edge=(5, 3), direction=-1))
ABOUT = Grid(-1.5, 2.5, 100.0, 400, 400)
"""What the stacks are drawn on."""


def test_folds_on_both_sides_look_as_the_simulator_makes_them() -> None:
    pairs = [h for h in further_hypotheses(replay(STRIP)) if h.action_class == "compound"]
    assert len(pairs) > 20
    for pair in pairs:
        drawn = label_polygons(pair.stack.outlines, pair.stack.backs, ABOUT)
        made = [after for _, after in pair.ways()]
        assert made
        assert max(share_right(drawn, label_image(after, ABOUT)) for after in made) > 0.99


def test_opposite_corners_of_a_square_are_folded_at_once() -> None:
    after = replay((*BLINTZ, *OPPOSITE_CORNERS))
    pairs = [h for h in further_hypotheses(replay(BLINTZ)) if h.action_class == "compound"]
    assert any(exactness(after, made).holds() for pair in pairs for _, made in pair.ways())


@pytest.mark.parametrize("turned", [0.0, 20.0, 65.0])
def test_an_unfolding_is_among_the_cameras_however_many_folds_look_alike(turned: float) -> None:
    """Half of a triangle is a triangle: very many folds of it look like the whole one, under some camera."""
    triangle = replay((Rotate(angle=turned), Fold(edge=(2, 4), direction=1)))
    half = apply(apply(triangle, HALVED[0]), HALVED[1])
    observer = see_sequence(PhotoList([photo(new_paper(), FIRST), photo(triangle, MOVED, seed=1)]))
    tried = hypotheses(half)
    whole = [i for i, h in enumerate(tried) if h.action_class in WHOLE_MOVES]
    (view,) = observer.pictures(2)
    found = estimates([h.stack for h in tried], view, always=whole)
    best = next(e for e in found if tried[e.index].action_class == "unfold")
    assert best.agreement > 0.98


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "step"),
    [
        (STRIP, BOTH_SIDES),
        (
            (),
            (
                AddVertex(edge=(1, 2), position=0.37),
                AddVertex(edge=(2, 3), position=0.73),
                Fold(edge=(5, 6), direction=1),
            ),
        ),
        ((Fold(edge=(2, 4), direction=1),), TIP),
    ],
    ids=["both sides at once", "a line that meets no vertex", "a tip"],
)
def test_what_no_landmark_gives_is_found_under_any_camera(
    before: tuple[Action, ...], step: tuple[Action, ...]
) -> None:
    known, after = replay(before), replay((*before, *step))
    photos = [photo(new_paper(), FIRST), photo(known, SECOND, seed=1), photo(after, MOVED, seed=2)]
    observer = see_sequence(PhotoList(photos))
    plan = propose(known, observer, 3)[0]
    assert exactness(after, plan.paper).holds()
    assert compare_with_photo(plan.paper, observer, 3).match.verdict == "MATCH"
