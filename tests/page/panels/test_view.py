"""How a browser wants to see the board, by its widgets."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest
import viser

from app.documents import presets
from app.live import snapshot
from app.page.panels.view import View
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.server.server import close_server, open_server
from learners.run import Run
from tests.support.person import Person


class Seen:
    """The widgets of a view, and what is made of them at a moment."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.view = View(cast(viser.ClientHandle, SimpleNamespace(gui=gui)))
        self.view.add_overlays()
        self._gui = gui
        self.moment = snapshot.take(Run(presets.load("timed", ["world.size=20"]), 1), "timed", 0)

    def widget(self, label: str) -> Any:
        return Person(self._gui).widget(label)

    def offers(self, label: str) -> bool:
        try:
            self.widget(label)
        except AssertionError:
            return False
        return True

    def show(self, layer: str) -> Look:
        self.view.update(self.moment)
        self.widget("Layer").value = LAYERS[layer].listed(self.moment.spec.learner)
        self.view.update(self.moment)
        return self.view.look


@pytest.fixture
def seen() -> Iterator[Seen]:
    server = open_server(port=0)
    yield Seen(server.gui)
    close_server(server)


def test_a_new_page_sees_the_board_as_a_look_is_unless_stated(seen: Seen) -> None:
    assert seen.view.look == Look()


def test_what_a_layer_does_not_heed_is_neither_offered_nor_part_of_the_look(seen: Seen) -> None:
    labels = {
        "frame": "Headings",
        "scale": "Value as",
        "fitted": "Fit colours",
        "flight": "Expects flight",
    }
    seen.widget("Fit colours").value = True
    seen.widget("Expects flight").value = True
    for key, layer in LAYERS.items():
        look = seen.show(key)
        offered = {field for field, label in labels.items() if seen.offers(label)}
        heeds = layer.heeds_of(seen.moment.spec.learner)
        assert offered == heeds
        assert look.fitted == ("fitted" in heeds)
        assert look.flight == ("flight" in heeds)
        assert look.frame == (FOLDED if "frame" in heeds else OF_TRIAL)


def test_one_of_all_headings_is_shown_alone(seen: Seen) -> None:
    seen.view.choose_heading(3)
    assert seen.show("value").frame == 3
    assert seen.widget("Headings").value == "Prey faces north-west"
    assert seen.offers("One of eight")
    seen.widget("Headings").value = "All headings, side by side"
    assert seen.show("value").frame == ALL
