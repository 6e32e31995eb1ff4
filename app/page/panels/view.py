"""How one browser wants to see the board: its layer, what there is to choose for that, overlays.

What belongs to a layer stands with it; what a layer does not heed is not offered.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import viser

from app.live.snapshot import Snapshot
from app.page import keys
from app.page.inbox import Intent
from app.page.widgets import Choice, add_buttons, assign
from app.picture.layer import Layer
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.picture.options import option_names
from app.picture.shading import Scale
from app.picture.theme import DARK, LIGHT
from app.words.plain import HEADING_NAMES, plain
from learners.learner_spec import LearnerSpec

_SCALES: dict[str, Scale] = {"Steps to capture": "steps", "Its size": "linear"}
_FRAMES = {
    "All as one, prey looks right": FOLDED,
    "All headings, side by side": ALL,
    "As in the running trial": OF_TRIAL,
    **{f"Prey faces {name}": heading for heading, name in enumerate(HEADING_NAMES)},
}
_OVERLAYS: Sequence[tuple[str, str, str]] = (
    ("field", "Visual field", "The half-disc in which the prey notices the predator."),
    ("trail", "Trail", "The way that the predator has come in this hunt."),
    ("paths", "Last 20 paths", "The ways of the last hunts, coloured by how they ended."),
    ("start_zone", "Start zone", "The two circles between which hunts begin."),
    (
        "sensors",
        "Sensor rings",
        "What the predator can tell apart: all places in one box are one to it.",
    ),
    ("grid", "Grid lines", "A line at every tenth cell."),
)
"""Field of a look, label, and what it is."""


class View:
    """The choices of one browser."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Build the choice of a layer and what belongs to it, where the caller is building."""
        self._gui = gui = client.gui
        self._names: tuple[str, ...] = ()
        """What a layer may be of."""
        self._came_from_all = False
        self._learner: LearnerSpec | None = None
        """Whom it has been offered of."""
        layers = {layer.title: layer for layer in LAYERS.values()}
        self._layer = Choice(gui, "Layer", layers, hint="What the board shows.")
        self._about: Choice[str | None] = Choice(gui, "of", {}, hint="Which one it shows.")
        self._frame = Choice(
            gui,
            "Headings",
            _FRAMES,
            self._frame_chosen,
            hint="Where the prey looks: all eight turned into one picture, side by side, or one.",
        )
        self._back = add_buttons(
            gui, "One of eight", {"Back to all": ALL}, self._go_back, visible=False
        )
        self._scale = Choice(
            gui,
            "Value as",
            _SCALES,
            hint="As steps to a certain capture, or as the number that is learned.",
        )
        self._fitted = gui.add_checkbox(
            "Fit colours", False, hint="The colours go from the least to the most that is there."
        )
        self._flight = gui.add_checkbox(
            "Expects flight", False, hint="Hatches the places where it expects to be noticed."
        )
        # The first ten have keys.
        for key, layer in zip(keys.LAYERS, LAYERS.values(), strict=False):
            command = gui.add_command(f"Layer: {layer.title}", hotkey=key.hotkey)
            command.on_trigger(Intent(partial(self._choose_layer, layer)))

    def add_overlays(self) -> None:
        """Build the choice of what is drawn over every layer, where the caller is building."""
        gui = self._gui
        with gui.add_folder("Show", expand_by_default=False):
            self._overlays = {
                field: gui.add_checkbox(label, getattr(Look(), field), hint=hint)
                for field, label, hint in _OVERLAYS
            }
            self._dark = gui.add_checkbox("Dark", False, hint="Light writing on a dark page.")
        self._dark.on_update(Intent(lambda _, __: self._dress()))
        self._dress()

    @property
    def look(self) -> Look:
        """How to draw the board."""
        layer, about = self._layer.chosen, self._about.chosen
        look = Look(
            theme=DARK if self._dark.value else LIGHT,
            layer=layer.key,
            option=self._names.index(about) if about in self._names else 0,
            frame=self._frame.chosen,
            scale=self._scale.chosen,
            fitted=bool(self._fitted.value),
            flight=bool(self._flight.value),
            **{field: bool(box.value) for field, box in self._overlays.items()},
        )
        return layer.heeded(look, self._learner)

    def update(self, snapshot: Snapshot) -> None:
        """Offer what there is to choose at a moment."""
        learner = self._learner = snapshot.spec.learner
        self._layer.offer({layer.listed(learner): layer for layer in LAYERS.values()})
        layer = self._layer.chosen
        names = option_names(snapshot)
        if layer.about == "skill":
            names = tuple(map(plain, learner.sub_policies))
        if names:
            self._names = names
            self._about.offer({name: name for name in names})
        is_there = layer.lacks(learner) is None
        about = self._about.chosen
        heeds = layer.heeds_of(learner, names.index(about) if about in names else 0)
        offered: Sequence[tuple[Any, bool]] = (
            (self._about.handle, layer.about != "nothing" and bool(names) and is_there),
            (self._frame.handle, "frame" in heeds),
            (self._back, "frame" in heeds and self._came_from_all),
            (self._scale.handle, "scale" in heeds),
            (self._fitted, "fitted" in heeds),
            (self._flight, "flight" in heeds),
        )
        for handle, is_offered in offered:
            assign(handle, "visible", is_offered)

    def show(self, layer: str | None, frame: int | None) -> None:
        """Show another layer, by its key, and other headings; None for those that are shown."""
        if layer is not None:
            self._layer.choose(LAYERS[layer])
        if frame is not None:
            self._frame.choose(frame)
            self._came_from_all = False

    def choose_heading(self, heading: int) -> None:
        """Show one of those that were side by side alone."""
        self._frame.choose(heading)
        self._came_from_all = True

    def set_dark(self, dark: bool) -> None:
        """Have the page dark, or light."""
        assign(self._dark, "value", dark)
        self._dress()

    def _choose_layer(self, layer: Layer, *_: object) -> None:
        self._layer.choose(layer)

    def _frame_chosen(self, *_: object) -> None:
        self._came_from_all = False

    def _go_back(self, _: object, frame: int) -> None:
        self._frame.choose(frame)
        self._came_from_all = False

    def _dress(self) -> None:
        self._gui.configure_theme(
            dark_mode=bool(self._dark.value), show_logo=False, show_share_button=False
        )
