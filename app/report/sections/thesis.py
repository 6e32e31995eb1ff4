"""Sections of a report on the thesis's experiments: its figures, and a verdict on each finding."""

import math
from collections.abc import Sequence

from app.analysis import estimates
from app.analysis.estimates import Axis, Contrast, bootstrap_rng
from app.charts.model import Panel
from app.charts.paper.drawing import drawn
from app.charts.read import line_of, value_maps_of
from app.charts.styles import THESIS_STYLES
from app.charts.wording import shown_estimate, shown_p
from app.report.document import Page, details, table
from app.report.parts import curve_pictures
from app.results import findings, spread, thesis
from app.results.findings import LEAST_SEEDS, Finding, Judged
from app.results.read import Reader, Trace
from app.results.thesis import Placed
from app.util.html import element
from app.words.numbers import NONE, counted


def write_thesis(page: Page, reader: Reader, placed: Placed) -> None:
    """Write sections on the runs of the thesis's learners in its worlds.

    Args:
        page: to write on.
        reader: of their logs.
        placed: the runs.
    """
    _thesis_figures(page, reader, placed)
    _value_spread(page, reader, placed)
    _findings(page, reader, placed)
    _window_means(page, reader, placed)


def _thesis_figures(page: Page, reader: Reader, placed: Placed) -> None:
    for name, (title, worlds) in thesis.FIGURES.items():
        here = [world for world in worlds if any(place[0] == world for place in placed)]
        if not here or (len(worlds) > 1 and len(here) < 2):
            continue

        def panels(axis: Axis, here: Sequence[str] = here) -> list[Panel]:
            return [_thesis_panel(reader, placed, world, axis) for world in here]

        page.say(title, curve_pictures(page, reader, name, title, panels))


def _thesis_panel(reader: Reader, placed: Placed, world: str, axis: Axis) -> Panel:
    lines = [
        line_of(reader, thesis.LEARNER_TITLES[learner], placed[world, learner], axis, style)
        for learner, style in THESIS_STYLES.items()
        if (world, learner) in placed
    ]
    return Panel(thesis.WORLD_TITLES[world], lines)


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
        "Mean over the prey's eight headings and n runs (seeds), turned so that the prey (dot)"
        f" looks to the right (arrow). Half-disc: its visual field, {chart.vision:g} cells; the"
        f" outermost ring ends {chart.edges[-1]:.0f} cells away, in the corners of the grid."
        " Colour: equivalent distance to capture, the steps k that a value of"
        f" {reward:g} · {gamma:g}ᵏ stands for; the"
        " paler, the fewer of the headings and runs have a value above 0 there."
    )
    drawing = drawn("value_spread", chart, small)
    caption = (
        "Where the timed learner knows of a way to capture, as its skills come in. The thesis sees"
        " value spread in a cone behind the prey while there is only approach; when it circles,"
        " counter-clockwise in a ring around the prey; and with avoid, from this ring inwards"
    )
    page.say("How value spreads (4.3.1)", page.picture("value_spread", caption, drawing))


_CLASSES = {
    findings.HOLDS: "holds",
    findings.FAILS: "fails",
    findings.UNDECIDED: "undecided",
}


def _paired(finding: Finding, effect: Contrast) -> str:
    """Whether the runs of a difference were paired; a quantity on its own has none to pair."""
    if len(finding.terms) == 1:
        return NONE
    return "by seed" if effect.paired else "no"


def _part(finding: Finding) -> str:
    """The part of the thesis that a finding is of."""
    return f"{finding.topic} ({finding.section})"


def _finding_row(judged: Judged) -> Sequence[object]:
    finding, effect = judged.finding, judged.effect
    words = f"{judged.verdict} at {counted(effect.estimate.n, 'seed')}"
    return (
        finding.claim,
        _part(finding),
        finding.wanted,
        shown_estimate(effect.estimate, finding.unit.form),
        _paired(finding, effect),
        element("span", words, class_=_CLASSES[judged.verdict]),
        shown_p(judged.corrected_p),
        element("span", judged.corrected_verdict, class_=_CLASSES[judged.corrected_verdict]),
    )


def _findings(page: Page, reader: Reader, placed: Placed) -> None:
    effects = [(f, thesis.effect_of(f, reader, placed, bootstrap_rng())) for f in thesis.FINDINGS]
    every = findings.judged((f, effect) for f, effect in effects if effect is not None)
    rows = [_finding_row(judged) for judged in every]
    absent = [(_part(f), f.claim) for f, effect in effects if effect is None]
    rule = (
        "Each finding is a quantity, or a difference of quantities, and a condition on it. Rewards"
        f" are means per trial, from a flight (\N{MINUS SIGN}50) to a capture (100). How large a"
        " difference has to be follows from the words of the finding, by one rule that was fixed"
        " before these runs were made: a word of order asks for more than"
        f" {findings.SMALL:g}, a strong one for more than {findings.WIDE:g}, and what is said to be"
        f" close differs by less than {findings.WIDE:g}. A finding holds if the whole 95 % interval"
        " meets the condition, does not hold if none of it does, and is undecided otherwise, and"
        " whenever there are fewer"
        f" than {LEAST_SEEDS} seeds, where no bootstrap interval is wide enough."
        " Differences are of runs of the same seed, where at least half of the runs of each learner"
        f" have a partner. Of {len(rows)} findings some may come out by chance, and the intervals"
        " are not corrected for that; the last two columns are, by Holm's procedure: the chance"
        " that any of their verdicts is wrong is at most 5 %. Their p is that of a two-sided t test"
        " against the bound (by seed, or Welch's), and of two one-sided ones where a difference is"
        " to lie within it."
    )
    measured = "measured [95\N{NO-BREAK SPACE}%]"
    header = (
        *("finding", "part", "condition", measured, "paired", "verdict"),
        *("p corrected", "verdict corrected"),
    )
    parts = [element("p", rule), table(header, rows)] if rows else []
    if rows and all(judged.effect.estimate.n < LEAST_SEEDS for judged in every):
        # First, since all that follows is undecided.
        parts.insert(0, element("p", _TOO_FEW, class_="warning"))
    if spread.TIMED in placed:
        parts.append(element("p", _SPREAD_RULE))
    if absent:
        summary = f"{len(absent)} findings of which a part was not run"
        parts.append(details(summary, table(("part", "finding"), absent)))
    page.say("Findings", *parts)


_TOO_FEW = (
    f"So few seeds decide nothing: {LEAST_SEEDS} are the least that can (--seeds {LEAST_SEEDS}),"
    " and to tell close learners apart it takes more (--seeds 30)."
)
_SPREAD_RULE = (
    "The spread of value is measured in the timed learner, in the prey's own frame, which takes"
    " the eight headings together. A state has a value if it is worth more than nothing: if some"
    " way to a capture has been found from it. Value has reached a place if more than half of its"
    " states have one, and has not if fewer than a quarter have. The ring lies"
    f" {spread.RIGHT_FLANK.cells} from the prey, outside of its visual field; it is open if"
    " there is a sector of it that value has not reached, and closed if there is none. A flank is"
    " the sector of 15 degrees at a right angle to where the prey looks, and the one behind it;"
    " ahead to the right are the four sectors next to the one straight ahead. The equivalent"
    " distance to capture is the number of steps that a value stands for."
)


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
