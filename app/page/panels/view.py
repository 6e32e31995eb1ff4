"""How one browser wants to see the board: the choices of a panel."""

import viser

from app.page.inbox import Intent
from app.page.texts import Texts
from app.page.widgets import Choice, assign
from app.picture.look import FOLDED, OF_TRIAL, Look
from app.picture.shading import Scale
from app.picture.theme import DARK, LIGHT
from app.words.plain import HEADING_NAMES

_SCALES: dict[str, Scale] = {"Steps to capture": "steps", "Linear in value": "linear"}
_FRAMES = {
    "Folded: mean of all headings": FOLDED,
    "Heading of the running trial": OF_TRIAL,
    **{f"Prey faces {name}": heading for heading, name in enumerate(HEADING_NAMES)},
}


class View:
    """The choices of one browser."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._gui = gui = client.gui
        self._frame = Choice(gui, "Frame", _FRAMES)
        self._scale = Choice(gui, "Value as", _SCALES)
        self._fitted = gui.add_checkbox("Fit colours", False, hint="limits from what is there")
        self._field = gui.add_checkbox("Visual field", True)
        self._grid = gui.add_checkbox("Grid lines", True)
        self._sensors = gui.add_checkbox("Sensor rings", False)
        self._zone = gui.add_checkbox("Start zone", False)
        self._trail = gui.add_checkbox("Trail", True)
        self._paths = gui.add_checkbox("Last 20 paths", False)
        self._dark = gui.add_checkbox("Dark", False)
        self._multiples = gui.add_checkbox("All headings", False)
        self._eight = gui.add_html("", visible=False)
        self._dark.on_update(Intent(lambda _, __: self._dress()))
        self._dress()

    def look(self, layer: str, option: int) -> Look:
        """How to draw a layer, by its key, and of which option, by its index."""
        return Look(
            theme=DARK if self._dark.value else LIGHT,
            layer=layer,
            option=option,
            frame=self._frame.chosen,
            scale=self._scale.chosen,
            fitted=bool(self._fitted.value),
            field=bool(self._field.value),
            grid=bool(self._grid.value),
            sensors=bool(self._sensors.value),
            start_zone=bool(self._zone.value),
            trail=bool(self._trail.value),
            paths=bool(self._paths.value),
        )

    def update(self, texts: Texts) -> None:
        """Show a moment."""
        wanted = bool(self._multiples.value)
        assign(self._eight, "visible", wanted)
        if wanted:
            assign(self._eight, "content", texts.multiples)

    def set_dark(self, dark: bool) -> None:
        """Have the page dark, or light."""
        assign(self._dark, "value", dark)
        self._dress()

    def _dress(self) -> None:
        self._gui.configure_theme(
            dark_mode=bool(self._dark.value), show_logo=False, show_share_button=False
        )
