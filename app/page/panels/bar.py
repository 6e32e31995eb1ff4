"""The bar below the board: made once for all who want the same axis, and shown by each browser."""

from collections.abc import Callable
from functools import partial
from typing import Final

import viser

from app.analysis.estimates import Axis
from app.charts.bar.draw import bar_html
from app.charts.bar.model import Moment, bar_of
from app.charts.page.svg import frame_html
from app.page.greedy import EVERY_TRIALS
from app.page.inbox import Inbox
from app.page.slots import slot_html
from app.page.widgets import assign
from app.server.calls import Calls, address_of

_UNITS: Final[tuple[Axis, ...]] = ("trials", "steps")
_REDRAW_S: Final = 0.4
"""How often it is made anew when nothing but the run has gone on: as often as its curve."""
_ANYBODY: Final = "whoever-sees-this-bar"
"""Stands in its links for the secret of each browser."""

Choose = Callable[[str], object]
"""Chooses a block of the schedule, by its id, for those who edit it."""


class Bars:
    """The bar of the run that is shown. Changed by one thread."""

    def __init__(self) -> None:
        self._moment: Moment | None = None
        self._taken_s = 0.0
        self._drawn: dict[Axis, str] = {}

    def take(self, moment: Moment, now_s: float) -> None:
        """Take what is to be shown from now on; what only went on is taken now and then."""
        former = self._moment
        if former is not None:
            if _key(moment) == _key(former):
                return
            is_answer = _answers(moment) != _answers(former)
            if not is_answer and now_s - self._taken_s < _REDRAW_S:
                return
        self._moment, self._taken_s = moment, now_s
        self._drawn = {}

    def html(self, unit: Axis) -> str:
        """The bar along trials or steps, with links for nobody in particular; "" if there is none.

        It is the same object until it is another.
        """
        if self._moment is None:
            return ""
        if unit not in self._drawn:
            bar = bar_of(self._moment, unit, EVERY_TRIALS)
            self._drawn[unit] = bar_html(bar, partial(address_of, _ANYBODY))
        return self._drawn[unit]


def _answers(moment: Moment) -> tuple[object, ...]:
    """What changes when somebody has done something."""
    snapshot = moment.snapshot
    return (id(snapshot.spec), snapshot.generation, len(snapshot.control.history), moment.chosen)


def _key(moment: Moment) -> tuple[object, ...]:
    """All that a bar shows; of what is kept in the moment the ids are enough."""
    snapshot = moment.snapshot
    curves = id(snapshot.curve), id(moment.greedy), id(moment.ghost)
    return (*_answers(moment), snapshot.step, *curves)


class BarPanel:
    """The bar of one browser, in the slot below the board."""

    def __init__(
        self,
        client: viser.ClientHandle,
        bars: Bars,
        calls: Calls,
        inbox: Inbox,
        choose: Choose,
        wake: Callable[[], object],
    ) -> None:
        """``wake`` lets the render loop draw at once."""
        self._bars, self._calls = bars, calls
        self._choose, self._wake = choose, wake
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        self._unit: Axis = "trials"
        self._shown = ""
        # At the root of the main panel, which is there whatever tab is shown.
        client.gui.add_html(frame_html())
        self._handle = client.gui.add_html(slot_html("bar", ""))

    def update(self) -> None:
        """Show the bar that there is."""
        html = self._bars.html(self._unit)
        if html is not self._shown:
            self._shown = html
            mine = html.replace(_ANYBODY, self._secret)
            assign(self._handle, "content", slot_html("bar", mine))

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._calls.leave(self._secret)

    def _called(self, words: str) -> None:
        """A link was clicked; whatever it says comes from the network."""
        verb, _, what = words.partition("/")
        if verb == "axis" and what in _UNITS:
            self._unit = what
        elif verb == "plan":
            self._choose(what)
        self._wake()
