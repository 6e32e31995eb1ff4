"""Hunts on the board, on a real server that nobody looks at."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot, TrialEnd
from app.page.scene.hunt import HuntView
from app.page.scene.parts import in_linear_light
from app.picture.frames import folds
from app.picture.look import FOLDED, OF_TRIAL, Look
from app.picture.outlines import edges, kept_on_board
from app.picture.theme import LIGHT, OUTCOME_SHAPES
from app.player.hunts import ENDED, way_of
from app.server.server import close_server, open_server
from learners.run import Run
from sim.world import CAPTURE, FLIGHT, TIMEOUT, cell_at
from tests.support.person import drawn

SIZE = 40
SPEC = presets.load("timed", [f"world.size={SIZE}"])


def moment(trial: int = 0, steps: int = 0) -> Snapshot:
    """A run so many steps after the start of a trial."""
    run = Run(SPEC, seed=1)
    run.advance(until_trial=trial)
    run.advance(max_steps=steps)
    return snapshot.take(run, "timed", 0)


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


class Board(HuntView):
    """Hunts in a scene, which says what is drawn there."""

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene, LIGHT)
        self.scene = scene

    def see(self, taken: Snapshot, look: Look | None = None, **how: bool) -> None:
        """Show a moment."""
        self.update(
            taken, look or Look(), 0.0, how.get("rests", False), how.get("named", False), True
        )

    def points(self, name: str) -> np.ndarray:
        """What is drawn of something, without what is kept away."""
        points = drawn(self.scene, f"/board/{name}").points
        flat = points.reshape(-1, 3)
        return flat[flat[:, 2] >= 0]

    def dots(self) -> dict[str, list[list[int]]]:
        """Colours of the dots of each shape, the oldest first."""
        found: dict[str, list[list[int]]] = {}
        for shape in OUTCOME_SHAPES.values():
            handle = drawn(self.scene, f"/board/ends/{shape}")
            found[shape] = handle.colors[handle.points[:, 2] >= 0].tolist()
        return found

    def words(self) -> list[str]:
        """What stands on the board."""
        labels = (drawn(self.scene, f"/board/tags/{number}") for number in range(3))
        return [label.text for label in labels if label.visible]


@pytest.fixture
def board(server: viser.ViserServer) -> Iterator[Board]:
    board = Board(server.scene)
    yield board
    board.remove()


# How trials ended


def ends(*outcomes: int) -> tuple[TrialEnd, ...]:
    """Ends of the first trials, at the prey."""
    return tuple(
        TrialEnd(trial, cell_at(moment().world, 20, 20), 0, outcome)
        for trial, outcome in enumerate(outcomes)
    )


def test_dots_fade_with_trials_and_not_while_nothing_is_learned(board: Board) -> None:
    taken = replace(moment(3), ends=ends(CAPTURE, FLIGHT, CAPTURE))
    board.see(taken)
    before = board.dots()
    oldest, newest = before["circle"]
    assert newest == list(LIGHT.capture)
    paler = np.abs(np.array(oldest) - LIGHT.unknown) < np.abs(np.array(newest) - LIGHT.unknown)
    assert paler.all()
    board.update(taken, Look(), 1e6, True, False, False)
    assert board.dots() == before
    board.see(replace(taken, ends=ends(CAPTURE, FLIGHT, CAPTURE, TIMEOUT)))
    assert board.dots()["circle"][1] != newest
    assert board.dots()["square"] == [list(LIGHT.timeout)]


def test_however_fast_it_is_there_are_as_many_dots(board: Board) -> None:
    for trial in (3_000, 6_000):
        taken = moment(trial)
        board.see(taken)
        assert sum(map(len, board.dots().values())) == len(taken.ends) == snapshot.RECENT_ENDS


def test_another_run_begins_without_dots(board: Board) -> None:
    board.see(moment(30))
    board.see(moment())
    assert sum(map(len, board.dots().values())) == 0


# Which hunt is shown


def test_a_trial_that_has_ended_is_shown_until_the_next_one_begins(board: Board) -> None:
    taken = moment(trial=7)
    path, word = taken.paths[-1], ENDED[taken.ends[-1].outcome]
    board.see(taken, rests=True)
    assert board.words() == [word]
    assert len(board.points("trail")) == 2 * (len(path.cells) - 1)
    ink = in_linear_light(LIGHT.of_outcome(path.outcome)).tolist()
    assert drawn(board.scene, "/board/trail").colors[0, 0].tolist() == ink
    shape = OUTCOME_SHAPES[path.outcome]
    there = board.points("predator")[0, :2]
    np.testing.assert_allclose(board.points(f"last/{shape}")[0, :2], there)
    later = moment(trial=7, steps=1)
    board.see(later, rests=True)
    assert board.words() == []
    assert len(board.points("trail")) == 2
    assert all(len(board.points(f"last/{shape}")) == 0 for shape in OUTCOME_SHAPES.values())


def test_while_it_learns_on_nothing_is_held_up_for_the_trial_before() -> None:
    taken = moment(trial=7)
    way = way_of(taken, rests=False)
    assert (way.cells.tolist(), way.outcome) == ([taken.cell], None)


def test_at_the_very_start_the_predator_is_where_it_starts(board: Board) -> None:
    taken = moment()
    assert way_of(taken, rests=True).cells.tolist() == [taken.cell]
    board.see(taken, rests=True, named=True)
    assert board.words() == ["what it sees", "prey", "predator"]


def test_a_way_that_is_not_known_any_more_is_no_error(board: Board) -> None:
    taken = replace(moment(trial=7), paths=())
    board.see(taken, rests=True)
    assert board.words() == [ENDED[taken.ends[-1].outcome]]
    assert len(board.points("predator")) == 1


def test_names_say_what_a_hunt_came_to(board: Board) -> None:
    taken = moment(trial=7)
    board.see(taken, rests=True, named=True)
    assert board.words() == ["what it sees", "prey", ENDED[taken.ends[-1].outcome]]
    board.see(taken, Look(field=False), rests=True, named=True)
    assert "what it sees" not in board.words()


def test_where_another_hunt_is_watched_none_of_these_is_drawn(board: Board) -> None:
    taken = moment(trial=30, steps=3)
    board.see(taken, Look(paths=True), named=True)
    board.see(taken, Look(paths=True, hunts=False), named=True)
    names = ("predator", "halo", "trail", "rims", *map("ends/{}".format, OUTCOME_SHAPES.values()))
    assert all(len(board.points(name)) == 0 for name in names)
    assert not drawn(board.scene, "/board/paths").visible
    assert board.words() == []


# On the board


@pytest.mark.parametrize("frame", [FOLDED, OF_TRIAL, *range(8)])
def test_no_hunt_leaves_the_board_whatever_way_its_prey_faces(board: Board, frame: int) -> None:
    world, last = moment().world, SIZE - 1
    corners = [cell_at(world, x, y) for x in (0, 7, last) for y in (0, 7, last)]
    look = Look(frame=frame, paths=True)
    for heading in range(8):
        path = snapshot.TrialPath(heading, CAPTURE, np.array(corners))
        taken = replace(
            moment(),
            heading=heading,
            trail=np.array(corners),
            paths=(path,),
            ends=tuple(TrialEnd(0, cell, heading, CAPTURE) for cell in corners),
        )
        board.see(taken, look)
        for name in ("predator", "trail", "paths", "ends/circle", "rims"):
            places = board.points(name)[:, :2]
            assert len(places)
            np.testing.assert_allclose(
                places, kept_on_board(places, SPEC.world, folds(look)), atol=1e-5
            )
            low, high = edges(SPEC.world)
            assert ((places >= low - 1e-5) & (places <= high + 1e-5)).all()


def test_a_browser_that_is_told_the_same_again_is_sent_nothing(board: Board) -> None:
    taken = moment(trial=30, steps=3)
    board.see(taken, named=True)
    handle: Any = drawn(board.scene, "/board/predator")
    before = handle.points
    board.see(taken, named=True)
    assert handle.points is before
