"""Which runs are the thesis's own, and where they belong."""

import dataclasses

import pytest

from app.documents import experiments
from app.experiments.record import Record
from app.results import thesis
from app.results.findings import Place
from app.results.read import Group
from app.results.thesis import quantities
from tests.support.places import ORIGIN, run_of

PLACES = [(world, learner) for world in thesis.WORLDS for learner in thesis.LEARNERS]


@pytest.mark.parametrize("place", PLACES, ids=" ".join)
def test_each_place_is_known_by_its_settings(place: Place) -> None:
    assert thesis.place_of(run_of(place)) == place


def test_a_changed_learner_is_of_no_place() -> None:
    run = run_of(("120", "timed"))
    learner = {**run.settings["learner"], "alpha": 0.2}
    changed = dataclasses.replace(run, settings={**run.settings, "learner": learner})
    assert thesis.place_of(changed) is None


def test_runs_that_may_have_ended_early_are_of_no_place() -> None:
    run = run_of(("120", "timed"))
    limited = dataclasses.replace(run, origin=ORIGIN._replace(limited=True))
    assert thesis.place_of(limited) is None
    assert thesis.placed_of([Group("", "timed", {}, [limited])]) == {}


def test_any_seeds_and_a_horizon_are_the_thesiss() -> None:
    run = run_of(("60", "standard_q"), seed=41_017)
    planned = dataclasses.replace(run, origin=ORIGIN._replace(horizon=5_500_000))
    assert thesis.place_of(planned) == ("60", "standard_q")


def placed(*runs: Record) -> dict[Place, list[Record]]:
    return thesis.placed_of([Group("", "timed", {}, [run]) for run in runs])


def test_a_run_that_is_in_several_experiments_counts_once() -> None:
    place = "120", "timed"
    first, again, other = run_of(place, 1), run_of(place, 1), run_of(place, 2)
    assert placed(first, other, again) == {place: [first, other]}


def test_runs_count_by_the_longest_horizon_that_is_stated_not_by_how_long_they_are() -> None:
    place = "120", "timed"
    near, far = (ORIGIN._replace(horizon=horizon) for horizon in (1_000_000, 5_500_000))
    without = run_of(place, 1, steps=9_000_000)
    short = dataclasses.replace(run_of(place, 2, steps=8_000_000), origin=near)
    long = [dataclasses.replace(run_of(place, seed), origin=far) for seed in (3, 1)]
    assert placed(without, short, *long) == {place: long}
    assert placed(without, short) == {place: [short]}
    assert placed(without) == {place: [without]}


# --- The shipped experiments ---------------------------------------------------------------------


EXPERIMENTS = ("figure_4_1", "figure_4_2", "figure_4_3", "sentences")


def test_these_make_all_the_runs_that_findings_speak_of() -> None:
    found = [experiments.load(name) for name in EXPERIMENTS]
    run = run_of(("120", "timed"))
    settings = [v.spec.model_dump(mode="json") for each in found for v in each.variants]
    places = {thesis.place_of(dataclasses.replace(run, settings=each)) for each in settings}
    assert None not in places
    wanted = {(term.world, term.learner) for f in thesis.FINDINGS for term in f.terms}
    assert wanted <= places


def test_they_go_on_until_the_horizon_that_findings_speak_of() -> None:
    found = [experiments.load(name) for name in EXPERIMENTS]
    assert {each.horizon for each in found} == {quantities.HORIZON}
    assert {(each.stop, each.steps) for each in found} == {(None, None)}


def test_every_place_that_is_named_is_one() -> None:
    assert {(t.world, t.learner) for f in thesis.FINDINGS for t in f.terms} <= {*PLACES}
    assert {world for _, worlds in thesis.FIGURES.values() for world in worlds} == {*thesis.WORLDS}
    assert [*thesis.WORLD_TITLES] == [*thesis.WORLDS]
