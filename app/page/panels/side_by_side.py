"""Opens runs side by side, and says that there are some; shared by all browsers."""

from collections.abc import Callable

import viser

from app.live.race import Race
from app.page.inbox import Intent
from app.page.widgets import CALM, add_hints, assign
from app.util.html import escaped

OpenSide = Callable[[viser.ClientHandle, bool], object]
"""Shows a browser runs side by side; whether they are to be the thesis's four."""


class SideBySide:
    """The folder, in the container that is current."""

    def __init__(self, gui: viser.GuiApi, open_side: OpenSide) -> None:
        with gui.add_folder("Side by side"):
            four = gui.add_button(
                "Race the thesis's four",
                icon=viser.Icon.COLUMNS,
                color=CALM,
                hint="The four learners of the thesis's Figure 4.1 on boards next to each other,"
                " step for step, from the same starts. The live run pauses.",
            )
            look = gui.add_button(
                "Runs side by side …",
                icon=viser.Icon.LAYOUT_GRID,
                color=CALM,
                hint="Two to four of: the live run, its branches, and presets with a seed (C).",
            )
            add_hints(gui, four, look)
            self._note = gui.add_html("", visible=False)
        four.on_click(Intent(lambda client, _: open_side(client, True)))
        look.on_click(Intent(lambda client, _: open_side(client, False)))

    def update(self, race: Race | None) -> None:
        """Say what runs there are, for those who look at something else."""
        names = [] if race is None else [entry.name for entry in race.status.entries]
        said = f"There are: {escaped(', '.join(names))}. Each browser may look at them, or not."
        assign(self._note, "visible", race is not None)
        assign(self._note, "content", f'<div class="pounce-note">{said if names else ""}</div>')
