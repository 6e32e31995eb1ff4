"""A question about octants on one browser's board, with a scene that nobody looks at."""

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import viser

from app.lessons.words import IN_ENGLISH
from app.live import snapshot
from app.page.lesson.board import BoardAsk, OctantsAsked
from app.picture.look import ALL, Look
from app.picture.octants import OCTANTS, middle, octant_at
from app.picture.theme import DARK
from app.server.server import close_server, open_server
from learners.run import Run
from tests.support.live import preset_of

LOOK = Look()
MOMENT = snapshot.take(Run(preset_of(), seed=1), "timed", 0)


class Viewer:
    """One browser, as far as something is drawn for it."""

    def __init__(self, server: Any) -> None:
        self.gui, self.scene = server.gui, server.scene
        self.changes = 0
        self.heard: list[frozenset[str]] = []
        self.board = BoardAsk(self)

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        self.changes += 1
        yield

    def ask(self, asked: OctantsAsked | None, look: Look = LOOK) -> None:
        self.board.ask(asked, self.heard.append)
        self.board.update(MOMENT, look)

    @property
    def handles(self) -> dict[str, Any]:
        return {
            name: handle
            for name, handle in self.scene._handle_from_node_name.items()
            if name.startswith("/asked/") and not isinstance(handle, viser.FrameHandle)
        }

    @property
    def words(self) -> list[str]:
        """What stands on the board."""
        return [h.text for h in self.handles.values() if hasattr(h, "text") and h.visible]

    def octants_of(self, name: str) -> set[str]:
        """The octants in which something is drawn."""
        points = np.asarray(self.handles[f"/asked/{name}"].points).reshape(-1, 3)
        there = points[points[:, 2] > 0]
        return {str(octant_at(float(x), float(y))) for x, y, _ in there}


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    server = open_server("127.0.0.1", 0, label="octants")
    yield Viewer(server)
    close_server(server)


def test_as_long_as_nothing_is_asked_nothing_is_drawn_and_clicks_mean_what_they_meant(
    viewer: Viewer,
) -> None:
    viewer.board.update(MOMENT, LOOK)
    assert not viewer.board.take_place((3.0, 0.0), MOMENT, LOOK)
    assert (viewer.handles, viewer.changes) == ({}, 0)


@pytest.mark.parametrize("octant", OCTANTS)
def test_a_click_chooses_an_octant_and_another_takes_it_back(viewer: Viewer, octant: str) -> None:
    viewer.ask(OctantsAsked())
    assert viewer.words == [IN_ENGLISH.octant(octant) for octant in OCTANTS]
    assert viewer.board.take_place(middle(octant, 3.0), MOMENT, LOOK)
    assert viewer.heard == [{octant}]
    viewer.ask(OctantsAsked(viewer.heard[-1]))
    assert viewer.octants_of("guess") == viewer.octants_of("hatch") == {octant}
    assert "outlined: your guess" in viewer.words
    assert viewer.board.take_place(middle(octant, 5.0), MOMENT, LOOK)
    assert viewer.heard[-1] == frozenset()


def test_the_preys_cell_is_in_none(viewer: Viewer) -> None:
    viewer.ask(OctantsAsked())
    assert viewer.board.take_place((0.1, -0.1), MOMENT, LOOK)
    assert viewer.heard == []


def test_where_the_prey_looks_otherwise_its_octants_are_turned(viewer: Viewer) -> None:
    north = LOOK._replace(frame=2)
    viewer.ask(OctantsAsked(), north)
    viewer.board.take_place((0.0, 3.0), MOMENT, north)
    assert viewer.heard == [{"e"}]
    viewer.ask(OctantsAsked(frozenset({"e"})), north)
    assert viewer.octants_of("guess") == {"n"}


def test_where_all_headings_are_side_by_side_nothing_can_be_chosen(viewer: Viewer) -> None:
    apart = LOOK._replace(frame=ALL)
    viewer.ask(OctantsAsked(frozenset({"e"})), apart)
    assert not viewer.board.take_place((3.0, 0.0), MOMENT, apart)
    assert viewer.handles == {}


def test_a_guess_that_is_locked_stays(viewer: Viewer) -> None:
    viewer.ask(OctantsAsked(frozenset({"w"}), locked=True))
    assert not viewer.board.take_place((3.0, 0.0), MOMENT, LOOK)
    assert viewer.heard == []
    assert viewer.octants_of("guess") == {"w"}


def test_the_run_and_many_runs_and_a_class_are_drawn_into_one_picture(viewer: Viewer) -> None:
    asked = OctantsAsked(frozenset({"w"}), locked=True)
    viewer.ask(asked)
    assert "/asked/fills" not in viewer.handles
    viewer.ask(asked._replace(run=frozenset({"nw"}), twenty={"w": 20, "nw": 7}))
    fills = viewer.handles["/asked/fills"]
    side = len(fills.image)
    west, north_west = (side // 2, side // 6), (3 * side // 4, side // 4)
    assert fills.image[north_west][3] > 0
    assert fills.image[west][3] == 0
    assert {"20 of 20", "7 of 20", "0 of 20", "blue: this run"} <= {*viewer.words}
    assert not {IN_ENGLISH.octant(octant) for octant in OCTANTS} & {*viewer.words}
    viewer.ask(asked._replace(others={"w": 0.75, "e": 0.25}))
    heat = [int(fills.image[side // 2, column][3]) for column in (3 * side // 10, 7 * side // 10)]
    assert heat[0] > 1.5 * heat[1] > 0
    assert {"75%", "25%", "0%", "orange: the class"} <= {*viewer.words}
    assert "blue: this run" not in viewer.words
    viewer.ask(asked)
    assert not fills.visible


def test_what_is_drawn_is_sent_once_and_gone_with_the_question(viewer: Viewer) -> None:
    asked = OctantsAsked(frozenset({"w"}), True, frozenset({"nw"}), {"w": 20}, 20, {"w": 0.5})
    viewer.ask(asked)
    viewer.ask(OctantsAsked(*asked))
    assert viewer.changes == 1
    viewer.ask(asked, LOOK._replace(theme=DARK))
    assert viewer.changes == 2
    assert viewer.octants_of("guess") == {"w"}
    viewer.ask(None)
    assert viewer.handles == {}
    assert viewer.board.asked is None
