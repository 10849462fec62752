"""Thin parts of the other side are seen, mixed borders are not taken for one, and hands are told from the table."""

import cv2
import numpy as np
import pytest
from folding_server.arrays import RgbImage
from folding_server.simulator import add_vertex, fold
from folding_server.simulator.paper import Paper, new_paper
from folding_server.vision.colours import to_lab
from folding_server.vision.labels import BACK, BACKGROUND, FRONT, UNKNOWN, is_paper
from folding_server.vision.obstacles import ObstacleView, obstacles
from folding_server.vision.seeing import see_sequence
from folding_server.vision.segmentation import class_costs
from paper_drawings import label_image
from vision_scenes import GRID, SIDE, Look, PhotoList, paint, share_right

HIDDEN_BLUE = Look(front=(240, 238, 230), back=(50, 100, 180), table=(35, 36, 40), lamp=0.1)


def peeping(width: float) -> Paper:
    """The right part folded over to the left, all but a strip of the front covered by the back."""
    paper = add_vertex(add_vertex(new_paper(), (1, 2), 0.5 + width / 2), (3, 4), 0.5 - width / 2)
    return fold(paper, (5, 6), 1)


@pytest.mark.slow
@pytest.mark.parametrize("width", [0.012, 0.02, 0.04])
def test_a_strip_of_the_other_side_two_pixels_wide_is_seen(width: float) -> None:
    shown = peeping(width)
    photos = PhotoList([paint(new_paper(), HIDDEN_BLUE), paint(shown, HIDDEN_BLUE, seed=1)])
    seen = see_sequence(photos).frame(2, 160)
    truth = label_image(shown, seen.grid)
    assert share_right(seen.labels, truth) > 0.98
    assert (seen.labels == FRONT)[truth == FRONT].mean() > 0.6


@pytest.mark.parametrize("back", [(128, 128, 125), (90, 92, 96)])
def test_the_blurred_border_of_a_white_sheet_is_no_grey_back(back: tuple[int, int, int]) -> None:
    look = Look(front=(245, 245, 242), back=back, table=(25, 25, 28), lamp=0.1)
    flat, turned = new_paper(), fold(new_paper(), (1, 3), 1)
    photos = PhotoList([paint(p, look, seed=i) for i, p in enumerate((flat, turned, flat))])
    seen = see_sequence(photos).frame(3, 160)
    assert not (seen.labels == BACK).any()


def wood(rng: np.random.Generator) -> RgbImage:
    """A brown table with grain along it."""
    grain = cv2.GaussianBlur(rng.normal(0, 1, (SIDE, SIDE)), (0, 0), sigmaX=1.0, sigmaY=12)
    return np.clip(np.array([150, 105, 65]) * (1 + 0.6 * grain[..., None]), 0, 255).astype(np.uint8)


def on_table(paper: Paper, look: Look, table: RgbImage, seed: int) -> RgbImage:
    """A painted photo whose table is a picture."""
    shown = label_image(paper, GRID) > 0
    noise = np.random.default_rng(seed).normal(0, 1.5, table.shape)
    photo = np.where(shown[..., None], paint(paper, look, seed=seed), table + noise)
    return np.clip(cv2.GaussianBlur(photo, (0, 0), 0.6), 0, 255).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize("skin", [(112, 74, 50), (138, 98, 62), (160, 108, 66)])
def test_a_brown_hand_on_a_wooden_table_is_unknown(skin: tuple[int, int, int]) -> None:
    look, table = Look(lamp=0.0), wood(np.random.default_rng(3))
    folded = fold(new_paper(), (1, 3), 1)
    photos = [on_table(paper, look, table, i) for i, paper in enumerate((new_paper(), folded, folded))]
    hand = np.zeros((SIDE, SIDE), np.uint8)
    cv2.line(hand, (SIDE // 2 - 40, SIDE), (SIDE // 2 - 40, SIDE // 2 + 50), 1, 36)
    cv2.line(hand, (SIDE // 2 - 40, SIDE // 2 + 50), (SIDE // 2 - 40, SIDE // 2 + 10), 1, 14)
    lit = np.array(skin) + np.random.default_rng(4).normal(0, 2.5, (SIDE, SIDE, 3))
    photos[2] = np.where(hand[..., None] > 0, lit, photos[2]).astype(np.uint8)
    observer = see_sequence(PhotoList(photos))
    seen, bare = observer.frame(3, 180), observer.frame(2, 180)
    rectified, inside = observer.pose.rectify(
        cv2.cvtColor(hand * np.uint8(255), cv2.COLOR_GRAY2RGB), seen.grid
    )
    covered = (rectified[..., 0] > 200) & inside
    assert (seen.labels == UNKNOWN)[covered].mean() > 0.9
    far = cv2.dilate(covered.astype(np.uint8), np.ones((21, 21), np.uint8)) == 0
    truth = label_image(folded, seen.grid)
    assert share_right(np.where(far, seen.labels, UNKNOWN), truth) > 0.97
    assert (bare.labels == UNKNOWN)[100:300, 100:300].mean() < 0.01


@pytest.mark.parametrize(
    ("sides", "table_colour", "skin"),
    [
        (((235, 215, 95), (130, 84, 40)), (200, 172, 128), (104, 64, 42)),
        (((200, 50, 45), (226, 224, 218)), (60, 70, 85), (222, 190, 170)),
    ],
    ids=["brown", "pale"],
)
def test_a_hand_of_about_the_colour_of_the_back_is_no_paper(
    sides: tuple[tuple[int, int, int], tuple[int, int, int]],
    table_colour: tuple[int, int, int],
    skin: tuple[int, int, int],
) -> None:
    look = Look(front=sides[0], back=sides[1], lamp=0.0)
    flat, folded = new_paper(), fold(new_paper(), (1, 3), 1)
    table = np.full((SIDE, SIDE, 3), table_colour, np.uint8)
    photos = [on_table(paper, look, table, i) for i, paper in enumerate((flat, folded, flat))]
    arm, hand = np.zeros((SIDE, SIDE), np.uint8), np.zeros((SIDE, SIDE), np.uint8)
    cv2.line(arm, (SIDE // 2, SIDE), (SIDE // 2, SIDE - 40), 1, 36)
    cv2.line(hand, (SIDE // 2, SIDE - 60), (SIDE // 2, SIDE // 2 + 10), 1, 34)
    for mask, colour in ((arm, (40, 70, 130)), (hand, skin)):
        lit = np.array(colour) + np.random.default_rng(4).normal(0, 2.0, (SIDE, SIDE, 3))
        photos[2] = np.where(mask[..., None] > 0, lit, photos[2]).astype(np.uint8)
    observer = see_sequence(PhotoList(photos))
    seen = observer.frame(3, 180)
    rectified, inside = observer.pose.rectify(
        cv2.cvtColor(hand * np.uint8(255), cv2.COLOR_GRAY2RGB), seen.grid
    )
    covered = (rectified[..., 0] > 200) & inside
    assert (seen.labels == BACK)[covered].mean() < 0.05
    assert (seen.labels == FRONT)[~covered & (label_image(flat, seen.grid) == FRONT)].mean() > 0.9


def test_lines_on_a_mat_in_the_colour_of_the_paper_stay_table() -> None:
    look = Look(front=(90, 160, 210), back=(245, 245, 240), lamp=0.0)
    table = np.full((SIDE, SIDE, 3), (40, 60, 110), np.uint8)
    for at in range(12, SIDE, 42):
        table[at : at + 3], table[:, at : at + 3] = (88, 150, 200), (88, 150, 200)
    folded = fold(new_paper(), (1, 3), 1)
    photos = [on_table(paper, look, table, i) for i, paper in enumerate((new_paper(), folded))]
    seen = see_sequence(PhotoList(photos)).frame(2, 160)
    truth = label_image(folded, seen.grid)
    stray = is_paper(seen.labels) & (truth == BACKGROUND)
    assert stray.sum() < 0.02 * (truth > 0).sum()
    assert share_right(seen.labels, truth) > 0.97


def test_a_part_of_a_sleeve_in_the_colour_of_the_paper_is_no_paper() -> None:
    look = Look(front=(235, 230, 220), back=(200, 50, 45), lamp=0.0)
    flat, folded = new_paper(), fold(new_paper(), (1, 3), 1)
    table = np.full((SIDE, SIDE, 3), (70, 90, 80), np.uint8)
    photos = [on_table(paper, look, table, i) for i, paper in enumerate((flat, folded, flat))]
    middle = SIDE // 2
    for start, end, width, colour in (
        ((middle, SIDE), (middle, SIDE - 60), 60, (60, 60, 150)),
        ((middle, SIDE - 70), (middle, middle + 40), 40, (150, 90, 160)),
        ((middle, SIDE - 45), (middle, SIDE - 40), 26, (235, 230, 220)),
    ):
        cv2.line(photos[2], start, end, colour, width)
    seen = see_sequence(PhotoList(photos)).frame(3, 180)
    truth = label_image(flat, seen.grid)
    below = is_paper(seen.labels) & (truth == BACKGROUND)
    assert below.sum() < 0.002 * (truth > 0).sum()
    assert (seen.labels == FRONT)[truth == FRONT].mean() > 0.85


def test_a_hand_like_the_hidden_side_that_lies_on_the_sheet_is_no_paper() -> None:
    look = Look(front=(226, 190, 165), back=(70, 140, 75), table=(60, 60, 66), lamp=0.0)
    flat, folded = new_paper(), fold(new_paper(), (2, 4), 1)
    photos = [paint(paper, look, seed=i) for i, paper in enumerate((flat, folded, folded))]
    middle = SIDE // 2
    cv2.line(photos[2], (SIDE, middle), (middle + 20, middle), look.front, 34)
    seen = see_sequence(PhotoList(photos)).frame(3, 180)
    truth = label_image(folded, seen.grid)
    assert share_right(seen.labels, truth) > 0.98
    assert (seen.labels == BACK)[truth == BACK].mean() > 0.7


def test_a_table_of_many_browns_is_no_skin() -> None:
    look, rng = Look(lamp=0.0), np.random.default_rng(5)
    grain = cv2.GaussianBlur(rng.normal(0, 1, (SIDE, SIDE, 3)), (0, 0), sigmaX=6, sigmaY=24)
    browns = np.clip(np.array([150, 105, 70]) + grain / grain.std() * (14, 8, 10), 0, 255).astype(np.uint8)
    folded = fold(new_paper(), (1, 3), 1)
    tables = [np.roll(browns, 25 * i, axis=1) for i in range(3)]
    photos = [
        on_table(p, look, t, i)
        for i, (p, t) in enumerate(zip((new_paper(), folded, folded), tables, strict=True))
    ]
    observer = see_sequence(PhotoList(photos))
    for frame in (2, 3):
        seen = observer.frame(frame, 180)
        _, inside = observer.pose.rectify(photos[frame - 1], seen.grid)
        assert (seen.labels == UNKNOWN)[inside].mean() < 0.1


def test_an_obstacle_of_which_each_colour_has_few_pixels_is_unknown() -> None:
    observer = see_sequence(PhotoList([paint(new_paper(), Look(lamp=0.0))]))
    grid = observer.frame(1).grid
    rgb = np.full((grid.rows, grid.cols, 3), Look().table, np.uint8)
    for place, colour in enumerate([(20, 200, 30), (220, 30, 200), (250, 220, 10), (10, 60, 240)]):
        row, col = 20 + 6 * (place // 2), 20 + 6 * (place % 2)
        rgb[row : row + 6, col : col + 6] = colour
    lab, seen = to_lab(rgb), np.ones(rgb.shape[:2], bool)
    costs = class_costs(lab, grid, observer.palette)
    hidden = obstacles(ObstacleView(lab, rgb, costs, seen, grid, observer.palette, None))
    assert hidden[20:32, 20:32].all()
    assert hidden.sum() < 250
