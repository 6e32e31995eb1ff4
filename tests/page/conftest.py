"""An empty panel on a real server that nobody looks at, and somebody before it."""

from collections.abc import Iterator

import pytest
import viser

from app.server.server import close_server, open_server
from tests.support.costs import try_for_a_moment
from tests.support.person import Person


@pytest.fixture(autouse=True)
def short_pilots(monkeypatch: pytest.MonkeyPatch) -> None:
    try_for_a_moment(monkeypatch)


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
