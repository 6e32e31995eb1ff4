"""The bar as HTML: it takes whatever width it is given, and its texts keep their size.

Places are percents of the axis; only the curves are a stretched picture. What it looks like besides
is in ``app/web/bar.css``.
"""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from app.analysis.estimates import Axis
from app.charts.bar.axis import TimeAxis
from app.charts.bar.lanes import Label, Lane, Piece, Stretch
from app.charts.bar.marks import CHARACTER, Mark
from app.charts.bar.model import Band, Bar, Points
from app.charts.page.svg import Address, link
from app.picture.colours import css
from app.picture.theme import DARK, LIGHT, Theme
from app.util.html import escaped
from app.words.glossary import term
from app.words.numbers import counted, labelled_ticks

_WIDE: Final = 1000
"""Units of the picture of the curves from left to right, and from bottom to top."""
_HIGH: Final = 100
_MARGIN: Final = 0.06
"""Room beyond the ends of the axis of rewards, as a share of it, so that no number is cut."""
_MOST_REWARDS: Final = 3
_MANY_LANES: Final = 5
"""With more lanes than this each is lower."""


def bar_html(bar: Bar, address: Address) -> str:
    """The whole of it; ``address`` is what its links refer to.

    They call ``axis/UNIT``, and ``plan/ID`` for a block that lies ahead.
    """
    low = " low" if len(bar.lanes) > _MANY_LANES else ""
    rows = "".join(_lane(lane, address) for lane in bar.lanes)
    return (
        f'<div class="pounce-bar{low}" role="group" aria-label="Learning curve and schedule"'
        f' style="--lanes:{len(bar.lanes)}">{_STYLE}{_head(bar)}<div class="rows">'
        f'<div class="over">{"".join(map(_band, bar.bands))}</div>'
        f"{_curve(bar)}{rows}{_axis(bar.axis, address)}"
        f'<div class="over">{"".join(map(_mark, bar.marks))}{_playhead(bar.axis)}</div>'
        "</div></div>"
    )


def _colours(theme: Theme) -> str:
    roles = {"forced": theme.forced, "frozen": theme.frozen, "line": theme.lines}
    return ";".join(f"--bar-{role}:{css(colour)}" for role, colour in roles.items())


_STYLE: Final = (
    f"<style>.pounce-bar{{{_colours(LIGHT)}}}"
    f'[data-mantine-color-scheme="dark"] .pounce-bar{{{_colours(DARK)}}}</style>'
)
"""Colours that follow the page: all browsers are sent one bar, each has a theme of its own."""


def _percent(share: float) -> str:
    return f"{100 * share:.2f}".rstrip("0").rstrip(".") + "%"


def _span(first: float, until: float) -> str:
    return f"left:{_percent(first)};width:{_percent(until - first)}"


# --- The head: what is what, and what the axis is of ---------------------------------------------


def _head(bar: Bar) -> str:
    items = [
        _item("learned", "as it learns", _learned_hint(bar)),
        _item("greedy", "greedy", _greedy_hint(bar)),
    ]
    if bar.ghost is not None:
        items.append(_item("ghost", bar.ghost_name, bar.ghost_hint))
    kinds = {band.kind for band in bar.bands}
    if "forced" in kinds:
        items.append(_item("forced", term("forced exploration")))
    if "frozen" in kinds:
        items.append(_item("frozen", term("freeze", "frozen")))
    pieces = [piece for lane in bar.lanes for piece in lane.pieces]
    if any(piece.done < piece.until for piece in pieces):
        items.append(_item("planned", "planned", "Outlined: what the schedule has ahead."))
    if any(piece.by_hand for piece in pieces):
        items.append(_item("hand", "by hand", "Begun by hand, or not as the preset has it."))
    if bar.left_out:
        items.append(f"<span>{counted(bar.left_out, 'earlier change')} not drawn</span>")
    return f'<div class="head">{"".join(items)}</div>'


def _learned_hint(bar: Bar) -> str:
    return (
        "Mean reward of the trials that are learned from, random moves, explorations and all. Each"
        f" point is the mean over {bar.window}, where they ended."
    )


def _greedy_hint(bar: Bar) -> str:
    return (
        f"Mean reward of {bar.n_hunts:,} hunts with what was known at a moment: no random moves,"
        " nothing explored, nothing learned. Measured at the dots; dashed where they are far apart."
    )


def _item(kind: str, text: str, hint: str = "") -> str:
    title = f' title="{escaped(hint)}"' if hint else ""
    return f'<span class="item {kind}"{title}><i></i>{escaped(text)}</span>'


# --- The curve -----------------------------------------------------------------------------------


def _curve(bar: Bar) -> str:
    low, high = bar.rewards
    margin = _MARGIN * (high - low)
    bottom, height = low - margin, high - low + 2 * margin

    def up(reward: np.ndarray) -> np.ndarray:
        return np.clip((reward - bottom) / height, 0.0, 1.0)

    ticks = labelled_ticks(low, high, _MOST_REWARDS)
    numbers = "".join(
        f'<span style="bottom:{_percent((tick - bottom) / height)}">{text}</span>'
        for tick, text in ticks
    )
    levels = "".join(
        f'<path class="{"zero" if tick == 0 else "level"}"'
        f' d="M0 {_HIGH * (1 - (tick - bottom) / height):.1f}H{_WIDE}"/>'
        for tick, _ in ticks
    )
    ghost = "" if bar.ghost is None else _line("ghost", bar.ghost, up)
    return (
        '<div class="row curve"><div class="gutter"><span class="what">reward<br/>per trial</span>'
        f'<span class="numbers">{numbers}</span></div><div class="plot">'
        f'<svg viewBox="0 0 {_WIDE} {_HIGH}" preserveAspectRatio="none" role="img"'
        ' aria-label="Learning curve: reward per trial">'
        f"{levels}{ghost}{_line('learned', bar.learned, up)}{_greedy(bar, up)}</svg></div></div>"
    )


def _places(points: Points, up: Callable[[np.ndarray], np.ndarray]) -> list[str]:
    x, y = _WIDE * points.at, _HIGH * (1 - up(points.reward))
    return [f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True)]


def _line(kind: str, points: Points, up: Callable[[np.ndarray], np.ndarray]) -> str:
    places = _places(points, up)
    return f'<path class="{kind}" d="M{"L".join(places)}"/>' if places else ""


def _greedy(bar: Bar, up: Callable[[np.ndarray], np.ndarray]) -> str:
    """Dots where it was measured; the line between two that are far apart is dashed."""
    places = _places(bar.greedy, up)
    pairs = list(zip(places, places[1:], bar.greedy_gaps, strict=False))
    near = "".join(f"M{one}L{other}" for one, other, is_gap in pairs if not is_gap)
    far = "".join(f"M{one}L{other}" for one, other, is_gap in pairs if is_gap)
    # A line of no length has round ends, which no stretching makes oval.
    dots = "".join(f"M{place}h0" for place in places)
    parts = (("greedy", near), ("greedy far", far), ("greedy dots", dots))
    return "".join(f'<path class="{kind}" d="{path}"/>' for kind, path in parts if path)


# --- The lanes -----------------------------------------------------------------------------------


def _lane(lane: Lane, address: Address) -> str:
    name = escaped(lane.name)
    parts = (
        *map(_stretch, lane.presence),
        *(_piece(piece, address) for piece in lane.pieces),
        *map(_label, lane.labels),
    )
    return (
        f'<div class="row lane"><div class="gutter" title="{name}">{name}</div>'
        f'<div class="plot">{"".join(parts)}</div></div>'
    )


def _stretch(stretch: Stretch) -> str:
    ahead = " ahead" if stretch.is_ahead else ""
    return f'<i class="there{ahead}" style="{_span(stretch.first, stretch.until)}"></i>'


def _piece(piece: Piece, address: Address) -> str:
    """A block: solid as far as it has come, outlined from there on; a link if it can be changed."""
    kinds = [piece.kind, piece.half]
    kinds += ["idle"] if piece.is_idle else []
    kinds += ["hand"] if piece.by_hand else []
    kinds += ["chosen"] if piece.is_chosen else []
    share = (piece.done - piece.first) / (piece.until - piece.first or 1.0)
    if piece.done < piece.until or (piece.is_editable and piece.until == piece.first):
        kinds.append("ahead")
    hint = escaped(piece.hint)
    looks = (
        f' class="piece {" ".join(kinds)}" style="{_span(piece.first, piece.until)}" title="{hint}"'
    )
    inner = f'<i style="width:{_percent(min(share, 1.0))}"></i>'
    if not piece.is_editable:
        return f"<span{looks}>{inner}</span>"
    return link(address, f"plan/{piece.id}", inner, f'{looks} aria-label="{hint}: change it"')


def _label(label: Label) -> str:
    style = {
        "before": f"right:{_percent(1 - label.at)}",
        "after": f"left:{_percent(label.at)}",
        "within": f"left:{_percent(label.at)}",
    }[label.side]
    return (
        f'<span class="label {label.side}" style="{style};max-width:{_percent(label.room)}">'
        f"{_more(label.before)}{escaped(label.text)}{_more(label.after)}</span>"
    )


_MORE: Final = ' class="more"'


def _more(text: str) -> str:
    """What is said where the page is wide enough."""
    return f"<span{_MORE}>{escaped(text)}</span>" if text else ""


# --- What lies over the rows ---------------------------------------------------------------------


def _band(band: Band) -> str:
    ahead = " ahead" if band.is_ahead else ""
    return (
        f'<i class="band {band.kind}{ahead}" style="{_span(band.first, band.until)}"'
        f' title="{escaped(band.hint)}"></i>'
    )


def _mark(mark: Mark) -> str:
    """A line with its name, in a box as wide as that may be."""
    name = f"<b>{escaped(mark.name)}{_more(mark.more)}</b>" if mark.name else ""
    side, place = ("before", 1 - mark.at) if mark.is_before else ("after", mark.at)
    edge = "right" if mark.is_before else "left"
    return (
        f'<span class="mark {side}" style="{edge}:{_percent(place)};width:{_percent(mark.room)}"'
        f' title="{escaped(mark.hint)}"><i></i>{name}</span>'
    )


def _playhead(axis: TimeAxis) -> str:
    return f'<span class="playhead" style="left:{_percent(axis.now)}"></span>'


_UNITS: Final[Mapping[Axis, tuple[str, str]]] = {
    "trials": ("trial", "Curve and schedule against trials, in which the schedule is told"),
    "steps": (
        "steps",
        "Both against steps: a trial takes many at first, and few once it is learned",
    ),
}
"""What an axis is called, and what it is for."""


def _switch(unit: Axis, address: Address) -> str:
    """What the axis is of, and a link to the other kind."""
    return "".join(
        f'<b title="{hint}">{name}</b>'
        if each == unit
        else link(address, f"axis/{each}", name, f' title="{hint}"')
        for each, (name, hint) in _UNITS.items()
    )


def _axis(axis: TimeAxis, address: Address) -> str:
    here, now = axis.here, axis.now
    # The number of the playhead takes the place of those that it would cover.
    near = 1.35 * CHARACTER * (len(here) + 7) / 2
    numbers = "".join(
        f"<span{_MORE if abs(tick.at - now) < 2 * near else ''}"
        f' style="left:{_percent(tick.at)}">{tick.text}</span>'
        for tick in axis.ticks
        if abs(tick.at - now) > near
    )
    edge = " first" if now < near / 2 else " last" if now > 1 - near / 2 else ""
    return (
        f'<div class="row axis"><div class="gutter">{_switch(axis.unit, address)}</div>'
        f'<div class="plot">{numbers}'
        f'<b class="here{edge}" style="left:{_percent(now)}">{here}</b></div></div>'
    )
