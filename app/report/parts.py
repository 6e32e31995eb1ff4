"""What sections of a report are made of: curves of variants, and cells and rules of tables."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NamedTuple

from app.analysis import estimates
from app.analysis.estimates import LEAST_RUNS, Axis, Comparison, Estimate, Windows, bootstrap_rng
from app.analysis.passages import Passage, arrivals
from app.charts.model import Curves, Panel
from app.charts.paper.drawing import drawn
from app.charts.wording import shown_estimate, shown_median
from app.metrics import Metric
from app.report.document import Page, View, minor, switch
from app.results.read import Group, Reader, Widths
from app.util.html import Markup, element, joined
from app.words.numbers import NONE, counted, in_short

MOST_LINES = 8
"""Curves in a picture."""
MOST_ROWS = 60
"""Variants in a table."""
MEANS_RULE = (
    f"Mean over runs with its 95 % bootstrap interval; below it, from {LEAST_RUNS} runs on, the"
    " interquartile mean (IQM), which a few wild runs hardly move. Where fewer runs than there are"
    " have a value, it is said how many do."
)
"""How tables show a mean."""
DIFFERENCES_RULE = (
    "Differences are paired by seed where at least half of the runs of each have a partner, and"
    " their IQM is that of the differences of pairs; else it is the difference of two IQMs."
)
"""How tables show a difference of two means."""
REACHED_RULE = (
    "Steps until something was reached are medians over runs as Kaplan and Meier estimate them: of"
    " a run that ended before it got there it is known that it takes more than it had, and no more"
    " than that. Their 95 % intervals are where the band of the share of runs that have got there"
    " (log-log) crosses one half; one without an end (\N{INFINITY}) may never."
)
"""How tables show steps until something was reached."""
STEPS_DIFFERENCES_RULE = (
    "Of steps until something was reached the difference is that of two medians, and has no"
    " interval; P counts half a pair of runs of which it cannot be told which takes more, as the"
    " one with fewer steps ended before it got there."
)
"""How tables show a difference of steps until something was reached."""
CHANCE_RULE = (
    "P is the chance that a run has more than one it is set against, with its 95 % bootstrap"
    " interval over runs, or pairs of runs; where there is no exception, the exact interval of so"
    " many pairs without one."
)
"""How tables show the chance that one is higher."""
NO_INTERVAL = "Single runs give no interval."
GREED = (
    "Greedy reward may be lower than what is earned while learning: without random moves a hunt can"
    " go round for ever, and is cut off."
)
"""Why a learner that gets better may do so by other ways than its best ones."""


class Shown(NamedTuple):
    """Numbers that a report shows, each with the name that it has for runs of such lengths."""

    first: Metric
    """What is drawn, and what variants are set against one another by."""
    swept: Sequence[Metric]
    """What maps and points are of, ``first`` included."""
    every: Sequence[Metric]
    horizon: int | None = None
    """Steps at which all runs were measured as well; None where they have none in common."""


# --- Curves --------------------------------------------------------------------------------------


class Seen(NamedTuple):
    """One of the ways to draw learning curves."""

    axis: Axis
    windows: Windows
    ending: str
    """Of the names of its files."""

    def windows_in_words(self, widths: Widths) -> str:
        """How wide windows are."""
        consecutive = "consecutive " if self.windows == "trials" else ""
        return f"{widths.of(self.axis, self.windows):,} {consecutive}{self.windows}"

    def name(self, widths: Widths) -> str:
        """What it is called where it is chosen."""
        against = "" if self.axis == "steps" else ", against trials"
        return f"windows of {self.windows_in_words(widths)}{against}"


def _curve_notes(widths: Widths, seen: Seen, panels: Sequence[Panel]) -> str:
    share = f"{estimates.LEAST_SHARE:.0%}".replace("%", " %")
    lines = [line for panel in panels for line in panel.lines]
    has_marks = any(line.marks for line in lines)
    marks = " Dashed marks: introductions of skills (median over runs)." if has_marks else ""
    greedy = (
        f" Thin and dotted: greedy reward, of hunts where nothing is explored or learned. {GREED}"
        if any(line.greedy is not None for line in lines)
        else ""
    )
    shaded = (
        "n runs (seeds) each; shaded: 95 % bootstrap interval over runs, point by point."
        if any(line.n > 1 for line in lines)
        else f"n runs (seeds) each. {NO_INTERVAL}"
    )
    return (
        f"Mean reward per trial in windows of {seen.windows_in_words(widths)}; {shaded}{marks}"
        f"{greedy} Faint: some runs have ended, and the mean is over those that go on, which may"
        f" not be typical; where fewer than {share} do, the curve ends."
    )


WAYS_TO_SEE = (
    Seen("steps", "trials", "_by_trials"),
    Seen("steps", "steps", ""),
    Seen("trials", "trials", "_trials"),
)
"""First as the thesis draws them (4.1.2), which shows what is short in steps."""


def curve_pictures(
    page: Page,
    reader: Reader,
    name: str,
    caption: str,
    panels: Callable[[Axis, Windows], Sequence[Panel]],
    note: str = "",
) -> Markup:
    """Learning curves with a switch between the ways to see them.

    Args:
        page: that keeps the pictures.
        reader: of the logs.
        name: that the names of their files begin with.
        caption: what they are of.
        panels: those of an axis, and of windows.
        note: what one has to know of them besides.
    """

    def view(seen: Seen) -> View:
        chart = Curves(seen.axis, panels(seen.axis, seen.windows))
        notes = [_curve_notes(reader.widths, seen, chart.panels), *([note] if note else [])]
        file = f"{name}{seen.ending}"
        drawing = drawn(file, chart, page.small_print(" ".join(notes)))
        way = seen.name(reader.widths)
        return View(way, page.picture(file, f"{caption}, {way}", drawing))

    return switch(name, caption, [view(seen) for seen in WAYS_TO_SEE])


def bars_note(shown: Iterable[Estimate]) -> str:
    """What the bars of a picture are, if it has any."""
    if any(estimate.has_interval for estimate in shown):
        return "Bars: 95 % bootstrap interval."
    return NO_INTERVAL


# --- Cells and words -----------------------------------------------------------------------------


def mean_cell(values: Sequence[float]) -> Markup:
    """A mean over runs with its interval."""
    mean = estimates.mean(values, bootstrap_rng())
    return _below(shown_estimate(mean), _how_many(mean, values))


def scalar_cell(values: Sequence[float]) -> Markup:
    """A mean over runs with its interval, and below it that of the middle half."""
    mean = estimates.mean(values, bootstrap_rng())
    middle = estimates.interquartile_mean(values, bootstrap_rng())
    return _below(shown_estimate(mean), _middle(mean, middle), _how_many(mean, values))


def difference_cell(first: Group, second: Group, column: str, difference: Estimate) -> Markup:
    """How much larger a scalar is in the first group than in the second."""
    values = first.by_seed(column), second.by_seed(column)
    middle = estimates.interquartile_difference(*values, bootstrap_rng())
    return _below(shown_estimate(difference), _middle(difference, middle))


def reached_cell(passages: Sequence[Passage]) -> Markup:
    """The median of the steps until something was reached, and how many runs reached it.

    Args:
        passages: of each run of which it was measured.
    """
    if not passages:
        return Markup(NONE)
    found = arrivals(passages)
    median = shown_median(found, partial(in_short, m_from=1e5))
    return _below(median, f"by {found.reached} of {counted(found.n, 'run')}")


def _middle(mean: Estimate, middle: Estimate) -> str:
    """The mean of the middle half, where there are enough runs for it to differ in its interval."""
    return f"IQM {shown_estimate(middle)}" if mean.n >= LEAST_RUNS else ""


def _how_many(mean: Estimate, values: Sequence[float]) -> str:
    return f"of {counted(mean.n, 'run')}" if 0 < mean.n < len(values) else ""


def _below(cell: str, *notes: str) -> Markup:
    """A cell with small notes under one another."""
    return joined([cell, *(minor(note) for note in notes if note)], Markup("<br/>"))


def chance_cell(found: Comparison) -> str:
    """The chance that a run of the first group has more than one of the second."""
    return shown_estimate(found.improvement, ".2f")


def pairing_cell(found: Comparison) -> str:
    """How the runs of a difference were paired."""
    return "by seed" if found.paired else "no"


def minor_text(text: str) -> Markup:
    """A paragraph that steps back; nothing where there is nothing to say."""
    return element("p", text, class_="minor") if text else Markup()


def left_out(n_groups: int) -> Markup:
    """That a table does not show all of so many variants; nothing where it does."""
    if n_groups <= MOST_ROWS:
        return Markup()
    return minor_text(
        f"The first {MOST_ROWS} of {n_groups} variants; results.sqlite has all of them."
    )
