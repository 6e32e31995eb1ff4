"""Names on the board, for those who cannot tell its colours apart."""

import numpy as np

from app.picture.layer import Label, Picture
from app.player.names import middles

SIZE = 24


def picture_of(regions: np.ndarray, *names: str) -> Picture:
    blank = np.zeros((regions.size, 3), np.uint8)
    return Picture(blank, regions=regions.ravel(), names=names)


def test_a_name_stands_in_the_middle_of_its_largest_place() -> None:
    regions = np.full((SIZE, SIZE), -1)
    regions[2:11, 4:13] = 0
    regions[15:18, 15:18] = 0
    assert middles(picture_of(regions, "approach")) == (Label("approach", -4, -6),)


def test_the_edge_of_the_board_is_an_edge_and_what_has_no_room_has_no_name() -> None:
    regions = np.zeros((SIZE, SIZE), int)
    regions[:, 12:] = 2
    found = middles(picture_of(regions, "approach", "circle clockwise", "avoid"))
    assert [label.text for label in found] == ["approach", "avoid"]
    assert found[0].east in (-7, -6)
    assert found[1].east in (5, 6)


def test_other_layers_have_no_names() -> None:
    assert middles(Picture(np.zeros((SIZE * SIZE, 3), np.uint8))) == ()
