"""What the page's script tells the lab by itself, and not because somebody clicked.

It tells that the board has been drawn (``app/web/drawn.js``), whether its browser wants the page
dark (``app/web/scheme.js``), and which link to a session has led to it (``app/web/share.js``). It
calls addresses that stand in a hidden element.
"""

from collections.abc import Callable
from functools import partial

import viser

from app.page.inbox import Inbox
from app.page.widgets import assign
from app.server.calls import Calls, address_of
from app.util.html import element

DRAWN = "drawn"
DARK, LIGHT = "dark", "light"
SHARED = "shared-"
"""With a ticket behind it."""


class Told:
    """What one browser's page tells. Made where its element is always in the page."""

    def __init__(
        self,
        gui: viser.GuiApi,
        calls: Calls,
        inbox: Inbox,
        drawn: Callable[[], object],
        wants_dark: Callable[[bool], object],
        came: Callable[[str], object],
    ) -> None:
        """``drawn`` is called when the board has been drawn, ``wants_dark`` with what is wanted.

        ``came`` is called with the ticket of what came in a link.
        """
        self._calls = calls
        self._drawn, self._wants_dark, self._came = drawn, wants_dark, came
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        self._handle = gui.add_html(str(self._html(is_dark=False)))

    def show(self, is_dark: bool) -> None:
        """Let the page know whether it is dark now, whoever wanted that."""
        assign(self._handle, "content", self._html(is_dark))

    def leave(self) -> None:
        """Be told nothing any more."""
        self._calls.leave(self._secret)

    def _html(self, is_dark: bool) -> str:
        addresses = {
            f"data-{words}-call": address_of(self._secret, words) for words in (DRAWN, DARK, LIGHT)
        }
        addresses["data-shared-call"] = address_of(self._secret, SHARED)
        scheme = DARK if is_dark else LIGHT
        return element("div", "", hidden="", **{"data-scheme": scheme}, **addresses)

    def _called(self, words: str) -> None:
        """Whatever it says comes from the network."""
        if words == DRAWN:
            self._drawn()
        elif words in (DARK, LIGHT):
            self._wants_dark(words == DARK)
        elif words.startswith(SHARED):
            self._came(words.removeprefix(SHARED))
