"""The panel about a cell, with the widgets of a server to which no browser is connected."""

import contextlib
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.live.snapshot import Snapshot
from app.page.panels import inspection as panel
from app.page.panels.inspection import Inspection, board_points, cell_under, ring_radius
from app.picture.look import OF_TRIAL, Look
from app.picture.theme import DARK, LIGHT
from app.server.server import close_server, open_server
from sim.world import board_xy, cell_at
from tests.support.person import Person, drawn
from tests.support.tables import NORTH, WEST, way_from_behind


@pytest.fixture
def behind() -> Snapshot:
    return way_from_behind()


# From a place to a cell


@pytest.mark.parametrize("size", [20, 21, 120])
def test_a_place_on_the_board_lies_in_a_cell(size: int) -> None:
    unit, middle = 12.0 / size, size // 2
    for x, y in [(0, 0), (middle, middle), (size - 1, 3), (7, size - 1)]:
        east, north = (x - middle) * unit, (y - middle) * unit
        for shift in (-0.49, 0.0, 0.49):
            assert cell_under((east + shift * unit, north + shift * unit), size) == (x, y)


@pytest.mark.parametrize("place", [(6.1, 0.0), (0.0, -6.4), (-6.4, 0.0), (0.0, 1e300)])
def test_a_place_off_the_board_lies_in_no_cell(place: tuple[float, float]) -> None:
    assert cell_under(place, 20) is None


def test_points_and_places_agree(behind: Snapshot) -> None:
    cells = np.array([cell_at(behind.world, *xy) for xy in [(0, 0), (3, 17), (19, 19), (10, 9)]])
    for cell, point in zip(cells, board_points(behind.world, cells, 0.0), strict=True):
        east, north, _ = point.tolist()
        assert cell_under((east, north), 20) == board_xy(behind.world, int(cell))


def test_the_ring_goes_through_the_chosen_cell_or_the_start_zone(behind: Snapshot) -> None:
    world = behind.spec.world
    assert ring_radius(world, (13, 14)) == 5.0
    assert ring_radius(world, (10, 10)) == 1.0
    assert ring_radius(world, None) == pytest.approx(35 * 20 / 120)


# The panel


class Watcher(Person):
    """Somebody whose page counts how often something is sent."""

    def __init__(self, server: Any) -> None:
        super().__init__(server.gui)
        self.gui, self.scene = server.gui, server.scene
        self.sent = 0
        self.woken = 0

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        self.sent += 1
        yield

    def wake(self) -> None:
        self.woken += 1

    def points(self, name: str) -> np.ndarray:
        """Points of what inspection draws; the first is always there, and away."""
        return drawn(self.scene, f"/inspect/{name}").points


@pytest.fixture
def person() -> Iterator[Watcher]:
    server = open_server(port=0)
    yield Watcher(server)
    close_server(server)


@pytest.fixture
def inspection(person: Watcher) -> Inspection:
    client: Any = person
    return Inspection(client, person.gui.add_folder("Inspect"), person.wake)


def place_of(x: int, y: int) -> tuple[float, float]:
    return (x - 10) * 0.6, (y - 10) * 0.6


def choose(inspection: Inspection, x: int, y: int) -> None:
    """Click on a cell."""
    inspection.take_click(place_of(x, y), shift=False)


def hunt_from(inspection: Inspection, x: int, y: int) -> None:
    """Click on a cell with shift held."""
    inspection.take_click(place_of(x, y), shift=True)


def test_a_click_shows_its_cell(person: Watcher, inspection: Inspection, behind: Snapshot) -> None:
    inspection.take_click(place_of(6, 10), shift=False)
    assert person.woken == 1
    assert person.reads("Click a cell")
    inspection.update(behind, Look())
    assert person.reads("Cell (6, 10)")
    assert "<ol" not in person.html
    assert person.can_use("Hunt here")
    inspection.take_click((99.0, 0.0), shift=False)
    inspection.update(behind, Look())
    assert person.reads("Cell (6, 10)")


def test_why_is_shown_when_it_is_asked_for(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    choose(inspection, 3, 10)
    person.check("Why this value?")
    inspection.update(behind, Look())
    assert len(re.findall(r"<li\b", person.html)) == 7
    chain = person.points("chain/line")
    assert 1 < len(chain) < 1 + 7, "dashed"
    np.testing.assert_allclose(chain[-1, 1, :2], [0, 0], atol=1e-6)
    person.check("Why this value?", False)
    inspection.update(behind, Look())
    assert "<ol" not in person.html
    assert len(person.points("chain/line")) == 1


def test_nothing_is_sent_when_nothing_has_changed(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    choose(inspection, 6, 10)
    person.click("Sixteen hunts from a ring")
    inspection.update(behind, Look())
    sent = person.sent
    for _ in range(3):
        inspection.update(behind, Look())
    assert person.sent == sent
    inspection.update(replace(behind, step=behind.step + 1), Look())
    assert person.sent == sent + 1
    inspection.update(replace(behind, step=behind.step + 1), Look(theme=DARK))
    assert person.sent == sent + 3


def test_shift_hunts_from_the_cell(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    inspection.take_click(place_of(6, 10), shift=True)
    inspection.update(behind, Look())
    assert person.reads("Cell (6, 10)")
    assert person.reads("capture after 4 steps")
    assert len(person.points("hunts/line")) == 1 + 4
    hunt_from(inspection, 14, 10)
    inspection.update(behind, Look())
    assert person.reads("flight after 1 step")
    assert len(person.points("ends")) == 1 + 2


def test_the_heading_is_that_of_the_look(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    choose(inspection, 6, 10)
    inspection.update(behind, Look())
    assert person.reads("prey facing east")
    inspection.update(behind, Look(frame=NORTH))
    assert person.reads("prey facing north")
    inspection.update(replace(behind, heading=WEST), Look(frame=OF_TRIAL))
    assert person.reads("prey facing west")


def test_a_hunt_of_another_heading_shows_where_its_prey_faces(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    person.choose("Prey faces", "north")
    choose(inspection, 6, 10)
    inspection.update(behind, Look())
    person.click("Hunt here")
    inspection.update(behind, Look())
    assert person.reads("prey facing north")
    assert len(person.points("facing/line")) == 1 + 3
    inspection.update(behind, Look(frame=NORTH))
    assert len(person.points("facing/line")) == 1


def test_a_ring_takes_the_place_of_the_hunts_before(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    hunt_from(inspection, 6, 10)
    person.click("Sixteen hunts from a ring")
    inspection.update(behind, Look())
    assert person.reads("16 hunts")
    assert len(person.points("ends")) == 1 + 16


def test_clearing_forgets_everything(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    hunt_from(inspection, 6, 10)
    inspection.update(behind, Look())
    person.click("Clear")
    inspection.update(behind, Look())
    assert person.reads("Click a cell")
    assert not person.reads("from (")
    assert not person.can_use("Hunt here")
    assert len(person.points("cell/line")) == 1
    assert len(person.points("hunts/line")) == 1


def test_another_run_clears_the_hunts_and_keeps_the_cell(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    hunt_from(inspection, 6, 10)
    inspection.update(behind, Look())
    inspection.update(replace(behind, generation=2), Look())
    assert not person.reads("from (")
    assert person.reads("Cell (6, 10)")


def test_cells_off_the_grid_change_nothing(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    for x, y in [(-1, 3), (20, 3), (10**9, 0)]:
        choose(inspection, x, y)
        hunt_from(inspection, x, y)
    inspection.update(behind, Look())
    assert person.reads("Click a cell")
    assert not person.reads("from (")


def test_requests_do_not_pile_up(
    person: Watcher, inspection: Inspection, behind: Snapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, real = 0, panel.hunts_from

    def hunts(snapshot: Snapshot, starts: list[tuple[int, int]], *rest: Any) -> Any:
        nonlocal made
        made += len(starts)
        return real(snapshot, starts, *rest)

    monkeypatch.setattr(panel, "hunts_from", hunts)
    for _ in range(10_000):
        hunt_from(inspection, 6, 10)
    inspection.update(behind, Look())
    assert made == 32
    assert person.reads("16 hunts")
    assert len(person.points("ends")) == 1 + 16


def test_a_change_by_the_program_is_no_request(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    choose(inspection, 3, 10)
    person.widget("Why this value?").value = True
    inspection.update(behind, Look())
    assert "<ol" not in person.html


def test_the_themes_colours_are_used(
    person: Watcher, inspection: Inspection, behind: Snapshot
) -> None:
    hunt_from(inspection, 6, 10)
    inspection.update(behind, Look(theme=LIGHT))
    assert tuple(drawn(person.scene, "/inspect/ends").colors[1]) == LIGHT.capture
    inspection.update(behind, Look(theme=DARK))
    assert tuple(drawn(person.scene, "/inspect/ends").colors[1]) == DARK.capture
