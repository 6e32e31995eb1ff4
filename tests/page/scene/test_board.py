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
from app.page.scene.board import SURFACE_UNITS, BoardView, in_linear_light
from app.page.scene.outlines import BOARD_UNITS, cell_centres
from app.picture.layer import Picture
from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from app.server.server import close_server, open_server
from learners.run import Run
from tests.support.person import drawn

SIZE = 20


def moment(size: int = SIZE, *settings: str) -> Snapshot:
    spec = presets.load("timed", [f"world.size={size}", *settings])
    return snapshot.take(Run(spec, seed=1), "timed", 0)


def picture(height: float = 0.0, size: int = SIZE) -> Picture:
    """A picture whose surface is everywhere as high."""
    n_cells = size * size
    return Picture(np.zeros((n_cells, 3), np.uint8), np.full(n_cells, height, np.float32))


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


# Points


def test_cells_of_a_surface_leave_no_holes_whatever_else_is_changed(board: Board) -> None:
    unit = BOARD_UNITS / SIZE
    board.update(moment(), picture(), Look(), now_s=0.0)
    assert board.drawn("cells").point_size == unit / 2
    board.update(moment(), picture(), Look(surface=True), now_s=1.0)
    assert board.drawn("cells").point_size == unit
    board.update(moment(), picture(), Look(surface=True, theme=DARK), now_s=2.0)
    assert board.drawn("cells").point_size == unit
    board.update(moment(40), picture(size=40), Look(surface=True, theme=DARK), now_s=3.0)
    assert board.drawn("cells").point_size == unit / 2
    board.update(moment(40), picture(size=40), Look(theme=DARK), now_s=4.0)
    assert board.drawn("cells").point_size == unit / 4


def test_a_surface_is_the_mean_of_the_cells_around(board: Board) -> None:
    found = picture()
    found.height[SIZE * 10 + 10] = 1.0
    board.update(moment(), found, Look(surface=True), now_s=0.0)
    height = board.drawn("cells").points[:, 2].reshape(SIZE, SIZE) / SURFACE_UNITS
    expected = np.zeros((SIZE, SIZE))
    expected[8:13, 8:13] = 1 / 25
    np.testing.assert_allclose(height, expected, atol=1e-6)


def test_a_surface_goes_on_beyond_the_border_as_it_is_there(board: Board) -> None:
    found = picture()
    found.height[:] = np.repeat(np.arange(SIZE) < 1, SIZE)
    board.update(moment(), found, Look(surface=True), now_s=0.0)
    height = board.drawn("cells").points[:, 2].reshape(SIZE, SIZE) / SURFACE_UNITS
    # Of the five rows around the southernmost, two lie beyond it and are taken to be like it.
    np.testing.assert_allclose(height[:4, 7], [3 / 5, 2 / 5, 1 / 5, 0], atol=1e-6)


def test_parts_of_lines_have_their_colours_in_linear_light() -> None:
    assert in_linear_light((0, 255, 128)).tolist() == [0, 255, 55]


def steep(board: Board) -> np.ndarray:
    """Let a board show a ridge from south to north, the last paths, and the visual field.

    Returns:
        Heights of its cells, ``(y, x)``.
    """
    found = picture()
    found.height.reshape(SIZE, SIZE)[:, 11:14] = 1.0
    run = Run(presets.load("timed", [f"world.size={SIZE}"]), seed=1)
    run.advance(max_steps=2_000)
    taken = snapshot.take(run, "timed", 0)
    board.update(taken, found, Look(surface=True, paths=True), now_s=0.0)
    return board.drawn("cells").points[:, 2].reshape(SIZE, SIZE)


@pytest.mark.parametrize("name", ["field", "heading", "trail", "paths"])
def test_lines_over_a_surface_lie_above_it_all_along(board: Board, name: str) -> None:
    ground, unit = steep(board), BOARD_UNITS / SIZE
    lines = board.drawn(name).points.astype(float)
    assert len(lines)
    for share in np.linspace(0, 1, 9):
        points = lines[:, 0] + share * (lines[:, 1] - lines[:, 0])
        x, y = np.clip(np.rint(points[:, :2] / unit).astype(int) + SIZE // 2, 0, SIZE - 1).T
        # Higher than the squares that the surface is made of.
        assert (points[:, 2] >= ground[y, x] + unit * 0.5).all()


@pytest.mark.parametrize(("name", "radius"), [("predator", 0.17), ("prey", 0.13)])
def test_dots_over_a_surface_are_higher_than_they_are_large(
    board: Board, name: str, radius: float
) -> None:
    ground, unit = steep(board), BOARD_UNITS / SIZE
    (point,) = board.drawn(name).points.astype(float)
    x, y = np.rint(point[:2] / unit).astype(int) + SIZE // 2
    assert point[2] >= ground[y, x] + unit + radius


def test_parts_of_a_long_line_keep_its_colour(board: Board) -> None:
    steep(board)
    for name in ("trail", "paths"):
        lines = board.drawn(name)
        assert lines.points.shape == lines.colors.shape


def test_the_start_zone_has_a_colour_of_its_own() -> None:
    for theme in (LIGHT, DARK):
        others = {name: colour for name, colour in theme._asdict().items() if name != "zone"}
        assert theme.zone not in others.values()


# From a ray to a place


def test_a_ray_meets_a_flat_board_where_it_passes_the_plane(board: Board) -> None:
    assert board.place_under((1.0, 2.0, 9.0), (0.0, 0.0, -3.0)) == (1.0, 2.0)
    eye = np.array([1.0, -8.0, 11.0])
    for place in cell_centres(moment().spec.world)[::37]:
        found = board.place_under(tuple(eye.tolist()), tuple((place - eye).tolist()))
        assert found == pytest.approx(place[:2].tolist(), abs=1e-6)


def test_a_ray_meets_a_surface_before_the_plane(board: Board) -> None:
    board.update(moment(), picture(1.0), Look(surface=True), now_s=0.0)
    found = board.place_under((-5.0, 0.0, 5.0), (1.0, 0.0, -1.0))
    assert found == pytest.approx((-SURFACE_UNITS, 0.0), abs=0.02)


@pytest.mark.parametrize("surface", [False, True])
@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((0, 0, 9), (0, 0, 1)),
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
    surface: bool,
) -> None:
    board.update(moment(), picture(1.0), Look(surface=surface), now_s=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert board.place_under(origin, direction) is None
