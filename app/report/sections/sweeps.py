"""Sections of a report on what was swept: maps, points, and whether it makes a difference."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from app.analysis import estimates
from app.analysis.axles import Axle, grouped
from app.analysis.estimates import Contrast, Estimate, bootstrap_rng
from app.analysis.sweeps import (
    Place,
    Sweep,
    Values,
    differences,
    highest,
    highest_unseen,
    own_place,
    sweep_of,
)
from app.charts.model import Plane, Points, Series
from app.charts.paper.drawing import drawn
from app.charts.scales import colour_ends
from app.charts.wording import shown_estimate
from app.documents import presets
from app.documents.samples import is_draw
from app.metrics import SHARES, Metric
from app.report.document import Page, details, table
from app.report.parts import NO_INTERVAL, Shown, bars_note
from app.report.sections.effects import counts, swept_metrics, write_designs
from app.results.read import Group
from app.util.html import Markup, element
from app.words.numbers import NONE, shown_number

_WIDE = 0.1
"""A wide margin, as a share of the range of a quantity; the thesis's findings have the same."""
_CLOSE = _WIDE / 3
"""Below it, a difference is close."""


class _Swept(NamedTuple):
    """A sweep and its runs."""

    sweep: Sweep
    groups: Mapping[Place, Group]


def write_sweeps(page: Page, groups: Sequence[Group], shown: Shown) -> set[str]:
    """Write sections of what was swept.

    More settings than a plane has are shown one by one; their variants remain to be shown.

    Args:
        page: to write on.
        groups: all variants.
        shown: the numbers that are shown.

    Returns:
        The presets of which one setting or two were swept, or any number drawn at random.
    """
    by_preset: dict[str, list[Group]] = {}
    for group in groups:
        by_preset.setdefault(group.preset, []).append(group)
    there = {
        preset: found
        for preset, of_preset in by_preset.items()
        if (found := _swept(of_preset)) is not None
    }
    planes = {preset: swept for preset, swept in there.items() if len(swept.sweep.axles) == 2}
    rows: dict[tuple[str, tuple[Any, ...]], dict[str, _Swept]] = {}
    for preset, swept in there.items():
        if len(swept.sweep.axles) == 1:
            axle = swept.sweep.axles[0]
            rows.setdefault((axle.key, tuple(axle.values)), {})[preset] = swept
    for number, (preset, swept) in enumerate(planes.items(), 1):
        _plane_section(page, number, preset, swept, shown)
    for number, of_presets in enumerate(rows.values(), 1):
        _points_section(page, number, of_presets, shown)
    designs = [preset for preset in by_preset if preset not in there]
    searched = write_designs(page, {preset: by_preset[preset] for preset in designs}, shown)
    return {*there, *searched}


def _swept(groups: Sequence[Group]) -> _Swept | None:
    if any(is_draw(group.label) for group in groups):
        return None
    found = sweep_of([group.overrides for group in groups], groups[0].runs[0].settings)
    if found is None:
        return None
    return _Swept(found, {place: groups[index] for place, index in found.places.items()})


# --- Points --------------------------------------------------------------------------------------


def _points_section(
    page: Page, number: int, of_presets: Mapping[str, _Swept], shown: Shown
) -> None:
    parts = []
    (axle,) = next(iter(of_presets.values())).sweep.axles
    everything = [group for swept in of_presets.values() for group in swept.groups.values()]
    for metric in swept_metrics(everything, shown):
        page.tell(f"looking at what was swept: {metric.title}")
        series = [
            Series(
                preset,
                [
                    estimates.mean(swept.groups[index,].values(metric.column), bootstrap_rng())
                    for index in range(len(axle.values))
                ],
            )
            for preset, swept in of_presets.items()
        ]
        name = f"sweep_{number}_{metric.column}"
        bars = bars_note(estimate for line in series for estimate in line.estimates if estimate)
        small = page.small_print(f"Mean over n runs (seeds) at each point. {bars}")
        drawing = drawn(name, Points(axle, metric.label, series), small)
        parts.append(page.picture(name, f"{metric.label} against {axle.label}", drawing))
    page.say(f"Sweep over {axle.label}", *parts)


# --- Planes --------------------------------------------------------------------------------------


class _Reference(NamedTuple):
    """The cell of a plane that the others are set against."""

    place: Place
    name: str
    is_own: bool
    """Whether it is the preset's own setting, and not the highest cell."""


class _Plane(NamedTuple):
    """A quantity over the plane of two settings of a preset."""

    preset: str
    axles: tuple[Axle, Axle]
    metric: Metric
    values: Mapping[Place, Values]
    reference: _Reference
    differences: Mapping[Place, Contrast]
    """Of every cell but the reference."""
    span: float | None
    """Range of what a learner can do; None where the quantity has no such range."""

    @property
    def where(self) -> str:
        """The plane in words."""
        across, up = self.axles
        return f"in the plane of {across.label} and {up.label}"


def _plane_section(page: Page, number: int, preset: str, swept: _Swept, shown: Shown) -> None:
    parts: list[Markup] = []
    for metric in swept_metrics(swept.groups.values(), shown):
        page.tell(f"looking at what was swept: {metric.title}")
        plane = _plane(preset, swept, metric)
        cells = {
            at: estimates.mean([*v.values()], bootstrap_rng()) for at, v in plane.values.items()
        }
        parts += [
            _map(page, number, plane, cells),
            _difference_map(page, number, plane),
            _tally(plane),
            _in_words(plane, cells),
            details("The intervals", _intervals(plane, cells)),
        ]
    page.say(f"Sweep of {preset}", *parts)


def _plane(preset: str, swept: _Swept, metric: Metric) -> _Plane:
    across, up = swept.sweep.axles
    values = {place: group.by_seed(metric.column) for place, group in swept.groups.items()}
    reference = _reference(preset, swept, values)
    settings = swept.groups[reference.place].runs[0].settings
    found = differences(values, reference.place)
    return _Plane(preset, (across, up), metric, values, reference, found, _span(metric, settings))


def _reference(preset: str, swept: _Swept, values: Mapping[Place, Values]) -> _Reference:
    """The preset's own setting if it was run, else the cell that came out highest.

    The highest of many is where it is by luck as well; what was settled before is not.
    """
    axles, shipped = swept.sweep.axles, presets.shipped_settings(preset)
    if shipped is not None:
        runs = {place: group.runs[0] for place, group in swept.groups.items()}
        own = own_place(
            {place: run.overrides for place, run in runs.items()},
            {place: run.settings for place, run in runs.items()},
            shipped,
        )
        if own is not None and any(map(math.isfinite, values[own].values())):
            return _Reference(own, f"the preset's own setting ({_at(axles, own)})", True)
    place = highest(values)
    return _Reference(place, f"the highest cell ({_at(axles, place)})", False)


def _at(axles: Sequence[Axle], place: Place) -> str:
    """The values of the settings at a place."""
    pairs = zip(axles, place, strict=True)
    return " and ".join(grouped(axle.values[index]) for axle, index in pairs)


def _span(metric: Metric, settings: Mapping[str, Any]) -> float | None:
    if metric.kind != "performance":
        return None
    world = settings["world"]
    is_share = metric.column in SHARES
    return 1.0 if is_share else abs(world["capture_reward"] - world["flight_reward"])


def _map(page: Page, number: int, plane: _Plane, cells: Mapping[Place, Estimate]) -> Markup:
    name = f"plane_{number}_{plane.metric.column}"
    intervals = (
        "The 95 % bootstrap intervals are in the page and in the CSV."
        if any(cell.has_interval for cell in cells.values())
        else NO_INTERVAL
    )
    ends = colour_ends(cell.value for cell in cells.values())
    beyond = ends.in_words("cell", f"{shown_number(ends.low)} to {shown_number(ends.high)}")
    small = page.small_print(
        f"{plane.preset}. Mean over n = {counts(cells.values())} runs (seeds) in each cell."
        f" {intervals} Cells have equal sizes whatever the values of the settings. Hatched: not"
        f" run. {beyond}".strip()
    )
    drawing = drawn(name, Plane(plane.axles, plane.metric.label, cells), small)
    return page.picture(name, f"{plane.metric.label} of {plane.preset} {plane.where}", drawing)


def _difference_map(page: Page, number: int, plane: _Plane) -> Markup:
    name = f"difference_{number}_{plane.metric.column}"
    notes = [
        f"{plane.preset}. Framed: {plane.reference.name}, which all others are set against.",
        *([_BOLD] if any(found.has_interval for found in _estimates(plane)) else []),
        _pairing(plane),
        _chance(plane),
        "All differences share the runs of the framed cell: if those had luck, all others seem too"
        " low.",
        *([] if plane.reference.is_own else [_CURSE]),
        "Hatched: not run.",
    ]
    small = page.small_print(" ".join(notes))
    cells = {place: contrast.estimate for place, contrast in plane.differences.items()}
    what = f"{plane.metric.title}: difference to {plane.reference.name}"
    chart = Plane(plane.axles, what, cells, plane.reference.place, is_difference=True)
    drawing = drawn(name, chart, small)
    return page.picture(name, f"{what}, {plane.preset} {plane.where}", drawing)


_BOLD = "Bold: the 95 % bootstrap interval of the difference excludes 0."
_CURSE = (
    "The highest cell was chosen for having come out highest, which is luck in part, so the others"
    " are not really as far below it as they seem."
)


def _pairing(plane: _Plane) -> str:
    found = plane.differences.values()
    n = counts(contrast.estimate for contrast in found)
    if all(contrast.paired for contrast in found):
        return f"Differences are paired by seed (n = {n})."
    return f"Differences are paired by seed where enough are shared (n = {n})."


def _chance(plane: _Plane) -> str:
    """How often a cell is bold by chance, which is the more often the fewer seeds there are."""
    found = [contrast.estimate for contrast in plane.differences.values()]
    fewest = min((estimate.n for estimate in found if estimate.n > 1), default=0)
    if not fewest:
        return NO_INTERVAL
    # Below five runs the interval is the range of the differences, and they all lie on one side
    # of 0 once in 2 ** (n - 1) times.
    share = max(1 - estimates.CONFIDENCE, 2.0 ** (1 - fewest))
    percent = f"{100 * share:.0f} %"
    return (
        f"If no setting made any difference, about {percent} of the cells would be bold by"
        f" chance with {fewest} seeds: some {share * len(found):.0f} of {len(found)}."
    )


def _tally(plane: _Plane) -> Markup:
    """How many cells differ, and by how much."""
    found = _estimates(plane)
    n_single = sum(not estimate.has_interval for estimate in found)
    told = [estimate.value for estimate in found if estimate.excludes_zero]
    higher = _by_size("higher", [value for value in told if value > 0], plane.span)
    lower = _by_size("lower", [-value for value in told if value < 0], plane.span)
    rows = [
        *reversed(higher),
        ("cannot be told apart: the interval includes 0", len(found) - n_single - len(told)),
        *lower,
        *([("no interval: single runs", n_single)] if n_single else []),
    ]
    header = (
        f"{plane.metric.title} against {plane.reference.name}",
        "cells",
        f"share of {len(found)}",
    )
    return table(header, [(what, n, _share(n, found)) for what, n in rows])


def _by_size(word: str, sizes: Sequence[float], span: float | None) -> list[tuple[str, int]]:
    """Differences counted by their sizes, the small ones first."""
    if span is None:
        return [(word, len(sizes))]
    close, wide = _CLOSE * span, _WIDE * span
    small = sum(size < close for size in sizes)
    large = sum(size > wide for size in sizes)
    return [
        (f"{word} by less than {close:.2g}", small),
        (f"{word} by {close:.2g} to {wide:.2g}", len(sizes) - small - large),
        (f"{word} by more than {wide:.2g}", large),
    ]


def _in_words(plane: _Plane, cells: Mapping[Place, Estimate]) -> Markup:
    best = highest(plane.values)
    text = [
        f"The highest of {len(cells)} cells is {_at(plane.axles, best)}, with"
        f" {shown_estimate(cells[best])}."
    ]
    if best in plane.differences:
        difference = shown_estimate(plane.differences[best].estimate)
        text.append(f"Its difference to {plane.reference.name} is {difference}.")
    unseen = highest_unseen(plane.values)
    if math.isfinite(unseen):
        text.append(
            "The highest of many is so in part by luck. Chosen by all seeds but one, and measured"
            f" by the one left out, it has {unseen:.3g}."
        )
    if plane.span is not None:
        close, found = _CLOSE * plane.span, _estimates(plane)
        near = sum(abs(estimate.value) < close for estimate in found)
        wholly = sum(-close < estimate.low and estimate.high < close for estimate in found)
        surely = (
            f", and {wholly} ({_share(wholly, found)}) do with their whole interval"
            if any(estimate.has_interval for estimate in found)
            else ""
        )
        text.append(
            f"Of the other {len(found)} cells, {near} ({_share(near, found)}) lie"
            f" less than {close:.2g} from {plane.reference.name}{surely}."
        )
    # Small print is part of a picture, where it can be neither searched nor read aloud.
    text.append(_chance(plane))
    if not plane.reference.is_own:
        text.append(_CURSE)
    return element("p", " ".join(text))


def _intervals(plane: _Plane, cells: Mapping[Place, Estimate]) -> Markup:
    across, up = plane.axles
    rows = []
    for place, cell in sorted(cells.items()):
        found = plane.differences.get(place)
        values = (grouped(axle.values[k]) for axle, k in zip(plane.axles, place, strict=True))
        difference = NONE if found is None else shown_estimate(found.estimate)
        rows.append((*values, shown_estimate(cell), cell.n, difference))
    against = f"difference to {plane.reference.name} [95 %]"
    return table((across.label, up.label, f"{plane.metric.label} [95 %]", "n", against), rows)


def _estimates(plane: _Plane) -> list[Estimate]:
    """The differences that could be measured."""
    found = (contrast.estimate for contrast in plane.differences.values())
    return [estimate for estimate in found if estimate.n]


def _share(n: int, of: Sequence[Estimate]) -> str:
    return f"{100 * n / len(of):.0f} %" if of else NONE
