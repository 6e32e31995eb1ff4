"""Variants beside the one that they are set against: on the page as in a report."""

from app.analysis import estimates
from app.analysis.estimates import bootstrap_rng
from app.charts import variants
from app.charts.differences import MOST_COMPARED, differences_of
from app.charts.page.results import results_html
from app.charts.view import Size, View
from app.results.gather import PlacedRun
from tests.support.runs import PLANE, THESIS, Shown, address, experiment_of, fact, filled

MANY = THESIS.replace("seeds: 3", "seeds: 10")


def runs_of(n_seeds: int, lead: float) -> list[PlacedRun]:
    """Runs of two of the learners, the second higher by so much, and a little more each time."""
    own = [50 + 7 * (seed * 5 % 11) for seed in range(n_seeds)]
    return [
        *(fact(0, seed, value) for seed, value in enumerate(own)),
        *(fact(1, seed, value + lead + seed % 3 - 1) for seed, value in enumerate(own)),
    ]


def said_of(runs: list[PlacedRun], label: str) -> list[str]:
    """Cells of a variant's row, and the heading of its difference."""
    gatherer = filled(experiment_of(MANY), runs)
    page = Shown(results_html(gatherer, gatherer.gathering(), View("runs"), address, Size()))
    table = page.one("table", class_="differences")
    heading = "".join(page.all("th", table)[2].itertext())
    rows = [["".join(cell.itertext()) for cell in row.iter("td")] for row in page.all("tr", table)]
    return next([*row, heading] for row in rows if row and row[0] == label)


def test_a_difference_is_paired_and_is_that_of_the_report() -> None:
    runs = runs_of(10, 5.0)
    first, second = (
        {run.seed: run.values["final_reward"] for at, run in runs if at == place}
        for place in (0, 1)
    )
    reported = estimates.compare(second, first, bootstrap_rng()).difference
    found = differences_of(
        filled(experiment_of(MANY), runs), filled(experiment_of(MANY), runs).gathering(), None
    )
    assert found is not None
    assert found.rows[0].label == "standard_q"
    assert found.rows[0].difference is None
    shown = next(row for row in found.rows if row.place == 1)
    assert shown.difference is not None
    assert shown.difference.estimate == reported
    assert (shown.over, shown.verdict) == ("paired over 10 seeds", "higher")


def test_a_row_says_how_much_higher_a_variant_is_and_over_what() -> None:
    label, _, difference, verdict, heading = said_of(runs_of(10, -5.0), "hierarchical_3")
    assert label == "hierarchical_3"
    assert difference.startswith("\N{MINUS SIGN}5.")
    assert verdict == "lower"
    assert heading == "difference to standard_q, paired over 10 seeds"


def test_what_is_undecided_is_called_so() -> None:
    assert said_of(runs_of(10, 0.0), "hierarchical_3")[3] == "undecided"
    assert said_of(runs_of(9, 5.0), "hierarchical_3")[3] == "undecided: too few runs"


def test_of_many_variants_the_chosen_one_alone_is_set_against_another() -> None:
    experiment = experiment_of(f"{PLANE}\nseeds: 2")
    assert len(experiment.variants) > MOST_COMPARED
    gatherer = filled(experiment, [fact(place, 0, 1.0 * place) for place in range(12)])
    own = variants.reference(experiment)
    none = differences_of(gatherer, gatherer.gathering(), None)
    found = differences_of(gatherer, gatherer.gathering(), 5)
    assert none is not None
    assert found is not None
    assert [row.place for row in none.rows] == [own]
    assert [row.place for row in found.rows] == [own, 5]
    page = Shown(results_html(gatherer, gatherer.gathering(), View("plane"), address, Size()))
    assert "choose it in a chart" in page.text


def test_one_variant_is_set_against_nothing() -> None:
    gatherer = filled(experiment_of("presets: [timed]"), [fact(0, 0, 1.0)])
    assert differences_of(gatherer, gatherer.gathering(), None) is None
