"""What goes beyond the thesis, as its page says it: learners against one another in five worlds."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from app.analysis import estimates
from app.analysis.estimates import bootstrap_rng
from app.charts.model import Curves, Dot, Dots, Panel, RunDot, with_clear_marks
from app.charts.paper.drawing import Drawing, drawn
from app.charts.read import line_of
from app.charts.styles import style_of
from app.charts.wording import shown_estimate
from app.experiments.store import REPORT_PAGE, figures_of
from app.metrics import BY_COLUMN
from app.replication.page import Found, Table, with_place
from app.replication.plan import BEYOND
from app.replication.variants import (
    REWARDS,
    Results,
    logs_of,
    mean_of,
    passage_of,
    results_in,
    variants_table,
)
from app.report.sections.standings import AGAINST, COLUMNS, Field, field_of, in_order
from app.results.read import Group, ResultsError
from app.util.files import write_whole
from app.words.numbers import NONE

PAGE: Final = "beyond.md"
NUMBERS: Final = "beyond.json"
PAGES: Final[Mapping[str, str]] = {PAGE: "beyond.md", "beyond/templates.md": "templates.md"}
"""Pages with a part that is from the results, and the templates of these."""
_TOLD: Final = "three skills, approach behind the prey, circle in front"
"""The variant with templates that the first page speaks of."""
_HORIZON: Final = 5_500_000
_FIGURE: Final = "standings"
_DRAWN: Final[Mapping[str, Sequence[str]]] = {
    "introduction": ("timed", "timed_auto"),
    "context": ("timed_auto", "timed_context"),
    "held": ("standard_q", "standard_q_held", "timed_held"),
    "lin": ("hierarchical_3", "hierarchical_3_persistent", "hierarchical_3_taught"),
    "static": ("timed", "static_appetite_fear"),
    "feudal": ("standard_q", "timed", "feudal"),
    "q_lambda": ("standard_q", "q_lambda"),
}
"""By page on one thing, whose name its figure has: the learners whose curves are in it."""
_CURVED: Final = ("standard", "sensors 8 x 6")
"""The worlds in which: the one in which all is tuned, and the one in which least can be seen."""
_COHERENCE: Final = ("without_progress",)
"""What is drawn of it: what means the same for all learners."""
_TITLES: Final = {
    "horizon_area": "area",
    "horizon_reward": "reward in the end",
    "horizon_greedy": "by greed",
    "mean_choice": "run of a choice",
    "without_progress": "without progress",
}
"""Columns of the table of the standard world."""
_FORMS: Final = {"without_progress": ".2f"}


def beyond_in(path: Path) -> Found:
    """Everything that the page says.

    Args:
        path: the folder of results of the experiment.

    Raises:
        ResultsError: it was not run, or not all of it.
    """
    results = results_in(path)
    field = field_of(results.groups)
    if field is None:
        raise ResultsError(f"{str(path)!r} has not each learner in each world")
    found = Found()
    found.texts["runs"] = f"{len(results.folder.rows):,}"
    found.texts["steps"] = f"{sum(run.steps for run in results.folder.rows) / 1e9:.1f}"
    for (preset, world), group in field.groups.items():
        for column in _TITLES:
            found.texts[f"{preset}, {world}: {column}"] = shown_estimate(
                mean_of(group, column), _FORMS.get(column, REWARDS)
            )
        found.texts[f"{preset}, {world}: steps_to_70"] = passage_of(group)
    for world in field.worlds:
        for column in COLUMNS:
            _add_ranks(found, field, world, column)
    order = in_order(field, COLUMNS[0])
    found.tables["standard"] = _standard_table(field, order)
    for column in COLUMNS:
        found.tables[f"worlds: {column}"] = _worlds_table(field, order, column)
    for column in _TITLES:
        found.tables[f"leads: {column}"] = _leads_table(field, order, column)
    return found


def write_beyond(out: Path, docs: Path, tell: Callable[[str], object] = lambda _: None) -> Path:
    """Write the parts of the pages that are from the results anew, with numbers and figures.

    Args:
        out: the folder of all results, with the reports on these experiments.
        docs: the folder of the documentation.
        tell: told what is being done.

    Returns:
        The first of the pages.

    Raises:
        ResultsError: an experiment was not run.
        OSError: something cannot be read or written.
        ValueError: a page has no place for what came out.
    """
    name, templates = BEYOND
    tell("setting learners against one another")
    found = beyond_in(out / name)
    seeded = results_in(out / templates)
    found.tables[templates] = variants_table(seeded)
    told = mean_of(seeded.group(_TOLD), COLUMNS[0])
    found.texts[f"{templates}: {COLUMNS[0]}"] = shown_estimate(told, REWARDS)
    pages = {
        docs / place: with_place((docs / place).read_text("utf-8"), template, found)
        for place, template in PAGES.items()
    }
    tell("drawing figures")
    for figure, drawing in (*_figures_of(out / name), (templates, _templates_figure(seeded))):
        write_whole(docs / "figures" / f"{name}_{figure}.png", drawing.png)
    picture = (figures_of(out / name / REPORT_PAGE) / f"{_FIGURE}.png").read_bytes()
    write_whole(docs / "figures" / f"{name}.png", picture)
    write_whole(docs / NUMBERS, found.to_json().encode())
    for page, text in pages.items():
        write_whole(page, text.encode())
    return docs / PAGE


def _figures_of(path: Path) -> Iterator[tuple[str, Drawing]]:
    """Figures of the pages on one thing each, by their names."""
    results = results_in(path)
    field = field_of(results.groups)
    assert field is not None, "asked before"
    reader, note = logs_of([results]).reader, "Made by: pounce replicate --beyond"
    n = max(len(group.runs) for group in results.groups)
    for name, presets in _DRAWN.items():
        panels = [
            Panel(
                world,
                with_clear_marks(
                    [
                        line_of(reader, p, field.groups[p, world].runs, "steps", style_of(place))
                        for place, p in enumerate(presets)
                    ]
                ),
            )
            for world in _CURVED
        ]
        small = (
            f"Mean reward per trial, and its 95 % bootstrap interval over {n} runs, in windows of"
            f" {reader.widths.of('steps', 'steps') / 1e6:g} M steps.\n{note}"
        )
        yield name, drawn(name, Curves("steps", panels), small)
    first, order = field.worlds[0], in_order(field, COLUMNS[0])
    columns = {
        BY_COLUMN[column].label: [
            Dot(p, field.mean(p, first, column), _dots(field.groups[p, first], column))
            for p in order
        ]
        for column in _COHERENCE
    }
    small = (
        "Small: a run each, in the standard world. Large: their mean with its 95 % interval."
        f" Of greedy hunts.\n{note}"
    )
    yield "coherence", drawn("coherence", Dots(columns), small)


def _templates_figure(results: Results) -> Drawing:
    """What tables gain that begin with something."""
    columns = {
        BY_COLUMN[column].at(_HORIZON).title: [
            Dot(g.label, mean_of(g, column), _dots(g, column)) for g in results.groups
        ]
        for column in COLUMNS[:2]
    }
    small = "Small: a run each, in the standard world. Large: their mean with its 95 % interval."
    return drawn("templates", Dots(columns), f"{small}\nMade by: pounce replicate --beyond")


def _dots(group: Group, column: str) -> list[RunDot]:
    return [RunDot(run.values[column], run.seed) for run in group.runs]


def _add_ranks(found: Found, field: Field, world: str, column: str) -> None:
    """Who comes first in a world, and how far each is from the one they are set against."""
    order = sorted(field.presets, key=lambda p: -field.mean(p, world, column).value)
    found.texts[f"order, {world}: {column}"] = ", ".join(f"`{preset}`" for preset in order)
    for preset in field.presets:
        found.texts[f"lead of {preset}, {world}: {column}"] = _lead(field, preset, world, column)


def _lead(field: Field, preset: str, world: str, column: str) -> str:
    """How much more a learner has than the one it is set against, paired by seed."""
    if AGAINST not in field.presets or preset == AGAINST:
        return NONE
    pair = ((1.0, preset), (-1.0, AGAINST))
    terms = [(weight, field.groups[who, world].by_seed(column)) for weight, who in pair]
    estimate = estimates.contrast(terms, bootstrap_rng()).estimate
    return shown_estimate(estimate, _FORMS.get(column, REWARDS))


def _standard_table(field: Field, order: Sequence[str]) -> Table:
    first = field.worlds[0]
    rows: list[Sequence[str]] = []
    for preset in order:
        group = field.groups[preset, first]
        cells = [
            shown_estimate(mean_of(group, column), _FORMS.get(column, REWARDS))
            for column in _TITLES
        ]
        rows.append((f"`{preset}`", *cells[:3], passage_of(group), *cells[3:]))
    titles = [*_TITLES.values()]
    return Table(("learner", *titles[:3], "M steps to 70", *titles[3:]), rows)


def _worlds_table(field: Field, order: Sequence[str], column: str) -> Table:
    rows = [
        (
            f"`{preset}`",
            *(
                shown_estimate(mean_of(field.groups[preset, world], column), REWARDS)
                for world in field.worlds
            ),
        )
        for preset in order
    ]
    return Table((f"{BY_COLUMN[column].title}", *field.worlds), rows)


def _leads_table(field: Field, order: Sequence[str], column: str) -> Table:
    rows = [
        (f"`{preset}`", *(_lead(field, preset, world, column) for world in field.worlds))
        for preset in order
        if preset != AGAINST
    ]
    return Table((f"lead over `{AGAINST}`: {BY_COLUMN[column].title}", *field.worlds), rows)
