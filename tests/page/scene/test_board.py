"""The board in one browser, on a real server that nobody looks at."""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.page.scene.board import BoardView
from app.page.scene.parts import in_linear_light
from app.picture.layer import Extras, Picture
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from app.picture.multiples import SIDE, TILES, all_headings
from app.picture.outlines import BOARD_UNITS, cell_centres
from app.picture.theme import DARK, LIGHT
from app.server.server import close_server, open_server
from learners.run import Run
from tests.support.person import drawn

SIZE = 20


def moment(size: int = SIZE, *settings: str) -> Snapshot:
    spec = presets.load("timed", [f"world.size={size}", *settings])
    return snapshot.take(Run(spec, seed=1), "timed", 0)


def picture(size: int = SIZE) -> Picture:
    return Picture(np.zeros((size * size, 3), np.uint8))


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


class Board(BoardView):
    """A board in a scene, which says what is drawn there."""

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene, moment(), Look())
        self.scene = scene

    def drawn(self, name: str) -> Any:
        return drawn(self.scene, f"/board/{name}")


@pytest.fixture
def board(server: viser.ViserServer) -> Board:
    return Board(server.scene)


# Sensors


def test_the_sensors_are_those_of_the_skills_where_a_skill_is_shown(board: Board) -> None:
    taken = moment(SIZE, "world.skill_n_directions=8", "world.skill_n_distances=3")

    def lines(layer: str) -> int:
        board.update(taken, picture(), Look(layer=layer, sensors=True), now_s=0.0)
        return len(board.drawn("sensors").points)

    assert lines("skill") < lines("value") / 2
    assert lines("option") == lines("value")


# Colours


def test_cells_have_the_colours_of_the_picture(board: Board) -> None:
    found = picture()
    found.colours[7] = 1, 2, 3
    board.update(moment(), found, Look(), now_s=0.0)
    assert (board.drawn("cells").colors == found.colours).all()


def test_parts_of_lines_have_their_colours_in_linear_light() -> None:
    assert in_linear_light((0, 255, 128)).tolist() == [0, 255, 55]


def test_the_start_zone_has_a_colour_of_its_own() -> None:
    for theme in (LIGHT, DARK):
        others = {name: colour for name, colour in theme._asdict().items() if name != "zone"}
        assert theme.zone not in others.values()


# From a ray to a place


def test_a_ray_meets_a_flat_board_where_it_passes_the_plane(board: Board) -> None:
    assert board.place_under((1.0, 2.0, 9.0), (0.0, 0.0, -3.0)) == (1.0, 2.0)
    eye = np.array([1.0, -8.0, 11.0])
    places = cell_centres(moment().spec.world)
    # The board is round, for all headings are shown at once.
    for place in places[np.hypot(*places[:, :2].T) < 5.7][::37]:
        found = board.place_under(tuple(eye.tolist()), tuple((place - eye).tolist()))
        assert found == pytest.approx(place[:2].tolist(), abs=1e-6)


@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((0, 0, 9), (0, 0, 1)),
        ((0, 0, -9), (0, 0, -1)),
        ((0, 0, 9), (1, 0, 0)),
        ((0, 0, 9), (0, 0, 0)),
        ((float("nan"), 0, 9), (0, 0, -1)),
        ((float("inf"), 0, 9), (0, 0, -1)),
        ((0, 0, 9), (0, float("nan"), -1)),
        ((1e308, 0, 1e308), (1e308, 0, -1e-308)),
    ],
)
def test_a_ray_that_meets_nothing_is_no_error(
    board: Board,
    origin: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert board.place_under(origin, direction) is None


# All headings side by side


def test_a_ray_tells_whose_heading_it_meets_where_all_are_side_by_side(board: Board) -> None:
    look, taken = Look(frame=ALL), moment()
    board.update(taken, all_headings(taken, look, LAYERS["value"], Extras()), look, now_s=0.0)
    assert len(board.drawn("cells").points) == len(TILES) * SIDE**2
    for tile in TILES:
        east, north = tile.east * BOARD_UNITS, tile.north * BOARD_UNITS
        assert board.heading_under((east, north, 9.0), (0.0, 0.0, -1.0)) == tile.heading
    assert board.heading_under((0.0, 0.0, 9.0), (0.0, 0.0, -1.0)) is None
    board.update(taken, picture(), Look(), now_s=1.0)
    assert board.heading_under((2.0, 2.0, 9.0), (0.0, 0.0, -1.0)) is None


def test_what_does_not_know_where_the_prey_looks_is_drawn_without_that(board: Board) -> None:
    for layer, is_drawn in (("value", True), ("skill", False), ("flow", True)):
        board.update(moment(), picture(), Look(layer=layer), now_s=0.0)
        for name in ("field", "heading"):
            assert board.drawn(name).visible == is_drawn
