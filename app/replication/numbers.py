"""What came out, as numbers and tables of the pages: read from the folders of all experiments."""

import math
import statistics
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from app.analysis import effects
from app.analysis.effects import Analysis
from app.analysis.estimates import bootstrap_rng
from app.charts.wording import shown_estimate, shown_p
from app.documents.samples import is_draw
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table
from app.replication.plan import EXPERIMENTS, THESIS
from app.replication.quantities import facts_table
from app.replication.variants import (
    REWARDS,
    SEARCHED_FOR,
    Logs,
    Results,
    add_learners,
    add_standard_world,
    elsewhere_table,
    logs_of,
    mean_of,
    means_of,
    results_in,
    variants_table,
)
from app.report.sections.effects import in_words
from app.results import findings, readings, thesis
from app.results.findings import FAILS, HOLDS, UNDECIDED, Finding, Judged
from app.results.read import Reader
from app.results.readings import Dependence
from app.results.thesis import Placed
from app.results.thesis.standard import FAR_SOONER
from app.words.numbers import NONE, shown_number

SEARCHES: Final = ("baselines_search", "timing_seven")
_BOLD: Final = {HOLDS: "holds", FAILS: "**does not hold**", UNDECIDED: "undecided"}


def found_in(out: Path, tell: Callable[[str], object] = lambda _: None) -> Found:
    """Everything that the pages say.

    Args:
        out: the folder that holds a folder of results for each experiment.
        tell: told what is being done.

    Raises:
        ResultsError: an experiment was not run, or its results are damaged.
    """
    every = {name: results_in(out / name) for name in EXPERIMENTS}
    found = Found()
    runs = [run for results in every.values() for run in results.folder.rows]
    found.texts["runs"] = f"{len(runs):,}"
    found.texts["steps"] = f"{sum(run.steps for run in runs) / 1e9:.0f}"
    found.texts["experiments"] = f"{len(every)}"
    for name, results in every.items():
        found.texts |= means_of(name, results)
    tell("judging the findings")
    logs = logs_of([every[name] for name in THESIS])
    _add_findings(found, logs)
    tell("reading the thesis otherwise")
    _add_readings(found, every["reading"])
    for name in ("baselines", "together", "ablation", "timing_test"):
        found.tables[f"{name} table"] = variants_table(every[name])
    found.tables["baselines elsewhere"] = elsewhere_table(every["baselines"])
    add_learners(found, logs.placed)
    add_standard_world(found, every["figure_4_1"])
    found.tables["facts"] = facts_table(logs)
    for name in ("timing_seven", "timing_plane"):
        _add_spread(found, name, every[name])
    for name in SEARCHES:
        found.searches[name] = _best_of(every[name])
    tell("looking at what was drawn")
    _add_effects(found, every["timing_seven"])
    return found


# --- Findings ------------------------------------------------------------------------------------


def _add_findings(found: Found, logs: Logs) -> None:
    placed, reader = logs
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
    reader, every = logs_of([results]).reader, readings.readings_of(results.groups)
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
    found.tables["each reading"] = Table(header, [*zip(labels, *shown, strict=True)])
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


# --- Searches ------------------------------------------------------------------------------------


def _add_spread(found: Found, name: str, results: Results) -> None:
    """From where to where the means of the variants of a search or a sweep reach."""
    for column in SEARCHED_FOR:
        means = [mean_of(group, column).value for group in results.groups]
        for key, value in (("lowest", min(means)), ("highest", max(means))):
            found.texts[f"{name}: {key} {column}"] = shown_number(value, REWARDS)


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
