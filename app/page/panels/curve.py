"""The learning curve beside the board: its points, its axes, and the names of its marks."""

from typing import Literal, NamedTuple

import numpy as np
from viser import uplot

from app.analysis.estimates import WINDOWS, Windows
from app.charts.page.svg import Address, link
from app.live.snapshot import Snapshot, curve_window, curve_window_trials
from app.metrics.course import GREEDY_HUNTS, GreedyCurve
from app.page.greedy import EVERY_TRIALS
from app.page.panels.steering import command_in_words
from app.picture.colours import css
from app.picture.theme import Theme
from app.words.numbers import counted, ticks
from app.words.placing import Room
from app.words.plain import plain
from learners.commands import (
    Command,
    Event,
    Explore,
    FreezeSelection,
    FreezeSkills,
    Introduce,
    Remove,
    SetParameter,
    StopExploring,
)

_THICK, _THIN, _DOT = 2.0, 1.0, 4.0
"""Width of the learning curve and of the greedy one in pixels, and of the dots of the latter."""
_MAX_MARKS = 8
_SHORT = {"circle_clockwise": "circle", "circle_counterclockwise": "circle ccw"}
LONGEST_NAME = 21
"""Characters of the name of a mark."""
_MARK_FONT = "11px Arial, Helvetica, 'Liberation Sans', sans-serif"
_CHARACTER_PX, _MARK_ROW_PX = 5.6, 15
PLOT_PX, BESIDE_PLOT_PX = 215.0, 60.0
"""Width of the curve, and of the axis to its left, over which a name may reach."""
_MAX_MARK_ROWS = 3
_MOST_TICKS = 4
"""Numbered steps of the curve after 0."""
_MOST_REWARDS = 3
"""Numbered rewards after the lowest, for which there is always room."""


def _marked(snapshot: Snapshot) -> tuple[list[Event], list[Event]]:
    """Where a skill joined, and where something changed by hand.

    A skill that is there from the start has no mark, nor has an exploration that the schedule
    brings: it begins as the skill joins.
    """
    joins: list[Event] = []
    others: list[Event] = []
    for event in snapshot.control.history:
        if event.undone or not _mark_name(event.command):
            continue
        if isinstance(event.command, Introduce):
            if event.step > 0:
                joins.append(event)
        elif event.author == "hand":
            others.append(event)
    return joins, others


class Marks(NamedTuple):
    """Dashed lines across the curve."""

    at: tuple[float, ...]
    """Steps."""
    names: tuple[str, ...]
    left_out: int
    """How many more there are than there is room for."""


def marks_of(snapshot: Snapshot) -> Marks:
    """Where a skill joined or something changed by hand, and what it was."""
    joins, others = _marked(snapshot)
    left_out = max(len(joins) + len(others) - _MAX_MARKS, 0)
    # Of many, the joins stay: they are what the curve is looked at for.
    joins = joins[-_MAX_MARKS:]
    others = others[max(len(others) + len(joins) - _MAX_MARKS, 0) :]
    shown = sorted([*joins, *others], key=lambda event: event.number)
    at, names = (float(e.step) for e in shown), (_mark_name(e.command) for e in shown)
    return Marks(tuple(at), tuple(names), left_out)


def _mark_name(command: Command) -> str:
    """What a command is called at the curve, which is narrow; empty if it has no mark there."""

    def short(skill: str) -> str:
        return _SHORT.get(skill, plain(skill))

    match command:
        case Introduce(skill=skill):
            name = short(skill)
        case Explore(skill=skill):
            name = f"explore {short(skill)}"
        case StopExploring():
            name = "stop exploring"
        case Remove(skill=skill):
            name = f"remove {short(skill)}"
        case FreezeSelection(frozen=frozen):
            name = f"{'freeze' if frozen else 'unfreeze'} selection"
        case FreezeSkills(frozen=frozen):
            name = f"{'freeze' if frozen else 'unfreeze'} skills"
        case SetParameter():
            name = command_in_words(command)
        case _:
            name = ""
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def learned_of(snapshot: Snapshot, windows: Windows = "steps") -> tuple[np.ndarray, np.ndarray]:
    """Steps and mean reward of the learning curve, with at least two points."""
    curve = snapshot.curve if windows == "steps" else snapshot.trial_curve
    steps = curve.steps.astype(np.float64)
    reward = curve.reward
    keep = np.isfinite(reward)
    steps, reward = steps[keep], reward[keep]
    is_short = len(steps) > 2 and 2 * (steps[-1] - steps[-2]) < steps[1] - steps[0]
    if windows == "steps" and is_short:
        # A window that has just begun may hold a single trial, and would end the curve in a spike.
        steps, reward = steps[:-1], reward[:-1]
    if len(steps) < 2:
        steps = np.array([0.0, max(float(snapshot.step), 1.0)])
        reward = np.repeat(reward if len(reward) else [0.0], 2)[:2].astype(np.float64)
    return steps, reward


def data_of(
    snapshot: Snapshot, windows: Windows, greedy: GreedyCurve
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Steps, and the learning curve and the greedy one at them.

    The chart wants both curves at the same steps. Where the learning curve has no point of its own
    it has one on its line, so that it looks the same; the greedy one has none there, and the chart
    draws its line from one point to the next.
    """
    steps, reward = learned_of(snapshot, windows)
    # Points may be of later moments than a curve that is made anew now and then.
    known = greedy.step <= snapshot.step
    at, greedy_reward = greedy.step[known].astype(np.float64), greedy.reward[known]
    all_steps = np.union1d(steps, at)
    thick = np.interp(all_steps, steps, reward, left=np.nan, right=np.nan)
    thin = np.full(all_steps.size, np.nan)
    thin[np.searchsorted(all_steps, at)] = greedy_reward
    return all_steps, thick, thin


def legend_html(snapshot: Snapshot, windows: Windows, theme: Theme, address: Address) -> str:
    """What the two curves are, and links between the windows of the thick one.

    Args:
        snapshot: the moment.
        windows: those that are drawn.
        theme: of the page.
        address: what a link refers to, to call with ``windows/WINDOWS``.
    """
    learning = "Mean reward of the trials that are learned from: random moves, explorations and all"
    greedy = (
        f"Mean reward of {GREEDY_HUNTS:,} hunts with what was known at a moment: no random moves,"
        f" nothing explored, nothing learned. Measured about every {EVERY_TRIALS:,} trials, at the"
        " dots"
    )
    lines = (
        f'<span title="{learning}">{_sample(css(theme.capture), _THICK)} as it learns</span>'
        f'<span title="{greedy}">{_sample(css(theme.ink), _THIN, _DOT)} greedy: without random'
        " moves</span>"
    )
    widths = {
        "steps": f"{curve_window(snapshot.step):,} steps",
        "trials": f"{curve_window_trials(snapshot.trial):,} trials",
    }
    hints = {
        "steps": "each point is the mean over the trials that ended within so many steps",
        "trials": "each point is the mean of so many trials in a row, which shows short dips",
    }
    style = ' style="color:var(--pounce-link);text-decoration:none"'
    choices = (
        f'<b title="{hints[each]}">{widths[each]}</b>'
        if each == windows
        else link(address, f"windows/{each}", widths[each], f'{style} title="{hints[each]}"')
        for each in WINDOWS
    )
    row = "display:flex;flex-wrap:wrap;column-gap:0.9em"
    return (
        '<div class="pounce-curve" style="padding:0.25em 0.7em 0;font-size:0.78em;line-height:1.3">'
        f'<div style="{row}">{lines}</div>'
        f'<div style="{row}"><span>windows of</span>{"".join(choices)}</div></div>'
    )


def _sample(colour: str, width: float, dot: float = 0.0) -> str:
    """A piece of a curve."""
    middle = f'<circle cx="11" cy="5" r="{dot / 2:g}" fill="{colour}"/>' if dot else ""
    return (
        '<svg width="22" height="10" aria-hidden="true" style="vertical-align:middle">'
        f'<path d="M0 5H22" stroke="{colour}" stroke-width="{width:g}"/>{middle}</svg>'
    )


def axes_of(snapshot: Snapshot, marks: Marks, theme: Theme) -> tuple[uplot.Axis, ...]:
    """Axes of steps and of rewards; above the curve, the names of the marks."""
    ink = css(theme.ink)
    grid = uplot.Axis_Grid(show=True, stroke=css(theme.lines))
    at, names = marks.at, marks.names
    splits = tuple(ticks(0, _last_step(snapshot), _MOST_TICKS))
    axes = [
        uplot.Axis(
            scale="x",
            size=26,
            splits=splits,
            values=tuple(f"{step / 1e6:g} M" for step in splits),
            stroke=ink,
            grid=grid,
            label=f"{counted(marks.left_out, 'earlier mark')} not drawn" if marks.left_out else "",
            labelSize=16 if marks.left_out else 0,
        ),
        uplot.Axis(
            scale="y",
            splits=tuple(ticks(*_rewards(snapshot), _MOST_REWARDS)),
            stroke=ink,
            grid=grid,
            label="reward per trial",
            labelSize=16,
        ),
    ]
    for number, row in enumerate(mark_rows(at, names, _last_step(snapshot))):
        axes.append(
            uplot.Axis(
                scale="x",
                side=0,
                align=row.align,
                size=_MARK_ROW_PX,
                gap=2,
                font=_MARK_FONT,
                splits=at,
                values=tuple(row.names),
                stroke=ink,
                # The lines of all marks, once.
                grid=uplot.Axis_Grid(show=number == 0, stroke=ink, dash=(6.0, 4.0)),
                ticks=uplot.Axis_Ticks(show=False),
            )
        )
    return tuple(axes)


class MarkRow:
    """One row of names above the curve.

    Args:
        align: 1: names begin at their marks; 2: they end there.
        n_marks: how many marks there are, whose names may be in other rows.
    """

    def __init__(self, align: Literal[1, 2], n_marks: int) -> None:
        self.align: Literal[1, 2] = align
        self.names = [""] * n_marks
        """Of all marks; empty for those that have theirs in another row, or none."""
        self._room = Room(-BESIDE_PLOT_PX, PLOT_PX)

    def span_of(self, place: float, name: str) -> tuple[float, float]:
        """Where a name at a place would lie in this row, in pixels."""
        width = (len(name) + 1) * _CHARACTER_PX
        return (place, place + width) if self.align == 1 else (place - width, place)

    def takes(self, mark: int, place: float, name: str) -> bool:
        """Put a name into this row, if it has room: within the chart, and beside the others."""
        is_free = self._room.taken(*self.span_of(place, name))
        if is_free:
            self.names[mark] = name
        return is_free


def mark_rows(at: tuple[float, ...], names: tuple[str, ...], end: float) -> list[MarkRow]:
    """Rows of names, the first next to the curve: none is cut, and none lies over another.

    The newest marks come first; of many that are close, the oldest have no name.

    Args:
        at: steps of the marks.
        names: their names.
        end: last step of the axis, which begins at 0.
    """
    rows: list[MarkRow] = []
    for mark, name in reversed(list(enumerate(names))):
        fresh = [MarkRow(1, len(at)), MarkRow(2, len(at))] if len(rows) < _MAX_MARK_ROWS else []
        place = PLOT_PX * at[mark] / end
        row = next((row for row in [*rows, *fresh] if row.takes(mark, place, name)), None)
        if row in fresh:
            rows.append(row)
    return rows


def _last_step(snapshot: Snapshot) -> float:
    """Where the axis of steps ends."""
    return max(float(snapshot.step), 1_000.0)


def series_of(theme: Theme) -> tuple[uplot.Series, ...]:
    """The learning curve as a thick line, and the greedy one as a thin one with its points."""
    learning = uplot.Series(
        label="as it learns",
        stroke=css(theme.capture),
        width=_THICK,
        scale="y",
        points=uplot.Series_Points(show=False),
    )
    ink = css(theme.ink)
    greedy = uplot.Series(
        label="greedy",
        stroke=ink,
        width=_THIN,
        scale="y",
        points=uplot.Series_Points(show=True, size=_DOT, width=0.0, fill=ink),
    )
    return uplot.Series(label="steps"), learning, greedy


def scales_of(snapshot: Snapshot) -> dict[str, uplot.Scale]:
    """What the axes reach to."""
    low, high = _rewards(snapshot)
    return {
        "x": uplot.Scale(time=False, range=(0.0, _last_step(snapshot))),
        # Room for the topmost label.
        "y": uplot.Scale(range=(low, 1.08 * high)),
    }


def _rewards(snapshot: Snapshot) -> tuple[float, float]:
    """Ends of the axis of rewards."""
    world = snapshot.spec.world
    low, high = sorted((world.flight_reward, world.capture_reward))
    return min(low, 0.0), max(high, 1.0)
