"""The Experiments tab: what it would run, what that costs, and how it stands, in words."""

from pathlib import Path
from typing import Any

import pytest

from app import presets, snapshot, timeline
from app.cost import Plan
from app.experimenter import cost_html, duration, progress_html, session_experiment
from app.experiments import parse
from app.gathered import Gatherer
from app.laboratory import Progress
from app.snapshot import Snapshot
from app.workbench import Quote, Standing
from learners.commands import Explore, Introduce
from learners.run import Run


def moment(run: Run, preset: str) -> Snapshot:
    return snapshot.take(run, preset, 0, None, True)


def test_a_session_that_followed_its_preset_is_that_preset() -> None:
    spec = presets.load("timed")
    run = Run(spec, 5)
    run.advance(max_steps=3_000)
    (variant,) = session_experiment(moment(run, "timed"), 7).variants
    assert variant.spec == spec
    assert variant.label == "this session"


def test_what_was_done_by_hand_is_run_beside_the_preset_on_the_same_seeds() -> None:
    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    run.apply(Explore("circle_clockwise", 100, 0.5))
    run.advance(until_trial=80)
    experiment = session_experiment(moment(run, "timed"), 30)
    mine, shipped = experiment.variants
    assert mine.spec == timeline.preset_of(moment(run, "timed"))[0]
    assert mine.spec.schedule.introduced_at("circle_clockwise") == 50
    assert shipped.spec == presets.load("timed")
    assert (shipped.label, mine.label) == ("timed", "this session")
    assert experiment.n_runs == 60
    assert list(experiment.seeds_of(mine)) == list(experiment.seeds_of(shipped)) == [*range(30)]


def test_a_loaded_preset_has_nothing_beside_it() -> None:
    run = Run(presets.load("timed", ["learner.epsilon=0.2"]), 5)
    experiment = session_experiment(moment(run, "mein <b>Räuber"), 2)
    assert [variant.label for variant in experiment.variants] == ["this session"]
    assert experiment.variants[0].spec.learner.epsilon == 0.2


def test_the_text_of_a_session_is_the_whole_experiment() -> None:
    run = Run(presets.load("timed", ['description="Zeile: #1"', "world.size=40"]), 5)
    experiment = session_experiment(moment(run, "mine"), 3)
    again = parse(experiment.text, "session.yaml", None, 3)
    assert again.variants == experiment.variants
    assert again.seeds == experiment.seeds


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.2, "0 s"), (89, "89 s"), (600, "10 min"), (36_000, "10.0 h")]
)
def test_times_are_short(seconds: float, words: str) -> None:
    assert duration(seconds) == words


def quote(done: int = 0, runs: int = 12) -> Quote:
    return Quote(Plan(4, runs, 74_000_000, 8.0, 4_200_000), Path("results/<b>"), done)


def test_the_cost_is_of_what_is_left() -> None:
    whole = cost_html(quote(), 3)
    assert "12 runs" in whole
    assert "74 M steps" in whole
    assert "8 s" in whole
    assert "&lt;b&gt;" in whole
    half = cost_html(quote(done=6), 3)
    assert "6 are there already" in half
    assert "37 M steps" in half
    assert "All 12 runs are in" in cost_html(quote(done=12), 3)


def standing(**changes: Any) -> Standing:
    experiment = parse("presets: [timed]\nseeds: 4", "a <b>.yaml")
    found = Progress(4, 1, 1, 2, 5_000_000, 2e6, 0.4, 9.0)
    state = {"progress": found, "running": True, "paused": False, "error": "", **changes}
    return Standing(experiment, Path("results"), Gatherer(experiment), **state)


def test_how_it_stands_is_said_in_words() -> None:
    running = progress_html(standing())
    assert "a &lt;b&gt;" in running
    assert "1 of 4 runs done, 1 failed, 2 running" in running
    assert "2 M steps/s, about 9 s left" in running
    assert "paused" in progress_html(standing(paused=True))
    assert "start it again" in progress_html(standing(running=False))
    over = Progress(4, 3, 1, 0, 5_000_000, 2e6, 1.0, 0.0)
    assert "start it again" not in progress_html(standing(running=False, progress=over))
    assert "No &lt;space&gt;" in progress_html(standing(running=False, error="No <space>"))
    assert "getting ready" in progress_html(standing(progress=None))
