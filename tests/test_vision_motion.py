"""The images between two photos tell which side of the paper moved, and hands in them are no motion."""

import pytest
from films import LOOK, eyes_on_film, film_movement, halves
from folding_server.simulator import fold
from folding_server.simulator.paper import new_paper
from folding_server.vision.labels import UNKNOWN
from folding_server.vision.motion import movement
from folding_server.vision.photos import Film
from folding_server.vision.seeing import see_sequence
from vision_scenes import PhotoList, paint


@pytest.mark.slow
def test_the_moving_side_changes_and_the_other_stays() -> None:
    found = film_movement()
    places = (
        found.before.grid.to_pixel([[x, y] for x in (0.1, 0.2) for y in (0.15, 0.85)]).round().astype(int)
    )
    moving = (
        found.before.grid.to_pixel([[x, y] for x in (0.8, 0.95) for y in (0.15, 0.85)]).round().astype(int)
    )
    assert found.watched[places[:, 1], places[:, 0]].min() >= 3
    assert found.moved[places[:, 1], places[:, 0]].max() == 0
    assert found.moved[moving[:, 1], moving[:, 0]].min() > 0.5


def test_the_table_shows_where_all_of_the_paper_was_lifted_and_the_other_side_where_it_comes_to_lie() -> None:
    found = film_movement()
    left, right = (
        found.before.grid.to_pixel([[x, y] for y in (0.3, 0.65)]).round().astype(int) for x in (0.52, 0.92)
    )
    assert found.bared[right[:, 1], right[:, 0]].min() > 0.5
    assert found.turned[right[:, 1], right[:, 0]].max() == 0
    assert found.turned[left[:, 1], left[:, 0]].min() > 0
    assert found.bared[left[:, 1], left[:, 0]].max() == 0


def test_the_edge_of_the_paper_is_not_watched_since_the_sheet_may_drift() -> None:
    found = film_movement()
    column, row = found.before.grid.to_pixel([0.5, 0.985]).round().astype(int)
    assert found.watched[row, column] == 0


def test_hands_in_the_images_between_are_unknown() -> None:
    seen = eyes_on_film().between(2, 96)
    assert len(seen) == 4
    assert [image.frame for image in seen] == [2, 2, 2, 2]
    for image in seen:
        column, row = image.grid.to_pixel([1.25, 0.4]).round().astype(int)
        assert image.labels[row, column] == UNKNOWN


def test_a_sequence_of_photos_alone_has_no_motion() -> None:
    photos = PhotoList([paint(new_paper(), LOOK), paint(fold(halves(), (5, 6), 1), LOOK, seed=1)])
    observer = see_sequence(photos)
    assert not isinstance(photos, Film)
    assert observer.between(2) == ()
    assert movement(observer, 2) is None
    assert eyes_on_film().between(1) == ()
