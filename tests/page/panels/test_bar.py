"""The bar on the page: made once for all, with links of its own for each browser."""

import secrets
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
import viser

from app.charts.bar.model import Moment
from app.page.panels import bar
from app.page.panels.bar import BarPanel, Bars
from app.schedule.blocks import blocks_of
from app.server.calls import Calls
from learners.commands import FreezeSelection
from learners.run import Run
from tests.support.person import AtOnce, Person
from tests.support.schedules import AVOID, seen, small_run, to


def moment(run: Run, chosen: str = "") -> Moment:
    shot = seen(run)
    return Moment(shot, blocks_of(shot), chosen=chosen)


class Desk:
    """Bars of a run, and two browsers that show them."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.bars, self.calls = Bars(), Calls()
        self.chosen: list[str] = []
        client: Any = SimpleNamespace(gui=gui)
        inbox: Any = AtOnce()
        parts = self.bars, self.calls, inbox, self.chosen.append, lambda: None
        self.panels = [BarPanel(client, *parts), BarPanel(client, *parts)]

    def shown(self, browser: int = 0) -> str:
        panel = self.panels[browser]
        panel.update()
        return str(panel._handle.content)


@pytest.fixture
def desk(gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    names = iter(["anna", "bert"])
    monkeypatch.setattr(secrets, "token_urlsafe", lambda _: next(names))
    return Desk(gui)


def test_all_browsers_share_one_bar_and_each_has_links_of_its_own(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []

    def make(*parts: Any) -> str:
        made.append(draw(*parts))
        return made[-1]

    draw: Callable[..., str] = bar.bar_html
    monkeypatch.setattr(bar, "bar_html", make)
    desk.bars.take(moment(to(small_run(), 50)), 0)
    one, other = desk.shown(0), desk.shown(1)
    assert len(made) == 1
    assert one.replace("call/anna/", "call/bert/") == other
    assert 'template data-slot="bar"' in one
    assert "call/anna/plan%2Fintroduction%3Aavoid" in one


def test_each_browser_has_its_own_axis(desk: Desk) -> None:
    desk.bars.take(moment(to(small_run(), 50)), 0)
    assert "call/anna/axis%2Fsteps" in desk.shown(0)
    assert desk.calls.take("anna/axis/steps")
    assert "call/anna/axis%2Ftrials" in desk.shown(0)
    assert "call/bert/axis%2Fsteps" in desk.shown(1)
    for nonsense in ("axis/years", "axis", "open/steps", ""):
        assert desk.calls.take(f"anna/{nonsense}")
    assert "call/anna/axis%2Ftrials" in desk.shown(0)
    desk.panels[0].leave()
    assert not desk.calls.take("anna/axis/steps")


def test_a_click_on_a_block_chooses_it(desk: Desk) -> None:
    assert desk.calls.take(f"anna/plan/{AVOID}")
    assert desk.chosen == [AVOID]


def test_a_run_that_goes_on_is_drawn_now_and_then_and_an_answer_at_once(desk: Desk) -> None:
    run = small_run()
    for trial, now_s in ((50, 0.0), (51, 0.1)):
        desk.bars.take(moment(to(run, trial)), now_s)
        assert ">50</b>" in desk.shown()
    desk.bars.take(moment(to(run, 52)), 0.5)
    assert ">52</b>" in desk.shown()
    run.apply(FreezeSelection(True))
    desk.bars.take(moment(to(run, 53)), 0.51)
    assert "frozen by hand" in desk.shown()
    desk.bars.take(moment(run, AVOID), 0.52)
    assert "chosen" in desk.shown()


def test_a_bar_at_rest_is_not_made_again(desk: Desk) -> None:
    here = moment(to(small_run(), 50))
    desk.bars.take(here, 0)
    html = desk.bars.html("trials")
    desk.bars.take(here, 10)
    assert desk.bars.html("trials") is html
