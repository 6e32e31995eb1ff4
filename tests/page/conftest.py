"""An empty panel on a real server that nobody looks at, and somebody before it."""

from collections.abc import Iterator

import pytest
import viser

from app.experiments import cost
from app.server.server import close_server, open_server
from tests.support.person import Person


@pytest.fixture(autouse=True)
def short_pilots(monkeypatch: pytest.MonkeyPatch) -> None:
    """What experiments take is found out in less time; nobody here asks whether it is right."""
    monkeypatch.setattr(cost, "_TRIED_S", 0.01)
    monkeypatch.setattr(cost, "_TRIED_STEPS", 10_000)
    monkeypatch.setattr(cost, "_PILOT_S", 0.01)


@pytest.fixture(scope="module")
def gui() -> Iterator[viser.GuiApi]:
    """The panel, which the tests of a module share."""
    server = open_server(port=0)
    yield server.gui
    close_server(server)


@pytest.fixture
def person(gui: viser.GuiApi) -> Person:
    """Somebody before an empty panel."""
    gui.reset()
    return Person(gui)
