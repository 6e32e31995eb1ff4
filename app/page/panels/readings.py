"""What one browser reads beside the board: the numbers and the legend.

Everything here belongs to one browser, and so does how it wants to see things.
"""

from collections.abc import Callable

import viser

from app.charts.page.svg import frame_html
from app.explain.sentence import said
from app.live.status import Status
from app.page import keys
from app.page.inbox import Inbox, Intent
from app.page.panels.view import View
from app.page.slots import slot_html
from app.page.told import Told
from app.page.tour import tour_html
from app.page.widgets import CALM, assign
from app.picture.theme import DARK
from app.player.headline import TASK_HTML, numbers_html, readings_html, sentence_html
from app.player.texts import Texts
from app.server.calls import Calls
from app.server.notices import close_modal, open_modal
from app.words import glossary

_WIDTH = 330.0
_LAST = 1e9
"""Order of what stands below all that is put into its tab later on."""
# A scroll bar lies over what it scrolls.
_LAYOUT = """<style>
[data-dock-edge] .mantine-ScrollArea-content:not(:has(.mantine-ScrollArea-content)) {
  padding-right: 8px; }
</style>"""


class Readings:
    """The panel of one browser."""

    def __init__(
        self,
        client: viser.ClientHandle,
        status: Status,
        calls: Calls,
        inbox: Inbox,
        drawn: Callable[[], object],
        came: Callable[[str], object],
    ) -> None:
        """``drawn`` is called when the page has drawn its first picture, ``came`` when a link to a
        session has led to it."""
        self._client = client
        self._gui = gui = client.gui
        # At the root of the main panel, which is there whatever tab is shown.
        self._task = gui.add_html(slot_html("task", TASK_HTML) + str(glossary.table_html()))
        self._sentence = gui.add_html(slot_html("sentence", sentence_html(status, said(status))))
        self._short = gui.add_html(slot_html("readings", readings_html(status.snapshot)))
        self._stage_legend = gui.add_html("")
        self._tours = 0
        """That were asked for."""
        self._tour = gui.add_html(slot_html("tour", tour_html(0)))
        self._told = Told(gui, calls, inbox, drawn, lambda dark: self.view.set_dark(dark), came)
        panel = gui.add_panel()
        panel.dock_left()
        panel.set_width(_WIDTH)
        with panel.add_tab("Now", icon=viser.Icon.EYE):
            gui.add_html(_LAYOUT + keys.table_html() + frame_html())
            self._numbers = gui.add_html(numbers_html(status))
            self.view = View(client)
            """What the board is to show."""
            self._caption = gui.add_html("")
            self._legend = gui.add_html("")
            self.view.add_overlays()
        self.inspect_tab = panel.add_tab("Inspect", icon=viser.Icon.ZOOM_IN)
        """Where the inspection of a cell goes."""
        self.file_tab = panel.add_tab("File", icon=viser.Icon.FILE)
        """Where saving and loading goes."""
        with self.file_tab:
            # Below what the tab is for.
            self._clock = gui.add_html("", order=_LAST)
            self._build_help()

    def _build_help(self) -> None:
        button = self._gui.add_button(
            "Keys (?)", icon=viser.Icon.KEYBOARD, color=CALM, order=_LAST - 1
        )
        button.on_click(Intent(lambda _, __: self.show_keys()))
        command = self._gui.add_command("Keys", hotkey=keys.LIST.hotkey)
        command.on_trigger(Intent(lambda _, __: self.show_keys()))
        closing = self._gui.add_command("Close the list", hotkey="escape")
        closing.on_trigger(Intent(lambda _, __: self._close_newest_list()))

        tour = self._gui.add_command("Tour of the page")
        tour.on_trigger(Intent(lambda _, __: self._begin_tour()))

    def _begin_tour(self) -> None:
        self._tours += 1
        assign(self._tour, "content", slot_html("tour", tour_html(self._tours)))

    def show_keys(self) -> None:
        """List the hotkeys, once."""
        modal = open_modal(self._client, "Keys")
        with modal:
            self._gui.add_html(keys.list_html())
            close = self._gui.add_button("Close")
        close.on_click(Intent(lambda _, __: close_modal(modal)))

    def _close_newest_list(self) -> None:
        # viser closes none by itself, and does not hand out those that are open.
        lists = list(self._gui._modal_handle_from_uuid.values())  # pyright: ignore[reportPrivateUsage]
        if lists:
            lists[-1].close()

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._told.leave()

    def update(self, texts: Texts, clock: str) -> None:
        """Show a moment."""
        for handle, content in (
            (self._sentence, slot_html("sentence", texts.sentence)),
            (self._short, slot_html("readings", texts.readings)),
            (self._numbers, texts.numbers),
            (self._caption, texts.caption),
            (self._legend, texts.legend),
            (self._stage_legend, slot_html("legend", texts.legend)),
            (self._clock, clock),
        ):
            assign(handle, "content", content)
        self.view.update(texts.status.snapshot)
        self._told.show(texts.look.theme is DARK)
