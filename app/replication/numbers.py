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
from app.charts.wording import shown_estimate, shown_p
from app.documents.samples import is_draw
from app.experiments import facts
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table
from app.replication.plan import EXPERIMENTS, THESIS
from app.report.sections.effects import in_words
from app.results import findings, read, readings, thesis
from app.results.findings import FAILS, HOLDS, UNDECIDED, Finding, Judged, Place
from app.results.read import Folder, Group, Reader, groups_of, read_folder
from app.results.readings import Dependence
from app.results.thesis import Placed
from app.results.thesis.quantities import EARLY_CAPTURES
from app.results.thesis.standard import FAR_SOONER
from app.words.numbers import NONE, shown_number

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
PASSAGES: Final = ("steps_to_70", "first_to_70")
"""The passage that tables of variants show, and what it is to be told apart from."""
ELSEWHERE: Final = ("size 60", "size 150", "sensors 16 x 11", "sensors 8 x 6")
"""The worlds in which what was tuned in the standard one is run as well."""
TUNED: Final = (
    ("standard Q, tuned for the end", "timed, tuned for the end"),
    ("standard Q, tuned for speed", "timed, tuned for speed"),
    ("standard Q, hopeful", "timed, tuned for the end"),
)
"""What is set against one another in all worlds."""

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
    found.tables["baselines elsewhere"] = elsewhere_table(every["baselines"])
    _add_learners(found, [every[name] for name in THESIS[:3]])
    _add_standard_world(found, every["figure_4_1"])
    found.tables["facts"] = facts_table([every[name] for name in THESIS])
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
    _add_sentences(found, every)
    found.texts["findings"] = str(len(every))
    found.texts["untestable"] = str(len(measured) - len(every))


def _add_sentences(found: Found, every: Sequence[Judged]) -> None:
    """How many sentences hold in all their findings; of some there are many, which overlap."""
    verdicts: dict[str, set[str]] = {}
    for judged in every:
        verdicts.setdefault(judged.finding.sentence, set()).add(judged.verdict)
    n_hold = sum(of_sentence == {HOLDS} for of_sentence in verdicts.values())
    n_fail = sum(FAILS in of_sentence for of_sentence in verdicts.values())
    found.texts["said"] = str(len(verdicts))
    found.texts["said hold"] = str(n_hold)
    found.texts["said fail"] = str(n_fail)
    found.texts["said undecided"] = str(len(verdicts) - n_hold - n_fail)


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
    columns = [
        (quantity, [readings.quantity_of(quantity, reader, reading) for reading in every])
        for quantity in readings.QUANTITIES
    ]
    for quantity, column in columns:
        values = [estimate.value for estimate in column if estimate is not None]
        for key, value in (("lowest", min(values)), ("highest", max(values))):
            found.texts[f"reading: {key} {quantity.title}"] = shown_number(value, quantity.form)
    shown = [
        [NONE if e is None else shown_estimate(e, quantity.form) for e in column]
        for quantity, column in columns
    ]
    header = ("reading", *(quantity.title for quantity in readings.QUANTITIES))
    labels = [reading.label for reading in every]
    found.tables["readings"] = Table(header, [*zip(labels, *shown, strict=True)])
    dependences = readings.dependences(reader, every)
    counts = Counter(dependence.standing for dependence in dependences)
    for standing in ("robust", "fitted", "open"):
        found.texts[standing] = str(counts[standing])
    found.texts["depending"] = str(len(dependences))
    _add_faster(found, dependences, [reading.label for reading in every])
    order = ("robust", "fitted", "open")
    found.tables["dependences"] = Table(
        ("finding", "standing", "readings", "does not hold with", "undecided with"),
        [
            (
                dependence.finding.claim,
                dependence.standing,
                f"{len(dependence.verdicts)}",
                ", ".join(dependence.failing) or NONE,
                ", ".join(dependence.undecided) or NONE,
            )
            for dependence in sorted(dependences, key=lambda d: order.index(d.standing))
        ],
    )


def _add_faster(found: Found, dependences: Sequence[Dependence], every: Sequence[str]) -> None:
    """Under which readings the timed learner is the faster one of all three, by a good deal."""
    faster = [d for d in dependences if d.finding.sentence == FAR_SOONER]
    others = [label for label in every if any(d.verdicts.get(label) != HOLDS for d in faster)]
    found.texts["tried"] = str(len(every))
    found.texts["faster"] = str(len(every) - len(others))
    found.texts["not surely faster"] = ", ".join(others) or "none"


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
        if column in (*SHOWN, "area")
        and not is_draw(group.label)
        and read.measured([group], column)
    }
    reached = {
        f"{name}: {group.label}: {column}": _passage(group, column)
        for group in results.groups
        for column in PASSAGES
        if not is_draw(group.label)
    }
    return found | reached


def _passage(group: Group, column: str = PASSAGES[0]) -> str:
    """The median of the steps until a reward of 70 is kept, or first touched, in millions."""
    every = [*group.passages(column).values()]
    if not every:
        return NONE
    arrived = passages.arrivals(every)
    median = arrived.median
    if math.isinf(median.value):
        return f"more than {arrived.last / 1e6:.1f}"
    ends = f" [{_millions(median.low)}, {_millions(median.high)}]" if median.has_interval else ""
    return f"{_millions(median.value)}{ends}"


def _millions(steps: float) -> str:
    return shown_number(steps / 1e6, ".2f") if math.isfinite(steps) else "\N{INFINITY}"


def _row(label: str, group: Group, shown: Sequence[str] = (*SHOWN,)) -> Sequence[str]:
    means = (shown_estimate(mean_of(group, column), _REWARDS) for column in shown)
    return (label, f"{len(group.runs)}", *means, _passage(group))


def variants_table(results: Results) -> Table:
    """Variants, a row each: where they end, by greed as well, and how fast they got there.

    Where runs end at the horizon, whatever their presets' trials, there is no other end. What is
    set against one another in all worlds has a table of its own.
    """
    is_cut = any(run.origin.steps_alone for run in results.folder.rows)
    shown = [column for column in SHOWN if not (is_cut and column.startswith("final_"))]
    tuned = {_in_world(label, where) for both in TUNED for label in both for where in ELSEWHERE}
    rows = [_row(g.label, g, shown) for g in results.groups if g.label not in tuned]
    return Table(("", "runs", *(SHOWN[column] for column in shown), "M steps to 70"), rows)


def elsewhere_table(results: Results) -> Table:
    """How what was tuned in the standard world does in it and in the others."""
    rows: list[Sequence[str]] = []
    for where in ("", *ELSEWHERE):
        for both in TUNED:
            theirs, mine = (_in_world(label, where) for label in both)
            cells: list[str] = []
            for column in SEARCHED_FOR:
                means = (mean_of(results.group(label), column) for label in (mine, theirs))
                lead = difference(results, mine, theirs, column)
                cells += [shown_estimate(e, _REWARDS) for e in (*means, lead)]
            rows.append((where or "standard", " / ".join(reversed(both)), *cells))
    what = [f"{when}: {which}" for when in ("end", "area") for which in ("first", "second", "lead")]
    return Table(("world", "first / second", *what), rows)


def _in_world(label: str, where: str) -> str:
    """What a variant is called where it is run in another world."""
    return f"{label} elsewhere, {where}" if where else label


def _add_standard_world(found: Found, results: Results) -> None:
    """Who ends where in the standard world, and how much runs of three skills differ."""
    for column in SHOWN:
        means = {group.label: mean_of(group, column).value for group in results.groups}
        order = sorted(means, key=lambda label: -means[label])
        found.texts[f"order: {column}"] = ", ".join(
            f"`{label}` {shown_number(means[label], _REWARDS)}" for label in order
        )
    ends = results.group("hierarchical_3").values("final_reward")
    sd = statistics.stdev(ends) if len(ends) > 1 else math.nan
    spread = {"sd": sd, "lowest": min(ends), "highest": max(ends)}
    found.texts["three skills: runs"] = str(len(ends))
    for key, value in spread.items():
        found.texts[f"three skills: {key}"] = shown_number(value, _REWARDS)


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


class Fact(NamedTuple):
    """A quantity that some findings set against another one, as it is."""

    what: str
    form: str
    places: Sequence[Place]
    quantity: str


_SIZES: Final = ("60", "120", "150")
_SENSORS: Final = ("120", "16×11", "8×6")
_FACTS: Final[Sequence[Fact]] = (
    *(
        Fact(
            f"captures in 100,000 early steps, {thesis.LEARNER_TITLES[learner]}",
            ".0f",
            [(world, learner) for world in _SIZES],
            EARLY_CAPTURES,
        )
        for learner in ("standard_q", "hierarchical_3", "timed")
    ),
    *(
        Fact(
            f"share of early steps that end in the state they began in,"
            f" {thesis.LEARNER_TITLES[learner]}",
            ".2f",
            [(world, learner) for world in _SENSORS],
            facts.STAYED,
        )
        for learner in ("standard_q", "hierarchical_3", "timed")
    ),
    *(
        Fact(
            f"share of its steps that make progress, {skill} after {step:,} steps",
            ".2f",
            [("120", learner)],
            facts.progress(skill, step),
        )
        for step in facts.PRACTICE_STEPS
        for learner, skill in (
            ("timed", "approach"),
            ("hierarchical_2", "approach"),
            ("hierarchical_2", "circle_clockwise"),
        )
    ),
    Fact(
        "cells from the prey as avoid is explored",
        ".0f",
        [("120", "timed"), ("120", "timed, avoid at 0.95")],
        facts.distance("avoid"),
    ),
)
"""What is shown beside the findings that compare it."""


def facts_table(results: Sequence[Results]) -> Table:
    """Quantities as they are, of which findings only say how they compare."""
    rows = [run for each in results for run in each.folder.rows]
    placed, reader = thesis.placed_of(groups_of(rows)), _reader_of(results)
    lines: list[Sequence[str]] = []
    for fact in _FACTS:
        for world, learner in fact.places:
            traces = reader.traces(placed[world, learner])
            values = [trace.quantities.get(fact.quantity, math.nan) for trace in traces]
            mean = estimates.mean(values, bootstrap_rng())
            place = f"{world}: {learner}"
            lines.append((fact.what, place, f"{mean.n}", shown_estimate(mean, fact.form)))
    return Table(("quantity", "world: learner", "runs", "mean [95 %]"), lines)


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
