"""What came out, as numbers and tables of the pages: read from the folders of all experiments."""

import math
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from app.analysis import effects, estimates, passages
from app.analysis.effects import Analysis
from app.analysis.estimates import Estimate, bootstrap_rng
from app.charts.wording import shown_estimate, shown_median, shown_p
from app.documents.samples import is_draw
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table
from app.replication.plan import EXPERIMENTS, THESIS
from app.report.sections.effects import in_words
from app.results import findings, read, readings, thesis
from app.results.findings import FAILS, HOLDS, UNDECIDED, Finding, Judged
from app.results.read import Folder, Group, Reader, groups_of, read_folder
from app.results.thesis import Placed
from app.words.numbers import NONE, in_millions, shown_number

SHOWN: Final[Mapping[str, str]] = {
    "final_reward": "end of the trials",
    "final_greedy": "by greed",
    "horizon_reward": "at the horizon",
    "horizon_greedy": "by greed",
    "horizon_area": "area to the horizon",
}
"""Columns of tables of variants, with their headings."""
SEARCHES: Final = ("baselines_search", "timing_seven")
SEARCHED_FOR: Final = ("horizon_reward", "horizon_area")
"""What is searched for: the end, and speed."""
PASSAGE: Final = "steps_to_70"
"""The passage that tables of variants show."""

_REWARDS: Final = ".1f"
_BOLD: Final = {HOLDS: "holds", FAILS: "**does not hold**", UNDECIDED: "undecided"}


class Results(NamedTuple):
    """The results of one experiment."""

    folder: Folder
    groups: Sequence[Group]

    def group(self, label: str) -> Group:
        """The runs of a variant; raises KeyError where there is none."""
        for group in self.groups:
            if group.label == label:
                return group
        raise KeyError(f"{self.folder.path.name} has no variant {label!r}")


def found_in(out: Path, tell: Callable[[str], object] = lambda _: None) -> Found:
    """Everything that the pages say.

    Args:
        out: the folder that holds a folder of results for each experiment.
        tell: told what is being done.

    Raises:
        ResultsError: an experiment was not run, or its results are damaged.
    """
    every = {name: _results_in(out / name) for name in EXPERIMENTS}
    found = Found()
    runs = [run for results in every.values() for run in results.folder.rows]
    found.texts["runs"] = f"{len(runs):,}"
    found.texts["steps"] = f"{sum(run.steps for run in runs) / 1e9:.0f}"
    found.texts["experiments"] = f"{len(every)}"
    for name, results in every.items():
        found.texts |= _means(name, results)
    tell("judging the findings")
    _add_findings(found, [every[name] for name in THESIS])
    tell("reading the thesis otherwise")
    _add_readings(found, every["reading"])
    for name in ("baselines", "together", "ablation", "timing_test"):
        found.tables[f"{name} table"] = variants_table(every[name])
    _add_learners(found, [every[name] for name in THESIS[:3]])
    for name in ("timing_seven", "timing_plane"):
        _add_spread(found, name, every[name])
    for name in SEARCHES:
        found.searches[name] = _best_of(every[name])
    tell("looking at what was drawn")
    _add_effects(found, every["timing_seven"])
    return found


def _results_in(path: Path) -> Results:
    folder = read_folder(path)
    return Results(folder, groups_of(folder.rows))


# --- Findings ------------------------------------------------------------------------------------


def _reader_of(results: Sequence[Results]) -> Reader:
    rows = [run for each in results for run in each.folder.rows]
    return Reader(read.widths_of(rows), thesis.quantities_of)


def _add_findings(found: Found, results: Sequence[Results]) -> None:
    rows = [run for each in results for run in each.folder.rows]
    placed, reader = thesis.placed_of(groups_of(rows)), _reader_of(results)
    measured = [
        (finding, thesis.effect_of(finding, reader, placed, bootstrap_rng()))
        for finding in thesis.FINDINGS
    ]
    every = findings.judged((finding, effect) for finding, effect in measured if effect is not None)
    for topic in dict.fromkeys(judged.finding.topic for judged in every):
        of_topic = [judged for judged in every if judged.finding.topic == topic]
        found.tables[f"findings: {topic}"] = _findings_table(of_topic)
    found.estimates = {
        judged.finding.claim: [float(f"{number:.7g}") for number in judged.effect.estimate]
        for judged in every
    }
    found.spreads = {j.finding.claim: _spread(j.finding, reader, placed) for j in every}
    for judged in every:
        found.texts[f"finding: {judged.finding.claim}"] = _measured(judged)
    for name, verdict_of in (("", _verdict), (" corrected", _corrected)):
        counts = Counter(map(verdict_of, every))
        for key, verdict in (("hold", HOLDS), ("fail", FAILS), ("undecided", UNDECIDED)):
            found.texts[f"{key}{name}"] = str(counts[verdict])
    found.texts["findings"] = str(len(every))
    found.texts["untestable"] = str(len(measured) - len(every))


def _spread(finding: Finding, reader: Reader, placed: Placed) -> float:
    """Standard deviation of the sum that a finding speaks of, of one run of each learner."""
    variance = 0.0
    for term in finding.terms:
        traces = reader.traces(placed[term.world, term.learner])
        values = [trace.quantities[term.quantity] for trace in traces]
        if len(values) > 1:
            variance += term.weight**2 * statistics.variance(values)
    return float(f"{math.sqrt(variance):.4g}")


def _verdict(judged: Judged) -> str:
    return judged.verdict


def _corrected(judged: Judged) -> str:
    return judged.corrected_verdict


def _measured(judged: Judged) -> str:
    return shown_estimate(judged.effect.estimate, judged.finding.unit.form)


def _findings_table(every: Sequence[Judged]) -> Table:
    """Findings of a part of the thesis; what it says stands once for all that test it."""
    rows: list[Sequence[str]] = []
    said = ""
    for judged in every:
        finding = judged.finding
        sentence = f"{finding.sentence} ({finding.section})"
        rows.append(
            (
                "" if sentence == said else sentence,
                finding.claim,
                finding.wanted,
                f"{_measured(judged)}, {judged.effect.estimate.n}",
                _BOLD[judged.verdict],
                f"{_BOLD[judged.corrected_verdict]}, {shown_p(judged.corrected_p)}",
            )
        )
        said = sentence
    return Table(
        (
            *("the thesis says", "finding", "wanted", "measured [95 %], runs"),
            *("verdict", "corrected, p"),
        ),
        rows,
    )


# --- Readings ------------------------------------------------------------------------------------


def _add_readings(found: Found, results: Results) -> None:
    reader, every = _reader_of([results]), readings.readings_of(results.groups)
    rows = [
        (
            reading.label,
            *(
                NONE if estimate is None else shown_estimate(estimate, quantity.form)
                for quantity in readings.QUANTITIES
                for estimate in [readings.quantity_of(quantity, reader, reading)]
            ),
        )
        for reading in every
    ]
    header = ("reading", *(quantity.title for quantity in readings.QUANTITIES))
    found.tables["readings"] = Table(header, rows)
    dependences = readings.dependences(reader, every)
    counts = Counter(dependence.standing for dependence in dependences)
    for standing in ("robust", "fitted", "open"):
        found.texts[standing] = str(counts[standing])
    found.texts["depending"] = str(len(dependences))
    order = ("robust", "fitted", "open")
    found.tables["dependences"] = Table(
        ("finding", "standing", "does not hold with", "undecided with"),
        [
            (
                dependence.finding.claim,
                dependence.standing,
                ", ".join(dependence.failing) or NONE,
                ", ".join(dependence.undecided) or NONE,
            )
            for dependence in sorted(dependences, key=lambda d: order.index(d.standing))
        ],
    )


# --- Variants ------------------------------------------------------------------------------------


def mean_of(group: Group, column: str) -> Estimate:
    """The mean of a column over the runs of a variant."""
    return estimates.mean(group.values(column), bootstrap_rng())


def difference(results: Results, first: str, second: str, column: str) -> Estimate:
    """How much more a variant has than another, by their labels."""
    terms = [(1.0, results.group(first)), (-1.0, results.group(second))]
    by_seed = [(weight, group.by_seed(column)) for weight, group in terms]
    return estimates.contrast(by_seed, bootstrap_rng()).estimate


def _means(name: str, results: Results) -> dict[str, str]:
    """The means of all variants by ``EXPERIMENT: LABEL: COLUMN``, those of draws aside."""
    found = {
        f"{name}: {group.label}: {column}": shown_estimate(mean_of(group, column), _REWARDS)
        for group in results.groups
        for column in BY_COLUMN
        if column in SHOWN and not is_draw(group.label) and read.measured([group], column)
    }
    reached = {
        f"{name}: {group.label}: {PASSAGE}": _passage(group)
        for group in results.groups
        if not is_draw(group.label)
    }
    return found | reached


def _passage(group: Group) -> str:
    """The median of the steps until a reward of 70 is kept, in millions."""
    every = [*group.passages(PASSAGE).values()]
    if not every:
        return NONE
    return shown_median(passages.arrivals(every), in_millions)


def _row(label: str, group: Group) -> Sequence[str]:
    means = (shown_estimate(mean_of(group, column), _REWARDS) for column in SHOWN)
    return (label, f"{len(group.runs)}", *means, _passage(group))


def variants_table(results: Results) -> Table:
    """Variants, a row each: where they end, by greed as well, and how fast they got there."""
    rows = [_row(group.label, group) for group in results.groups]
    return Table(("", "runs", *SHOWN.values(), "M steps to 70"), rows)


def _add_learners(found: Found, results: Sequence[Results]) -> None:
    """The thesis's four learners in its worlds."""
    rows = [run for each in results for run in each.folder.rows]
    placed = thesis.placed_of(groups_of(rows))
    lines = [
        _row(f"{world}: {learner}", Group(learner, learner, {}, [*placed[world, learner]]))
        for world in thesis.WORLDS
        for learner in thesis.LEARNER_TITLES
        if (world, learner) in placed
    ]
    header = ("world: learner", "runs", *SHOWN.values(), "M steps to 70")
    found.tables["learners"] = Table(header, lines)


def _add_spread(found: Found, name: str, results: Results) -> None:
    """From where to where the means of the variants of a search or a sweep reach."""
    for column in SEARCHED_FOR:
        means = [mean_of(group, column).value for group in results.groups]
        for key, value in (("lowest", min(means)), ("highest", max(means))):
            found.texts[f"{name}: {key} {column}"] = shown_number(value, _REWARDS)


def _best_of(results: Results) -> dict[str, dict[str, Any]]:
    """The best variant of each preset by each of what is searched for: the end, and speed."""
    found: dict[str, dict[str, Any]] = {}
    for preset in dict.fromkeys(group.preset for group in results.groups):
        groups = [group for group in results.groups if group.preset == preset]
        for column in SEARCHED_FOR:
            best = max(groups, key=lambda group: mean_of(group, column).value)
            mean = round(mean_of(best, column).value, 2)
            entry = {"variant": best.label, "mean": mean, "sets": dict(best.overrides)}
            found.setdefault(preset, {})[column] = entry
    return found


def _add_effects(found: Found, results: Results) -> None:
    """What each number of a schedule accounts for."""
    draws = [group for group in results.groups if is_draw(group.label)]
    settings = draws[0].runs[0].settings
    factors = effects.factors_of([group.overrides for group in draws], settings)
    analyses = {
        column: effects.analysed(factors, [mean_of(group, column).value for group in draws])
        for column in SEARCHED_FOR
    }
    header = ("number of the schedule", "of the reward at the horizon", "of the area")
    rows = [
        (
            factor.axle.label,
            *(_share(analysis, place) for analysis in analyses.values()),
        )
        for place, factor in enumerate(factors)
    ]
    found.tables["effects"] = Table(header, rows)
    for column, analysis in analyses.items():
        if analysis is not None:
            found.texts[f"effects: {column}"] = in_words(analysis, BY_COLUMN[column].title, "draws")


def _share(analysis: Analysis | None, place: int) -> str:
    if analysis is None:
        return NONE
    share = analysis.alone[place]
    shown = f"{share.of_variance:.0%}".replace("%", "\N{NO-BREAK SPACE}%")
    return f"**{shown}**" if share.is_significant else shown
