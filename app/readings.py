"""What one browser reads beside the board: the sentence, the numbers, the curve, the legend.

Everything here belongs to one browser, and so does how it wants to see things.
"""

import math
from html import escape

import numpy as np
import viser
from viser import uplot

from app import narrate, pictures
from app.board import Look
from app.door import guarded
from app.narrate import plain
from app.pictures import DARK, LIGHT, Theme
from app.session import Status
from app.snapshot import Snapshot
from learners import measures

_SCALES: dict[str, pictures.Scale] = {"Steps to capture": "steps", "Linear in value": "linear"}
_STEP_TICKS = (400, 200, 100, 50, 20, 5, 0)
_WIDTH = 330.0
_MAX_MARKS = 8


def look_of(dark: bool, scale: str, trail: bool) -> Look:
    """The look that the widgets of a browser ask for."""
    return Look(DARK if dark else LIGHT, _SCALES[scale], trail)


def _rate(steps_per_s: float) -> str:
    if steps_per_s >= 1e6:
        return f"{steps_per_s / 1e6:.1f} M"
    if steps_per_s >= 1e4:
        return f"{steps_per_s / 1e3:.0f} k"
    return f"{steps_per_s:,.0f}"


def _number(label: str, value: str, hint: str) -> str:
    return (
        f'<div title="{escape(hint)}"><div style="opacity:0.65;font-size:0.78em">{label}</div>'
        f'<div style="font-size:1.15em;font-variant-numeric:tabular-nums">{value}</div></div>'
    )


def headline_html(status: Status) -> str:
    """Title and the one sentence."""
    text = escape(narrate.sentence(status))
    error = f"<br><b>{escape(status.error)}</b>" if status.error else ""
    return (
        '<div style="padding:0.1em 0.7em"><div style="font-size:1.25em;font-weight:700">pounce'
        ' <span style="font-weight:400;font-size:0.62em;opacity:0.7">the timing of skills changes'
        " what is learned</span></div>"
        f'<div style="min-height:5.6em;margin-top:0.3em;line-height:1.35">{text}{error}</div></div>'
    )


def numbers_html(status: Status) -> str:
    """The readings."""
    snapshot = status.snapshot
    caught = narrate.success_share(snapshot)
    reached = int((snapshot.value > 0).sum())
    parts = [
        _number("Trial", f"{snapshot.trial:,}", "Trials that have ended"),
        _number("Steps", f"{snapshot.step:,}", "Learning steps so far"),
        _number("Steps/s", _rate(status.steps_per_s), "Learning steps in the last second"),
        _number(
            "Success",
            "&ndash;" if math.isnan(caught) else f"{caught:.0%}",
            f"Share of the last {measures.RECENT_TRIALS} trials that ended in capture",
        ),
        _number(
            "States of value",
            f"{reached:,} <span style='opacity:0.6;font-size:0.75em'>of"
            f" {snapshot.value.size:,}</span>",
            "States worth more than 0",
        ),
    ]
    return (
        '<div style="display:grid;grid-template-columns:auto auto auto;gap:0.35em 0.9em;'
        f'padding:0 0.7em">{"".join(parts)}</div>'
    )


def legend_html(look: Look, snapshot: Snapshot) -> str:
    """What the colours mean, with the limits of the scale."""
    theme, world = look.theme, snapshot.spec.world
    bar = pictures.gradient_css(pictures.gain_colours())
    if look.scale == "steps":
        title = "Value of a state, as steps to certain capture"
        ticks = [(float(pictures.nearness(np.float64(n))), f"{n}") for n in _STEP_TICKS]
    else:
        title = f"Value of a state, 0 to {world.capture_reward:g}"
        ticks = [(k / 4, f"{world.capture_reward * k / 4:g}") for k in range(5)]
    labels = "".join(
        f'<span style="position:absolute;left:{100 * at:.1f}%;transform:translateX('
        f'{-100 * at:.0f}%)">{text}</span>'
        for at, text in ticks
    )
    worst = pictures.loss_colours(np.linspace(0.0, 1.0, 12), theme)
    swatch = (
        '<span style="display:inline-block;width:{w};height:0.8em;margin-right:0.35em;'
        'border-radius:2px;vertical-align:-0.1em;background:{c}"></span>'
    )

    def dot(colour: tuple[int, int, int], text: str) -> str:
        return f"{swatch.format(w='0.8em', c=pictures.css(colour))}{text} &nbsp; "

    return (
        f'<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5"><div>{title}</div>'
        f'<div style="height:0.9em;border-radius:3px;background:{bar}"></div>'
        f'<div style="position:relative;height:1.5em">{labels}</div>'
        f"<div>{swatch.format(w='5em', c=pictures.gradient_css(worst))}expects flight, 0 to"
        f" {world.flight_reward:g} &nbsp; {swatch.format(w='0.8em', c=pictures.css(theme.unknown))}"
        "not known</div>"
        f"<div>{dot(theme.capture, 'capture')}{dot(theme.flight, 'flight')}"
        f"{dot(theme.timeout, 'time-out')}{dot(theme.predator, 'predator')}</div>"
        '<div style="opacity:0.7">The board is turned so that the prey looks right; each place'
        " shows the mean over its eight headings. The half-disc is what the prey sees.</div></div>"
    )


def curve_marks(snapshot: Snapshot) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Steps at which a skill joined, and its name; none for those present from the start."""
    joined = [entry for entry in snapshot.control.introductions if entry.step > 0][-_MAX_MARKS:]
    return tuple(float(e.step) for e in joined), tuple(plain(e.skill) for e in joined)


def curve_data(snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Steps and mean reward of the learning curve, with at least two points."""
    steps = snapshot.curve.steps.astype(np.float64)
    reward = snapshot.curve.reward
    keep = np.isfinite(reward)
    steps, reward = steps[keep], reward[keep]
    if len(steps) < 2:
        steps = np.array([0.0, max(float(snapshot.step), 1.0)])
        reward = np.repeat(reward if len(reward) else [0.0], 2)[:2].astype(np.float64)
    return steps, reward


def _axes(snapshot: Snapshot, theme: Theme) -> tuple[uplot.Axis, ...]:
    ink, grid = pictures.css(theme.ink), {"show": True, "stroke": pictures.css(theme.lines)}
    at, names = curve_marks(snapshot)
    ticks = _millions(snapshot.step)
    axes = [
        uplot.Axis(
            scale="x",
            splits=ticks,
            values=tuple(f"{tick / 1e6:g} M" for tick in ticks),
            stroke=ink,
            grid=grid,
        ),
        uplot.Axis(scale="y", stroke=ink, grid=grid, label="reward per trial", labelSize=16),
    ]
    if at:
        axes.append(
            uplot.Axis(
                scale="x",
                side=0,
                splits=at,
                values=names,
                stroke=ink,
                grid={"show": True, "stroke": ink, "dash": (6.0, 4.0)},
                ticks={"show": False},
            )
        )
    return tuple(axes)


def _millions(steps: int) -> tuple[float, ...]:
    """About four round marks between 0 and a number of steps."""
    rough = max(steps, 1_000) / 4
    power = 10 ** math.floor(math.log10(rough))
    width = next(power * k for k in (1, 2, 5, 10) if power * k >= rough)
    return tuple(k * float(width) for k in range(6) if k * width <= max(steps, 1_000))


class Readings:
    """The panel of one browser."""

    def __init__(self, client: viser.ClientHandle, status: Status) -> None:
        self._gui = client.gui
        self._curve_key: tuple[object, ...] = ()
        panel = self._gui.add_panel()
        panel.dock_left()
        panel.set_width(_WIDTH)
        snapshot = status.snapshot
        with panel.add_tab("What is going on", icon=viser.Icon.EYE):
            self._headline = self._gui.add_html(headline_html(status))
            self._numbers = self._gui.add_html(numbers_html(status))
            self._curve = self._gui.add_uplot(
                curve_data(snapshot),
                (uplot.Series(label="steps"), self._line(LIGHT)),
                axes=_axes(snapshot, LIGHT),
                scales=self._scales(snapshot),
                legend=uplot.Legend(show=False),
                height=210,
            )
            self._legend = self._gui.add_html("")
            self._scale = self._gui.add_dropdown("Colours", tuple(_SCALES))
            self._dark = self._gui.add_checkbox("Dark", False)
            self._trail = self._gui.add_checkbox("Trail", True)
        self._dark.on_update(guarded(lambda _: self._dress()))
        self._dress()

    @property
    def look(self) -> Look:
        """How this browser wants to see the board."""
        return look_of(bool(self._dark.value), str(self._scale.value), bool(self._trail.value))

    def update(self, status: Status) -> None:
        """Show a moment."""
        look = self.look
        for handle, content in (
            (self._headline, headline_html(status)),
            (self._numbers, numbers_html(status)),
            (self._legend, legend_html(look, status.snapshot)),
        ):
            if handle.content != content:
                handle.content = content
        self._show_curve(status.snapshot, look.theme)

    def _show_curve(self, snapshot: Snapshot, theme: Theme) -> None:
        key = (snapshot.generation, id(snapshot.curve), curve_marks(snapshot), theme is DARK)
        if key == self._curve_key:
            return
        if key[2:] != self._curve_key[2:]:
            self._curve.series = (uplot.Series(label="steps"), self._line(theme))
        self._curve_key = key
        self._curve.axes = _axes(snapshot, theme)
        self._curve.scales = self._scales(snapshot)
        self._curve.data = curve_data(snapshot)

    def _line(self, theme: Theme) -> uplot.Series:
        return uplot.Series(
            label="reward per trial", stroke=pictures.css(theme.capture), width=2, scale="y"
        )

    def _scales(self, snapshot: Snapshot) -> dict[str, uplot.Scale]:
        world = snapshot.spec.world
        low, high = sorted((world.flight_reward, world.capture_reward))
        return {
            "x": uplot.Scale(time=False, range=(0.0, max(float(snapshot.step), 1_000.0))),
            "y": uplot.Scale(range=(min(low, 0.0), max(high, 1.0))),
        }

    def _dress(self) -> None:
        self._gui.configure_theme(
            dark_mode=bool(self._dark.value), show_logo=False, show_share_button=False
        )
