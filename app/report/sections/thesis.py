"""Sections of a report on the thesis's experiments: its figures, and a verdict on each finding."""

import math
from collections.abc import Sequence

from app.analysis import estimates
from app.analysis.estimates import Axis, Windows, bootstrap_rng
from app.charts.model import Panel
from app.charts.paper.drawing import drawn
from app.charts.read import line_of, value_maps_of
from app.charts.styles import THESIS_STYLES
from app.charts.wording import shown_estimate
from app.metrics import Metric
from app.report.document import Page, table
from app.report.headline import lead_with_thesis
from app.report.parts import Shown, curve_pictures
from app.report.sections.findings import write_findings
from app.report.sections.passages import passages_picture
from app.report.sections.runs import Row, runs_picture
from app.results import spread, thesis
from app.results.read import Reader, Trace
from app.results.thesis import Placed
from app.util.html import Markup, element


def write_thesis(page: Page, reader: Reader, placed: Placed, shown: Shown) -> None:
    """Write sections on the runs of the thesis's learners in its worlds.

    Args:
        page: to write on.
        reader: of their logs.
        placed: the runs.
        shown: the numbers that are shown of them.
    """
    lead_with_thesis(page, reader, placed, shown.horizon)
    _thesis_figures(page, reader, placed, shown.every)
    _passages(page, placed)
    _value_spread(page, reader, placed)
    write_findings(page, reader, placed)
    _window_means(page, reader, placed)


def _thesis_figures(page: Page, reader: Reader, placed: Placed, metrics: Sequence[Metric]) -> None:
    for name, (title, worlds) in thesis.FIGURES.items():
        here = [world for world in worlds if any(place[0] == world for place in placed)]
        if not here or (len(worlds) > 1 and len(here) < 2):
            continue

        def panels(axis: Axis, windows: Windows, here: Sequence[str] = here) -> list[Panel]:
            return [_thesis_panel(reader, placed, world, axis, windows) for world in here]

        rows = [
            Row(
                f"{world}: {learner_title}" if len(here) > 1 else learner_title,
                placed[world, learner],
                THESIS_STYLES[learner],
            )
            for world in here
            for learner, learner_title in thesis.LEARNER_TITLES.items()
            if (world, learner) in placed
        ]
        caption = f"Every run of {title.partition(':')[0]}"
        page.say(
            title,
            curve_pictures(page, reader, name, title, panels),
            runs_picture(page, f"{name}_runs", caption, rows, metrics),
        )


def _thesis_panel(
    reader: Reader, placed: Placed, world: str, axis: Axis, windows: Windows
) -> Panel:
    lines = [
        line_of(
            reader, thesis.LEARNER_TITLES[learner], placed[world, learner], axis, style, windows
        )
        for learner, style in THESIS_STYLES.items()
        if (world, learner) in placed
    ]
    return Panel(thesis.WORLD_TITLES[world], lines)


def _passages(page: Page, placed: Placed) -> None:
    """How soon the thesis's learners get somewhere, in each world."""
    pictures: list[Markup] = []
    for number, (world, title) in enumerate(thesis.WORLD_TITLES.items(), 1):
        variants = [
            (thesis.LEARNER_TITLES[learner], placed[world, learner], style)
            for learner, style in THESIS_STYLES.items()
            if (world, learner) in placed
        ]
        caption = f"Share of runs that have got there: {title}"
        if variants:
            pictures.append(passages_picture(page, f"passages_world_{number}", caption, variants))
    if any(pictures):
        page.say("How soon it is reached", *pictures)


def _value_spread(page: Page, reader: Reader, placed: Placed) -> None:
    """Where the timed learner knew of a way to capture, at the moments that the thesis names."""
    runs = placed.get(spread.TIMED, ())
    if not runs:
        return
    chart = value_maps_of(reader, runs)
    if not chart.maps:
        return
    settings = runs[0].settings
    reward, gamma = settings["world"]["capture_reward"], settings["learner"]["gamma"]
    small = page.small_print(
        "The thesis sees value spread in a cone behind the prey while there is only approach; when"
        " it circles, counter-clockwise in a ring around the prey; and with avoid, from this ring"
        " inwards.",
        "Mean over the prey's eight headings and n runs (seeds), turned so that the prey (dot)"
        f" looks to the right (arrow). Half-disc: its visual field, {chart.vision:g} cells; the"
        f" outermost ring ends {chart.edges[-1]:.0f} cells away, in the corners of the grid."
        " Colour: equivalent distance to capture, the steps k that a value of"
        f" {reward:g} · {gamma:g}ᵏ stands for; the"
        " paler, the fewer of the headings and runs have a value above 0 there.",
    )
    drawing = drawn("value_spread", chart, small)
    caption = "Where the timed learner knows of a way to capture, as its skills come in"
    page.say("How value spreads (4.3.1)", page.picture("value_spread", caption, drawing))


def _window_means(page: Page, reader: Reader, placed: Placed) -> None:
    rows = []
    for world in thesis.WORLDS:
        for learner in thesis.LEARNER_TITLES:
            traces = reader.traces(placed.get((world, learner), ()))
            if traces:
                cells = [_window_cell(traces, window) for window in thesis.TABLE_WINDOWS]
                rows.append((f"{world}: {learner}", len(traces), *cells))
    text = (
        "Mean reward per trial over the trials that ended in a window of simulation steps, with"
        " 95 % intervals over runs. A run counts in the windows that it went through wholly; where"
        " not all did, the number that did follows. Worlds go by what is not standard in them: the"
        " size of the grid, or directions × distances of the sensors."
    )
    page.say(
        "Means over windows of steps",
        element("p", text),
        table(("world and learner", "n", *thesis.TABLE_WINDOWS), rows),
    )


def _window_cell(traces: Sequence[Trace], window: str) -> str:
    values = [trace.quantities.get(window, math.nan) for trace in traces]
    found = estimates.mean(values, bootstrap_rng())
    fewer = f" ({found.n})" if 0 < found.n < len(traces) else ""
    return shown_estimate(found, ".1f") + fewer
