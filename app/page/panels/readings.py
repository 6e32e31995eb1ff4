"""What one browser reads beside the board: the sentence, the numbers, the curve, the legend.

Everything here belongs to one browser, and so does how it wants to see things.
"""

import math
from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
import viser
from viser import uplot

from app.analysis.estimates import WINDOWS, Windows
from app.charts.page.svg import frame_html
from app.explain import sentence
from app.live.session import Status
from app.live.snapshot import Snapshot
from app.metrics.course import GREEDY_HUNTS, NO_CURVE, GreedyCurve
from app.page import keys
from app.page.inbox import Inbox, Intent
from app.page.panels import curve
from app.page.scene.board import FLAT_CAMERA, FLAT_TARGET
from app.page.widgets import Choice, assign
from app.picture.layer import Extras, Layer
from app.picture.layers import LAYERS
from app.picture.look import FOLDED, OF_TRIAL, Look
from app.picture.multiples import all_headings_png, small_multiples_html
from app.picture.options import option_names
from app.picture.shading import Scale
from app.picture.theme import DARK, LIGHT
from app.server.calls import Calls, address_of
from app.server.notices import close_modal, open_modal
from app.server.pulse import Reading
from app.util.html import element, escaped
from app.words.numbers import NONE, counted, in_short, shown_number, speed_in_words
from app.words.plain import HEADING_NAMES, plain
from learners import measures
from learners.measures import Curve

_SCALES: dict[str, Scale] = {"Steps to capture": "steps", "Linear in value": "linear"}
_FRAMES = {
    "Folded: mean of all headings": FOLDED,
    "Heading of the running trial": OF_TRIAL,
    **{f"Prey faces {name}": heading for heading, name in enumerate(HEADING_NAMES)},
}
_WIDTH = 330.0
_CURVE_PX = 146
"""Height of the curve with its axes: with it all has room on the smallest screen."""
_NUDGE = 0.01
"""Farther from where the camera is to be than viser takes to be there."""
_SENTENCE_LINES = 6
"""What the longest of the usual sentences take: what stands below them never moves."""
# A scroll bar lies over what it scrolls.
_LAYOUT = """<style>
[data-dock-edge] .mantine-ScrollArea-content:not(:has(.mantine-ScrollArea-content)) {
  padding-right: 8px; }
</style>"""


CurveData = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Steps, and two curves at them."""


def _number(label: str, value: str, hint: str) -> str:
    return (
        f'<div title="{escaped(hint)}">'
        f'<div style="opacity:0.65;font-size:0.78em;white-space:nowrap">{label}</div>'
        f'<div style="font-size:1.15em;font-variant-numeric:tabular-nums">{value}</div></div>'
    )


def headline_html(status: Status) -> str:
    """Title, the one sentence in a space of its own, and where a run of an experiment is from."""
    text = escaped(sentence.sentence(status))
    origin = ""
    if status.opened is not None:
        # A name may be long, and without a blank.
        origin = (
            '<div style="margin-top:0.4em;overflow-wrap:anywhere">'
            f"{escaped(sentence.provenance(status.opened))}</div>"
        )
    error = f"<b>{escaped(status.error)}</b>" if status.error else ""
    return (
        '<div style="padding:0.1em 0.7em"><div style="font-size:1.25em;font-weight:700">pounce'
        ' <span style="font-weight:400;font-size:0.62em;opacity:0.7">the timing of skills changes'
        " what is learned</span></div>"
        '<div style="margin-top:0.3em;line-height:1.35">'
        f'<div style="height:{1.35 * _SENTENCE_LINES:g}em;overflow-y:auto">{text}</div>'
        f"{error}{origin}</div></div>"
    )


def numbers_html(status: Status, viewers: int = 1, greedy: GreedyCurve = NO_CURVE) -> str:
    """The readings."""
    snapshot = status.snapshot
    greedy_reward, measured = math.nan, "not measured yet"
    if greedy.step.size:
        greedy_reward = float(greedy.reward[-1])
        measured = f"measured at trial {greedy.trial[-1]:,}, step {greedy.step[-1]:,}"
    caught = sentence.success_share(snapshot)
    reached = int((snapshot.value > 0).sum())
    parts = [
        _number("Trial", f"{snapshot.trial:,}", "Trials that have ended"),
        _number("Steps", f"{snapshot.step:,}", "Learning steps so far"),
        _number("Steps/s", in_short(status.steps_per_s), "Learning steps in the last second"),
        _number("Viewers", str(viewers), "Browsers that see and steer this learner"),
        _number(
            "Success",
            NONE if math.isnan(caught) else f"{caught:.0%}",
            f"Share of the last {measures.RECENT_TRIALS} trials that ended in capture",
        ),
        _number(
            "Reward",
            shown_number(snapshot.recent_reward, ".1f"),
            f"Mean reward per trial over the last {measures.RECENT_TRIALS}, random moves,"
            " explorations and all",
        ),
        _number(
            "Greedy",
            shown_number(greedy_reward, ".1f"),
            f"Mean reward of {GREEDY_HUNTS:,} hunts without random moves, in which nothing is"
            f" explored or learned; {measured}",
        ),
        _number(
            "States of value",
            f"{reached:,}",
            f"States worth more than 0, of {snapshot.value.size:,}",
        ),
    ]
    return (
        '<div style="display:grid;grid-template-columns:repeat(4,auto);gap:0.35em 0.6em;'
        f'justify-content:space-between;padding:0 0.7em">{"".join(parts)}</div>'
    )


def clock_html(reading: Reading, status: Status, viewers: int) -> str:
    """The honest clock."""
    behind = f"{reading.behind_s:.1f} s behind" if reading.behind_s > 0.05 else "up to date"
    seeing = counted(viewers, "viewer")
    return (
        '<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5">'
        f"{speed_in_words(status.steps_per_s)}; {reading.drawing_share:.0%} of the time is spent on"
        f" drawing.<br>This browser: {reading.frame_rate:.1f} frames/s, {reading.frames_sent} sent"
        f" and {reading.frames_skipped} skipped in 5 s, {behind}."
        f"<br>{seeing} of this session.</div>"
    )


class Texts:
    """What is read of a moment by those who look alike: found when it is first asked for."""

    def __init__(
        self,
        status: Status,
        look: Look,
        extras: Extras,
        n_viewers: int,
        former: "Texts | None" = None,
        greedy: GreedyCurve = NO_CURVE,
    ) -> None:
        """Begin; what costs much and is as it was in the ``former`` ones is taken from there."""
        history = status.snapshot.control.history
        if former is not None and former.status.snapshot.control.history is history:
            self.marks = former.marks
        else:
            self.marks = curve.marks_of(status.snapshot)
        self.status = status
        self.look = look
        self.extras = extras
        self.greedy = greedy
        self._curves: dict[Windows, CurveData] = {}
        self._n_viewers = n_viewers
        self._layer = LAYERS[look.layer]

    @cached_property
    def headline(self) -> str:
        """The sentence, and where a run of an experiment is from, as HTML."""
        return headline_html(self.status)

    @cached_property
    def numbers(self) -> str:
        """The readings, as HTML."""
        return numbers_html(self.status, self._n_viewers, self.greedy)

    @cached_property
    def caption(self) -> str:
        """What the layer shows, as HTML."""
        caption = self._layer.caption(self.status.snapshot, self.look, self.extras)
        return _captioned(caption, board_name(self.status, self._layer))

    @cached_property
    def legend(self) -> str:
        """The layer's legend, as HTML."""
        return self._layer.legend(self.status.snapshot, self.look, self.extras)

    @cached_property
    def multiples(self) -> str:
        """The layer at all headings, as HTML."""
        snapshot = self.status.snapshot
        return small_multiples_html(all_headings_png(snapshot, self.look, self._layer, self.extras))

    def curve(self, windows: Windows) -> CurveData:
        """Learning curve and greedy curve, as :func:`curve.data_of`."""
        if windows not in self._curves:
            self._curves[windows] = curve.data_of(self.status.snapshot, windows, self.greedy)
        return self._curves[windows]

    @cached_property
    def axes(self) -> tuple[uplot.Axis, ...]:
        """Axes of the learning curve, with its marks."""
        return curve.axes_of(self.status.snapshot, self.marks, self.look.theme)

    @cached_property
    def scales(self) -> dict[str, uplot.Scale]:
        """Scales of the learning curve."""
        return curve.scales_of(self.status.snapshot)


class Readings:
    """The panel of one browser."""

    def __init__(
        self,
        client: viser.ClientHandle,
        status: Status,
        calls: Calls,
        inbox: Inbox,
        wake: Callable[[], object],
    ) -> None:
        """``wake`` lets the render loop draw at once."""
        self._client = client
        self._gui = gui = client.gui
        self._calls, self._wake = calls, wake
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        self._windows: Windows = "steps"
        self._curve_shown: tuple[Curve, GreedyCurve] | None = None
        self._curve_key: tuple[object, ...] = ()
        self._names: tuple[str, ...] = ()
        """What a layer may be of."""
        snapshot = status.snapshot
        panel = gui.add_panel()
        panel.dock_left()
        panel.set_width(_WIDTH)
        with panel.add_tab("Now", icon=viser.Icon.EYE):
            gui.add_html(_LAYOUT + keys.table_html() + frame_html())
            self._headline = gui.add_html(headline_html(status))
            self._numbers = gui.add_html(numbers_html(status))
            layers = {layer.title: layer for layer in LAYERS.values()}
            self._layer = Choice(gui, "Layer", layers)
            self._about: Choice[str | None] = Choice(gui, "of", {})
            self._about.handle.visible = False
            self._caption = gui.add_html("")
            self._legend = gui.add_html("")
            self._curve_legend = gui.add_html("")
            self._curve = gui.add_uplot(
                curve.data_of(snapshot, self._windows, NO_CURVE),
                curve.series_of(LIGHT),
                axes=curve.axes_of(snapshot, curve.marks_of(snapshot), LIGHT),
                scales=curve.scales_of(snapshot),
                legend=uplot.Legend(show=False),
                height=_CURVE_PX,
            )
        with panel.add_tab("View", icon=viser.Icon.STACK_2):
            self._build_view()
        self.inspect_tab = panel.add_tab("Inspect", icon=viser.Icon.ZOOM_IN)
        """Where the inspection of a cell goes."""
        self.file_tab = panel.add_tab("File", icon=viser.Icon.FILE)
        """Where saving and loading goes."""
        with self.file_tab:
            self._clock = gui.add_html("")
            self._build_help()
        # The first ten have keys.
        for key, layer in zip(keys.LAYERS, LAYERS.values(), strict=False):
            command = gui.add_command(f"Layer: {layer.title}", hotkey=key.hotkey)
            command.on_trigger(Intent(partial(self._choose_layer, layer)))
        gui.add_command("Reset the camera", hotkey=keys.CAMERA.hotkey).on_trigger(
            Intent(lambda _, __: self.aim_camera())
        )
        self._dress()

    def _build_view(self) -> None:
        gui = self._gui
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

    def _build_help(self) -> None:
        button = self._gui.add_button("Keys (?)", icon=viser.Icon.KEYBOARD)
        button.on_click(Intent(lambda _, __: self.show_keys()))
        command = self._gui.add_command("Keys", hotkey=keys.LIST.hotkey)
        command.on_trigger(Intent(lambda _, __: self.show_keys()))
        closing = self._gui.add_command("Close the list", hotkey="escape")
        closing.on_trigger(Intent(lambda _, __: self._close_newest_list()))

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
        self._calls.leave(self._secret)

    def _address(self, words: str) -> str:
        return address_of(self._secret, words)

    def _called(self, words: str) -> None:
        """A link was clicked; whatever it says comes from the network."""
        verb, _, what = words.partition("/")
        if verb == "windows" and what in WINDOWS:
            self._windows = what
            self._wake()

    def _choose_layer(self, layer: Layer, *_: object) -> None:
        self._layer.choose(layer)

    @property
    def look(self) -> Look:
        """How this browser wants to see the board."""
        about = self._about.chosen
        return Look(
            theme=DARK if self._dark.value else LIGHT,
            layer=self._layer.chosen.key,
            option=self._names.index(about) if about in self._names else 0,
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

    def aim_camera(self) -> None:
        """The whole board from above."""
        camera = self._client.camera
        aim = {
            "up_direction": (0.0, 1.0, 0.0),
            "position": FLAT_CAMERA,
            "look_at": FLAT_TARGET,
        }
        with self._client.atomic():
            for part, value in aim.items():
                # viser sends nothing if it takes the camera to be there already; a page that is
                # about to say that it has been moved would go on moving.
                setattr(camera, part, np.array(value) + _NUDGE)
                setattr(camera, part, value)

    def update(self, texts: Texts, clock: str) -> None:
        """Show a moment."""
        snapshot, layer = texts.status.snapshot, LAYERS[texts.look.layer]
        self._offer_options(snapshot, layer)
        for handle, content in (
            (self._headline, texts.headline),
            (self._numbers, texts.numbers),
            (self._caption, texts.caption),
            (self._legend, texts.legend),
            (self._clock, clock),
        ):
            assign(handle, "content", content)
        self._show_curve(texts)
        self._show_multiples(texts)

    def _offer_options(self, snapshot: Snapshot, layer: Layer) -> None:
        names = option_names(snapshot)
        if layer.about == "skill":
            names = tuple(plain(name) for name in snapshot.spec.learner.skills)
        if names:
            self._names = names
            self._about.offer({name: name for name in names})
        assign(self._about.handle, "visible", layer.about != "nothing" and bool(names))

    def _show_multiples(self, texts: Texts) -> None:
        wanted = bool(self._multiples.value)
        assign(self._eight, "visible", wanted)
        if wanted:
            assign(self._eight, "content", texts.multiples)

    def _show_curve(self, texts: Texts) -> None:
        snapshot, theme = texts.status.snapshot, texts.look.theme
        legend = curve.legend_html(snapshot, self._windows, theme, self._address)
        assign(self._curve_legend, "content", legend)
        key = (texts.marks, theme, self._windows)
        shown = self._curve_shown
        # Kept, and not their ids, which other curves may have once these are gone.
        is_shown = shown and shown[0] is snapshot.curve and shown[1] is texts.greedy
        if is_shown and key == self._curve_key:
            return
        if key != self._curve_key:
            self._curve.series = curve.series_of(theme)
        self._curve_shown, self._curve_key = (snapshot.curve, texts.greedy), key
        self._curve.axes = texts.axes
        self._curve.scales = texts.scales
        self._curve.data = texts.curve(self._windows)

    def _dress(self) -> None:
        self._gui.configure_theme(
            dark_mode=bool(self._dark.value), show_logo=False, show_share_button=False
        )


def board_name(status: Status, layer: Layer) -> str:
    """What the board is for those who cannot see it."""
    size = status.snapshot.spec.world.size
    return (
        f"The board, {size} by {size} cells, the prey in its middle. Layer: {layer.title}."
        f" {sentence.sentence(status)}"
    )


def _captioned(caption: str, board: str) -> str:
    style = "padding:0 0.7em;font-size:0.85em;line-height:1.35"
    return element("div", caption, **{"data-board": board}, style=style)
