"""A report of results: one page that stands for itself, and its pictures as files.

What a page shows follows from what was run. Runs of the thesis's learners in its worlds give its
figures and a verdict on each of its findings; settings that were swept give maps and points;
variants give curves, and unless they are of one such map they are set against the first of them.
"""

import contextlib
import json
import math
import os
import shlex
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from app import statistics, thesis, thesis_finding, thesis_spread
from app.figures import (
    THESIS_STYLES,
    Dot,
    Line,
    Mark,
    Panel,
    Style,
    ValueMap,
    draw_curves,
    draw_dots,
    draw_values,
    grouped,
    shown_estimate,
    style_of,
    with_clear_marks,
)
from app.markup import Markup, Page, details, document, element, escaped, joined, minor, table
from app.metrics import (
    BEHAVIOUR,
    ENDINGS,
    METRICS,
    MILESTONES,
    PERFORMANCE,
    Metric,
    shown_first,
)
from app.readout import (
    Folder,
    Group,
    Reader,
    ResultsError,
    RunRow,
    Trace,
    Widths,
    folder_names,
    groups_of,
    in_short,
    measured,
    read_folder,
    widths_of,
)
from app.report_sweeps import write_sweeps
from app.statistics import Axis, Contrast, Estimate
from app.sweep import differing
from app.thesis import Placed
from app.thesis_finding import Finding
from sim import geometry
from sim.spec import WorldSpec

PAGE_NAME = "report.html"

_BOOTSTRAP_SEED = 20
_MOST_LINES = 8
_MOST_ROWS = 60
_MOST_OPEN_ROWS = 16
_LEAST_FOR_QUARTILES = 4
_MOST_KEYS = 10


# --- Curves --------------------------------------------------------------------------------------


def _rng() -> np.random.Generator:
    """A generator for one interval, so that no interval depends on which came before it."""
    return np.random.default_rng(_BOOTSTRAP_SEED)


def _line(reader: Reader, label: str, runs: Iterable[RunRow], axis: Axis, style: Style) -> Line:
    traces = reader.traces(runs)
    curves = [trace.curves[axis] for trace in traces]
    found = statistics.band(curves, reader.widths.of(axis), _rng())
    return Line(label, found, style, len(traces), _marks(traces, axis))


def _marks(traces: Sequence[Trace], axis: Axis) -> list[Mark]:
    """Introductions that all runs have come to, at the median over the runs."""
    medians = statistics.medians_of_all([trace.introductions for trace in traces])
    return [
        Mark(step if axis == "steps" else trial, name.replace("_", " "))
        for name, (trial, step) in medians.items()
    ]


def _curve_notes(widths: Widths, axis: Axis, panels: Sequence[Panel]) -> str:
    share = f"{statistics.LEAST_SHARE:.0%}".replace("%", " %")
    has_marks = any(line.marks for panel in panels for line in panel.lines)
    marks = " Dashed marks: introductions of skills (median over runs)." if has_marks else ""
    return (
        f"Mean reward per trial in windows of {widths.of(axis):,} {axis}; n runs (seeds) each;"
        f" shaded: 95 % bootstrap interval over runs, point by point.{marks}"
        " Faint: some runs have ended, and the mean is over those that go on, which may not be"
        f" typical; where fewer than {share} do, the curve ends."
    )


def _curve_pictures(
    page: Page,
    reader: Reader,
    name: str,
    caption: str,
    panels: Callable[[Axis], Sequence[Panel]],
    note: str = "",
) -> Markup:
    """A picture against steps, and the same against trials to be opened."""

    def picture(axis: Axis, name: str, caption: str) -> Markup:
        drawn = panels(axis)
        notes = [_curve_notes(reader.widths, axis, drawn), *([note] if note else [])]
        drawing = draw_curves(name, drawn, axis, page.small_print(" ".join(notes)))
        return page.picture(name, caption, drawing)

    by_steps = picture("steps", name, caption)
    by_trials = picture("trials", f"{name}_trials", f"{caption}, against trials")
    return joined([by_steps, details("The same against trials", by_trials)])


# --- Sections: the thesis ------------------------------------------------------------------------


def _thesis_figures(page: Page, reader: Reader, placed: Placed) -> None:
    for name, (title, worlds) in thesis.FIGURES.items():
        here = [world for world in worlds if any(place[0] == world for place in placed)]
        if not here or (len(worlds) > 1 and len(here) < 2):
            continue

        def panels(axis: Axis, here: Sequence[str] = here) -> list[Panel]:
            return [_thesis_panel(reader, placed, world, axis) for world in here]

        page.say(title, _curve_pictures(page, reader, name, title, panels))


def _thesis_panel(reader: Reader, placed: Placed, world: str, axis: Axis) -> Panel:
    lines = [
        _line(reader, thesis.LEARNER_TITLES[learner], placed[world, learner], axis, style)
        for learner, style in THESIS_STYLES.items()
        if (world, learner) in placed
    ]
    return Panel(thesis.WORLD_TITLES[world], lines)


def _value_spread(page: Page, reader: Reader, placed: Placed) -> None:
    """Where the timed learner knew of a way to capture, at the moments that the thesis names."""
    runs = placed.get(thesis_spread.TIMED, ())
    pictures = [trace.pictures for trace in reader.traces(runs) if trace.pictures is not None]
    if not pictures:
        return
    maps = []
    for name, trial in thesis_spread.moments_of(runs[0].settings).items():
        found = [value for picture in pictures if (value := picture.at(trial)) is not None]
        if found:
            title = f"{name}: after {trial:,} trials"
            maps.append(ValueMap(title, thesis_spread.averaged(found), len(found)))
    world = WorldSpec.model_validate(runs[0].settings["world"])
    edges, vision = geometry.ring_edges(world), world.vision_radius * world.scale
    reward, gamma = world.capture_reward, runs[0].settings["learner"]["gamma"]
    small = page.small_print(
        "Mean over the prey's eight headings and n runs (seeds), turned so that the prey (dot)"
        f" looks to the right (arrow). Half-disc: its visual field, {vision:g} cells; the outermost"
        f" ring ends {edges[-1]:.0f} cells away, in the corners of the grid. Colour: equivalent"
        f" distance to capture, the steps k that a value of {reward:g} · {gamma:g}ᵏ stands for; the"
        " paler, the fewer of the headings and runs have a value above 0 there."
    )
    drawing = draw_values("value_spread", maps, edges, vision, small)
    caption = (
        "Where the timed learner knows of a way to capture, as its skills come in. The thesis sees"
        " value spread in a cone behind the prey while there is only approach; when it circles,"
        " counter-clockwise in a ring around the prey; and with avoid, from this ring inwards"
    )
    page.say("How value spreads (4.3.1)", page.picture("value_spread", caption, drawing))


_CLASSES = {
    thesis_finding.HOLDS: "holds",
    thesis_finding.FAILS: "fails",
    thesis_finding.UNDECIDED: "undecided",
}


def _paired(finding: Finding, effect: Contrast) -> str:
    """Whether the runs of a difference were paired; a quantity on its own has none to pair."""
    if len(finding.terms) == 1:
        return "–"
    return "by seed" if effect.paired else "no"


def _finding_row(finding: Finding, effect: Contrast) -> Sequence[object]:
    found = thesis_finding.verdict(finding, effect.estimate)
    words = f"{found} at {effect.estimate.n} seed{'s' if effect.estimate.n != 1 else ''}"
    return (
        finding.claim,
        finding.topic,
        finding.wanted,
        shown_estimate(effect.estimate, finding.unit.form),
        _paired(finding, effect),
        element("span", words, class_=_CLASSES[found]),
    )


def _findings(page: Page, reader: Reader, placed: Placed) -> None:
    effects = [(f, thesis.effect_of(f, reader, placed, _rng())) for f in thesis.FINDINGS]
    rows = [_finding_row(finding, effect) for finding, effect in effects if effect is not None]
    absent = [(f.topic, f.claim) for f, effect in effects if effect is None]
    rule = (
        "Each finding is a quantity, or a difference of quantities, and a condition on it. Rewards"
        f" are means per trial: a wide margin is {thesis_finding.WIDE:g}, a tenth of the range from"
        " a flight (\N{MINUS SIGN}50) to a capture (100), and two learners are close if they differ"
        " by less than that. A finding holds if the whole 95 % interval meets the condition, does"
        " not hold if none of it does, and is undecided otherwise, and whenever there are fewer"
        f" than {thesis_finding.LEAST_SEEDS} seeds, where no bootstrap interval is wide enough."
        " Differences are of runs of the same seed, where seeds are shared. The intervals are not"
        f" corrected for there being {len(rows)}."
    )
    measured = "measured [95\N{NO-BREAK SPACE}%]"
    header = ("finding", "part", "condition", measured, "paired", "verdict")
    parts = [element("p", rule), table(header, rows)] if rows else []
    if _has_pictures(reader, placed):
        parts.append(element("p", _SPREAD_RULE))
    elif thesis_spread.TIMED in placed:
        parts.append(element("p", _NO_PICTURES, class_="minor"))
    if absent:
        summary = f"{len(absent)} findings of which a part was not run"
        parts.append(details(summary, table(("part", "finding"), absent)))
    page.say("Findings", *parts)


_SPREAD_RULE = (
    "The spread of value is measured in the timed learner, in the prey's own frame, which takes"
    " the eight headings together. A state has a value if it is worth more than nothing: if some"
    " way to a capture has been found from it. Value has reached a place if more than half of its"
    " states have one, and has not if fewer than a quarter have. The ring lies"
    f" {thesis_spread.RIGHT_FLANK.cells} from the prey, outside of its visual field; it is open if"
    " there is a sector of it that value has not reached, and closed if there is none. A flank is"
    " the sector of 15 degrees at a right angle to where the prey looks, and the one behind it;"
    " ahead to the right are the four sectors next to the one straight ahead. The equivalent"
    " distance to capture is the number of steps that a value stands for."
)
_NO_PICTURES = (
    "How value spreads, a finding in the standard world, cannot be seen in these results: they"
    " hold no pictures of the value. Running the experiment again gives results that do."
)


def _has_pictures(reader: Reader, placed: Placed) -> bool:
    traces = reader.traces(placed.get(thesis_spread.TIMED, ()))
    return any(trace.pictures is not None for trace in traces)


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
    found = statistics.mean(values, _rng())
    fewer = f" ({found.n})" if 0 < found.n < len(traces) else ""
    return shown_estimate(found, ".1f") + fewer


# --- Sections: any experiment --------------------------------------------------------------------


def _curves(
    page: Page, reader: Reader, groups: Sequence[Group], metric: Metric, naming: str
) -> None:
    """Curves of all variants, or of the highest where they are too many for a picture."""
    shown = _highest(groups, metric)

    def panels(axis: Axis) -> list[Panel]:
        lines = [
            _line(reader, group.label, group.runs, axis, style_of(index))
            for index, group in enumerate(shown)
        ]
        return [Panel("", with_clear_marks(lines))]

    caption, notes = "Reward of each variant", [naming] if naming else []
    if len(shown) < len(groups):
        which = f"the {len(shown)} of {len(groups)} variants with the highest {metric.title}"
        caption = f"Reward of {which}"
        notes.insert(0, f"Shown: {which}; to be among them is luck in part.")
    curves = _curve_pictures(page, reader, "curves", caption, panels, " ".join(notes))
    page.say("Learning curves", curves, _minor_text(naming))


def _highest(groups: Sequence[Group], metric: Metric) -> list[Group]:
    """As many variants as a picture takes, those with the highest means, in their own order."""

    def mean(place: int) -> float:
        values = [v for v in groups[place].values(metric.column) if math.isfinite(v)]
        return sum(values) / len(values) if values else -math.inf

    best = sorted(range(len(groups)), key=mean, reverse=True)[:_MOST_LINES]
    return [groups[place] for place in sorted(best)]


def _minor_text(text: str) -> Markup:
    """A paragraph that steps back; nothing where there is nothing to say."""
    return element("p", text, class_="minor") if text else Markup()


def _scalars(page: Page, groups: Sequence[Group], naming: str) -> None:
    there = {m.column for m in METRICS if measured(groups, m.column)}
    text = (
        f"{_MEANS_RULE} Steps are medians, with a run that never got there counted as longer than"
        " any that did."
    )
    text = f"{text} {naming}" if naming else text
    how_well, how, endings = (
        [metric for metric in METRICS if metric.column in names & there]
        for names in (PERFORMANCE, BEHAVIOUR, ENDINGS)
    )
    shown = groups[:_MOST_ROWS]
    tables = joined(
        [
            _scalar_table(shown, how_well, _scalar_cell, ()),
            _scalar_table(shown, how, _mean_cell, tuple(MILESTONES)),
            _scalar_table(shown, endings, _mean_cell, ()),
            _left_out(len(groups)),
        ]
    )
    if len(groups) > _MOST_OPEN_ROWS:
        tables = details(f"The scalars of {len(shown)} variants", tables)
    page.say("Scalars", element("p", text), tables)


def _scalar_table(
    groups: Sequence[Group],
    metrics: Sequence[Metric],
    cell: Callable[[Sequence[float]], str],
    milestones: Sequence[str],
) -> Markup:
    titles = [MILESTONES[column] for column in milestones]
    header = ("variant", "n", *titles, *(metric.label for metric in metrics))
    rows = [
        (
            group.label,
            len(group.runs),
            *(_reached_cell(group, column) for column in milestones),
            *(cell(group.values(metric.column)) for metric in metrics),
        )
        for group in groups
    ]
    return table(header, rows)


def _left_out(n_groups: int) -> str | Markup:
    if n_groups <= _MOST_ROWS:
        return Markup()
    text = f"The first {_MOST_ROWS} of {n_groups} variants; results.sqlite has all of them."
    return element("p", text, class_="minor")


def _mean_cell(values: Sequence[float]) -> str:
    return shown_estimate(statistics.mean(values, _rng()))


_MEANS_RULE = (
    "Mean over runs with its 95 % bootstrap interval; below it, from four runs on, the"
    " interquartile mean (IQM), which a few wild runs hardly move."
)
_DIFFERENCES_RULE = (
    "Differences are paired by seed where seeds are shared, and their IQM is that of the"
    " differences of pairs; where none are, it is the difference of two IQMs."
)


def _scalar_cell(values: Sequence[float]) -> Markup:
    return _with_middle(
        statistics.mean(values, _rng()), statistics.interquartile_mean(values, _rng())
    )


def _difference_cell(first: Group, second: Group, column: str, difference: Estimate) -> Markup:
    """How much larger a scalar is in the first group than in the second."""
    values = first.by_seed(column), second.by_seed(column)
    return _with_middle(difference, statistics.interquartile_difference(*values, _rng()))


def _with_middle(mean: Estimate, middle: Estimate) -> Markup:
    """A mean and, where there are enough runs for quartiles, the mean of the middle half."""
    if mean.n < _LEAST_FOR_QUARTILES:
        return escaped(shown_estimate(mean))
    below = minor(f"IQM {shown_estimate(middle)}")
    return joined([shown_estimate(mean), Markup("<br/>"), below], "")


def _reached_cell(group: Group, column: str) -> Markup:
    found = statistics.reached([run.milestones[column] for run in group.runs], _rng())
    median = found.median
    value, low, high = (_steps(value) for value in (median.value, median.low, median.high))
    interval = "" if math.isnan(median.low) or low == high else f" [{low}, {high}]"
    share = minor(f"by {found.reached} of {median.n} runs")
    return joined([f"{value}{interval}", Markup("<br/>"), share], "")


def _steps(value: float) -> str:
    if math.isinf(value):
        return "never"
    return f"{value / 1e6:.3g} M" if value >= 1e5 else f"{value:,.0f}"


def _ablation(page: Page, groups: Sequence[Group], metric: Metric, naming: str) -> None:
    """Variants beside the first one."""
    base, *others = groups[:_MOST_ROWS]
    column = metric.column
    found = [
        statistics.compare(group.by_seed(column), base.by_seed(column), _rng()) for group in others
    ]
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    difference = f"{metric.title}: difference to {base.label}"
    columns = {
        metric.label: [
            Dot(group.label, statistics.mean(group.values(column), _rng()), group.values(column))
            for group in (base, *others)
        ],
        difference: [
            Dot(base.label, nothing),
            *(Dot(g.label, c.difference) for g, c in zip(others, found, strict=True)),
        ],
    }
    small = page.small_print(
        "Mean over n runs (seeds); bars: 95 % bootstrap interval; pale dots: single runs."
        " Differences are to"
        f" {base.label}, and paired by seed where seeds are shared. {naming}".strip()
    )
    drawing = draw_dots("variants", columns, small, zero=(difference,))
    rows = [
        (base.label, _scalar_cell(base.values(column)), "–", "–", "–", "–"),
        *(
            (
                group.label,
                _scalar_cell(group.values(column)),
                _difference_cell(group, base, column, c.difference),
                f"{c.improvement:.2f}",
                c.difference.n,
                "by seed" if c.paired else "no",
            )
            for group, c in zip(others, found, strict=True)
        ),
    ]
    header = (
        "variant",
        f"{metric.label} [95 %]",
        f"{difference} [95 %]",
        "P(variant higher)",
        "n of the difference",
        "paired",
    )
    caption = f"{metric.label} of each variant"
    page.say(
        "Variants beside one another",
        page.picture("variants", caption, drawing),
        element("p", f"{_MEANS_RULE} {_DIFFERENCES_RULE} {naming}".strip()),
        table(header, rows),
        _left_out(len(groups)),
    )


# --- Sections: two folders -----------------------------------------------------------------------

Pair = tuple[Group, Group]


def pairs_of(first: Sequence[Group], second: Sequence[Group]) -> tuple[list[Pair], list[Group]]:
    """Variants of two folders that belong together, and those left alone.

    They do if preset and overrides agree; else if all settings do, however they came about; else
    if the overrides do; else if they have the same label. Each time only where no other variant
    has the same.
    """
    pairs: list[Pair] = []
    left, right = first, second
    for key_of in (_full_key, _spec_key, _overrides_key, _label_of):
        mine, theirs = ([(key_of(group), group) for group in side] for side in (left, right))
        alike = _single(mine) & _single(theirs)
        partners = dict(theirs)
        pairs += [(group, partners[key]) for key, group in mine if key in alike]
        left, right = (
            [group for key, group in side if key not in alike] for side in (mine, theirs)
        )
    return pairs, [*left, *right]


def _single(keyed: Iterable[tuple[str, Group]]) -> set[str]:
    """Keys that a single group has."""
    return {key for key, n in Counter(key for key, _ in keyed).items() if n == 1}


def _full_key(group: Group) -> str:
    return json.dumps([group.preset, group.overrides], sort_keys=True)


def _spec_key(group: Group) -> str:
    settings = group.runs[0].settings
    return json.dumps({**settings, "description": ""}, sort_keys=True)


def _overrides_key(group: Group) -> str:
    return json.dumps(group.overrides, sort_keys=True)


def _label_of(group: Group) -> str:
    return group.label


def _comparison(page: Page, reader: Reader, first: Folder, second: Folder, metric: Metric) -> None:
    pairs, alone = pairs_of(groups_of(first.rows), groups_of(second.rows))
    if not pairs:
        raise ResultsError(
            f"{str(first.path)!r} and {str(second.path)!r} have no variant in common;"
            " allowed: folders whose variants set the same keys to the same values, or have the"
            " same labels"
        )
    picture = _comparison_picture(page, pairs, metric)
    rule = element("p", f"{_MEANS_RULE} {_DIFFERENCES_RULE} {_SAMPLES_RULE}")
    page.say("Difference B \N{MINUS SIGN} A", picture, rule, *_comparison_tables(pairs))
    for number, pair in enumerate(pairs[:_MOST_LINES], 1):
        _pair_curves(page, reader, number, pair)
    if alone:
        names = element("ul", joined(element("li", group.label) for group in alone))
        page.say("In one folder only", names)


_SAMPLES_RULE = (
    "A and B are over the seeds that their difference is over, n of them, if it is paired, and"
    " else over all runs that each of them has."
)


def _pair_name(pair: Pair) -> str:
    first, second = pair
    return first.label if first.label == second.label else f"{first.label} / {second.label}"


def _compared(pair: Pair, metric: Metric) -> statistics.Comparison:
    before, after = (group.by_seed(metric.column) for group in pair)
    return statistics.compare(after, before, _rng())


def _comparison_picture(page: Page, pairs: Sequence[Pair], metric: Metric) -> Markup:
    dots = [
        Dot(_pair_name(pair), _compared(pair, metric).difference) for pair in pairs[:_MOST_ROWS]
    ]
    what = f"B \N{MINUS SIGN} A: {metric.label}"
    small = page.small_print(
        "Difference of means over n pairs of runs of the same seed, or over all runs where no"
        " seeds are shared; bars: 95 % bootstrap interval."
    )
    drawing = draw_dots("difference", {what: dots}, small, zero=(what,))
    return page.picture("difference", what, drawing)


def _comparison_tables(pairs: Sequence[Pair]) -> list[Markup]:
    header = (
        "quantity",
        "A",
        "B",
        "B \N{MINUS SIGN} A [95 %]",
        "P(B > A)",
        "n",
        "paired",
    )
    tables = []
    for pair in pairs[:_MOST_ROWS]:
        rows = []
        for metric in METRICS:
            found = _compared(pair, metric)
            values = _samples(pair, metric.column, found.paired)
            if found.difference.n:
                rows.append(
                    (
                        metric.label,
                        *map(_scalar_cell, values),
                        _difference_cell(pair[1], pair[0], metric.column, found.difference),
                        f"{found.improvement:.2f}",
                        found.difference.n if found.paired else " and ".join(map(_n, values)),
                        "by seed" if found.paired else "no",
                    )
                )
        text = element("p", _identical(pair), class_="minor")
        unlike = _unlike(pair)
        differing = element("p", unlike) if unlike else Markup()
        tables.append(
            joined([element("h3", _pair_name(pair)), differing, table(header, rows), text])
        )
    return tables


def _samples(pair: Pair, column: str, paired: bool) -> tuple[list[float], list[float]]:
    """Values of A and of B: of the seeds that a paired difference is over, else all."""
    before, after = (
        {seed: value for seed, value in group.by_seed(column).items() if not math.isnan(value)}
        for group in pair
    )
    if not paired:
        return [*before.values()], [*after.values()]
    shared = [seed for seed in before if seed in after]
    return [before[seed] for seed in shared], [after[seed] for seed in shared]


def _n(values: Sequence[float]) -> str:
    return str(len(values))


def _unlike(pair: Pair) -> str:
    """In which settings A and B differ, and how; empty if they do not."""
    first, second = pair
    found = differing(first.runs[0].settings, second.runs[0].settings)
    if first.preset != second.preset:
        found.insert(0, ("preset", first.preset, second.preset))
    if not found:
        return ""
    shown = [f"{key} (A: {grouped(a)}, B: {grouped(b)})" for key, a, b in found[:_MOST_KEYS]]
    more = f"; and {len(found) - len(shown)} more" if len(found) > len(shown) else ""
    return f"A and B differ in their settings: {'; '.join(shown)}{more}."


def _identical(pair: Pair) -> str:
    digests = [{run.seed: run.digest for run in group.runs if run.digest} for group in pair]
    shared = [seed for seed in digests[0] if seed in digests[1]]
    same = sum(digests[0][seed] == digests[1][seed] for seed in shared)
    return f"{len(shared)} seeds are in both; {same} of these runs are alike digest for digest."


def _pair_curves(page: Page, reader: Reader, number: int, pair: Pair) -> None:
    def panels(axis: Axis) -> list[Panel]:
        lines = [
            _line(reader, f"{side}: {group.label}", group.runs, axis, style_of(index))
            for index, (side, group) in enumerate(zip("AB", pair, strict=True))
        ]
        return [Panel(_pair_name(pair), with_clear_marks(lines))]

    name = f"pair_{number}"
    caption = f"Reward in A and B: {_pair_name(pair)}"
    page.say(_pair_name(pair), _curve_pictures(page, reader, name, caption, panels))


# --- The whole -----------------------------------------------------------------------------------


def write_report(folders: Sequence[Path], out: Path | None, compare: bool) -> Path:
    """Write a page on folders of results, and its pictures into a folder beside it.

    Args:
        folders: of results; without ``compare`` they are taken together.
        out: the page; ``report.html`` in the first folder unless given.
        compare: set the second folder against the first.

    Returns:
        The page.

    Raises:
        ResultsError: nothing can be reported, or nothing be written.
    """
    if compare and len(folders) != 2:
        raise ResultsError(f"a comparison needs two folders, and there are {len(folders)}")
    read = [read_folder(folder) for folder in folders]
    place = folders[0] / PAGE_NAME if out is None else out
    commands = [*(folder.command for folder in read), _command(folders, out, compare)]
    page = Page(commands, f"{place.stem}_figures")
    tables = [folder.rows for folder in read]
    rows = [row for table in (tables if compare else _without_copies(tables)) for row in table]
    if all(row.error for row in rows):
        shown = ", ".join(repr(str(folder)) for folder in folders)
        raise ResultsError(f"no run is over in {shown}: there is nothing to report yet")
    several = folder_names(folder.path for folder in read) if len({*folders}) > 1 else {}
    reader = Reader(widths_of(rows), thesis.quantities_of, several)
    # What both sides of a comparison hold is looked at twice, and was still run once.
    apart = [row for table in _without_copies(tables) for row in table]
    title = _overview(page, read, apart, compare)
    # Folders may differ in what they measure first; the page shows one thing all through.
    metric = shown_first(read[0].metrics)
    if compare:
        first, second = read
        _comparison(page, reader, first, second, metric)
    else:
        _everything(page, reader, groups_of(rows), metric)
    _missing_runs(page, reader, rows)
    _write_all(page, place, document(title, page))
    return place


def _everything(page: Page, reader: Reader, found: Sequence[Group], metric: Metric) -> None:
    groups, naming = in_short(found)
    placed = thesis.placed_of(groups)
    # One learner alone in a world replicates nothing; it is a variant like any other.
    if len({learner for _, learner in placed}) < 2:
        placed = {}
    if placed:
        _thesis_figures(page, reader, placed)
        _value_spread(page, reader, placed)
        _findings(page, reader, placed)
        _window_means(page, reader, placed)
    others = [g for g in groups if not placed or thesis.place_of(g.runs[0]) not in placed]
    swept = write_sweeps(page, groups, metric, _rng)
    rest = [group for group in others if group.preset not in swept]
    if len(rest) > 1:
        _ablation(page, rest, metric, naming)
    if others:
        _curves(page, reader, others, metric, naming)
    _scalars(page, groups, naming)


def _without_copies(tables: Iterable[Sequence[RunRow]]) -> list[list[RunRow]]:
    """Tables of folders without the runs that a folder before them holds as well.

    Within a folder nothing is a copy: two of its variants may well come to the same settings.
    """
    seen: set[tuple[str, str]] = set()
    found = []
    for rows in tables:
        keyed = [((row.identity, row.digest or row.key), row) for row in rows]
        found.append([row for key, row in keyed if key not in seen])
        seen.update(key for key, _ in keyed)
    return found


def _command(folders: Sequence[Path], out: Path | None, compare: bool) -> str:
    words = ["pounce", "report", *(["--compare"] if compare else []), *map(str, folders)]
    return shlex.join([*words, *([] if out is None else ["--out", str(out)])])


def _overview(page: Page, read: Sequence[Folder], rows: Sequence[RunRow], compare: bool) -> str:
    names = [folder.path.resolve().name for folder in read]
    failed = sum(bool(row.error) for row in rows)
    versions = ", ".join(sorted({row.version for row in rows if row.version})) or "unknown"
    seeds = {row.seed for row in rows}
    also = f" ({failed} more failed)" if failed else ""
    lines = [
        *_descriptions(read),
        f"{len(rows) - failed} runs over {len(seeds)} seeds{also}, by version {versions} of the"
        " lab.",
    ]
    if compare:
        lines.append(f"A is {read[0].path}, B is {read[1].path}.")
    lines += [
        f"A stop condition or a number of steps may have ended the runs in {folder.path} early, so"
        " they do not count among the thesis's own."
        for folder in read
        if any(row.limited for row in folder.rows)
    ]
    commands = [element("code", command) for command in page.commands]
    content = [element("p", line) for line in lines]
    content.append(element("p", joined(["Made by", *commands], Markup("<br/>"))))
    page.sections.append(joined(content))
    return " and ".join(names) if compare else ", ".join(names)


def _descriptions(read: Sequence[Folder]) -> list[str]:
    """What the experiments are about, each with the names of its folders if there are several."""
    names = folder_names(folder.path for folder in read)
    by_text: dict[str, list[str]] = {}
    for folder in read:
        if folder.description:
            by_text.setdefault(folder.description, []).append(names[folder.path])
    if len(names) == 1:
        return [*by_text]
    return [f"{', '.join(dict.fromkeys(which))}: {text}" for text, which in by_text.items()]


def _missing_runs(page: Page, reader: Reader, rows: Iterable[RunRow]) -> None:
    failed = {reader.name_of(run): run.error for run in rows if run.error}
    missing = {**failed, **reader.unreadable}
    if missing:
        cells = [(name, element("span", why)) for name, why in missing.items()]
        page.say("Runs that are left out", table(("run", "why"), cells))


def _write_all(page: Page, place: Path, text: str) -> None:
    folder = place.with_name(page.figures)
    header = '<?xml version="1.0" encoding="utf-8"?>\n'
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, drawing in page.drawings.items():
            _write(folder / f"{name}.svg", (header + drawing.svg).encode())
            _write(folder / f"{name}.png", drawing.png)
            _write(folder / f"{name}.csv", drawing.csv.encode("utf-8", "replace"))
        # The page comes last: where it is, its pictures are.
        _write(place, text.encode())
    except OSError as error:
        raise ResultsError(
            f"{str(place)!r} cannot be written: {error.strerror or error};"
            " allowed: a place that can"
        ) from error


def _write(file: Path, data: bytes) -> None:
    """Write a file so that it is there whole or as it was before."""
    handle, name = tempfile.mkstemp(prefix=".pounce-", dir=file.parent)
    try:
        with os.fdopen(handle, "wb") as out:
            out.write(data)
        # A temporary file is its owner's alone; a report is like any other file.
        os.chmod(name, 0o644)
        os.replace(name, file)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
