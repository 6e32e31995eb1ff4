"""Who presents: the browser whose view an audience is shown, and handing that on.

It is the first that was opened on this machine, or else the first of all, until another one takes
over. A page that is loaded anew comes as another browser, so whoever comes soon after the presenter
has gone has their place.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

import msgspec
import viser

from app.live.status import Status
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.classroom import Card, Classroom
from app.player.presented import Presented, Stand
from app.server.server import is_on_this_machine

RELOADED_S: Final = 10.0
"""Whoever comes within this time after the presenter has gone is taken for the same person."""


class _Bar(Protocol):
    """Of a browser's time bar, what is shown of it."""

    @property
    def bar(self) -> msgspec.Raw | None: ...

    @property
    def moment(self) -> dict[str, Any] | None: ...


class _Lesson(Protocol):
    """Of a browser's lesson, what a class reads of it."""

    @property
    def told(self) -> Card | None: ...


class Viewer(Protocol):
    """A browser, as far as it may present."""

    @property
    def number(self) -> int:
        """By which it is told from others."""
        ...

    @property
    def look(self) -> Look:
        """How it sees the board."""
        ...

    @property
    def time(self) -> _Bar:
        """Its time bar."""
        ...

    @property
    def lesson(self) -> _Lesson:
        """The lesson that it has before it."""
        ...


class Presenting:
    """Of one lab. The render loop alone has to do with it."""

    def __init__(self, stand: Stand | None, server: viser.ViserServer) -> None:
        """Prepare.

        Args:
            stand: who is shown what the presenter sees; None if there is no audience.
            server: of the browsers.
        """
        self.stand = stand
        self._server = server
        self._there: dict[int, bool] = {}
        """Browsers in the order in which they came, and whether each is on this machine."""
        self._presenter: int | None = None
        self._left_s: float | None = None
        """When the last one went, as long as nobody has their place."""
        self._last: Presented | None = None

    @property
    def classroom(self) -> Classroom | None:
        """The audience as a class that answers; None if it is none, or there is none."""
        return None if self.stand is None else self.stand.classroom

    @property
    def presenter(self) -> int | None:
        """Number of the browser that presents, if there is one."""
        return self._presenter

    def come(self, number: int) -> None:
        """Note that a browser has come."""
        self._there[number] = is_on_this_machine(self._server, number)
        if self._left_s is not None:
            self.take_over(number)

    def go(self, number: int, now_s: float) -> None:
        """Note that a browser has gone."""
        self._there.pop(number, None)
        if number == self._presenter:
            self._presenter, self._left_s = None, now_s

    def take_over(self, number: int) -> None:
        """Let a browser present from now on."""
        if number in self._there:
            self._presenter, self._left_s = number, None

    def show(
        self,
        seen: Mapping[Any, Status],
        live: Status,
        extras_of: Callable[[Any, Status], Extras],
        events_of: Callable[[int], tuple[int, ...]],
        now_s: float,
    ) -> None:
        """Show the audience what the presenter sees.

        Args:
            seen: what is true for each browser (:class:`Viewer`).
            live: how the live run stands.
            extras_of: what layers show besides, for one of them.
            events_of: steps of what happened in a line.
            now_s: the time.
        """
        if self.stand is None:
            return
        self._choose(now_s)
        viewer: Viewer | None = next((v for v in seen if v.number == self._presenter), None)
        if viewer is None:
            self.stand.show(live, self._left(live))
            return
        moment = viewer.time.moment
        if moment is None:
            # It has not been shown anything itself.
            return
        status = seen[viewer]
        self._last = Presented(
            status,
            viewer.look,
            extras_of(viewer, status),
            viewer.time.bar,
            moment,
            events_of(int(moment["line"])),
            card=viewer.lesson.told,
        )
        self.stand.show(live, self._last)

    def _choose(self, now_s: float) -> None:
        """Let the first one present if nobody does, and whoever did does not come again."""
        if self._presenter is not None or not self._there:
            return
        if self._left_s is not None and now_s - self._left_s < RELOADED_S:
            return
        local = [number for number, is_local in self._there.items() if is_local]
        self.take_over((local or list(self._there))[0])

    def _left(self, live: Status) -> Presented | None:
        """What the presenter left, who is away: what is live goes on."""
        if self._last is not None:
            status = live if self._last.status.behind is None else self._last.status
            self._last = self._last._replace(status=status, is_away=True)
        return self._last

    def close(self) -> None:
        """Let nobody look any more."""
        if self.stand is not None:
            self.stand.close()
