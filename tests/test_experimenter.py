"""The Experiments tab: what it would run, what that costs, and how it stands, in words."""

from pathlib import Path
from typing import Any

import pytest

from app import presets, snapshot, timeline
from app.cost import Plan
from app.experimenter import cost_html, not_repeated, progress_html, session_experiment
from app.experiments import parse
from app.gathered import Gatherer
from app.laboratory import Progress
from app.machine import duration
from app.snapshot import Snapshot
from app.workbench import Quote, Standing
from learners.commands import Explore, Introduce, SetParameter
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
    spec = presets.load("timed", ["world.size=40"])
    run = Run(spec, 5)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    run.apply(Explore("circle_clockwise", 100, 0.5))
    run.advance(until_trial=80)
    experiment = session_experiment(moment(run, 'mein "Räuber" 🐈'), 30)
    mine, former = experiment.variants
    assert mine.spec == timeline.preset_of(moment(run, "timed"))[0]
    assert mine.spec.schedule.introduced_at("circle_clockwise") == 50
    assert former.spec == spec
    assert (former.label, mine.label) == ('mein "Räuber" 🐈 as it was', "this session")
    assert experiment.n_runs == 60
    assert list(experiment.seeds_of(mine)) == list(experiment.seeds_of(former)) == [*range(30)]
    assert not_repeated(moment(run, "timed")) == ""


def test_what_a_session_cannot_repeat_is_said() -> None:
    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(SetParameter("learner.epsilon", 0.9))
    found = moment(run, "timed")
    assert "learner.epsilon was set to 0.9 at trial 50" in not_repeated(found)
    text = session_experiment(found, 3).text.decode()
    assert f"# {not_repeated(found)}" in text


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
    left = 1 - done / runs
    plan = Plan(4, runs, done, int(74_000_000 * left), 8.0 * left, int(4_200_000 * left))
    return Quote(plan, Path("results/<b>"))


def test_the_cost_is_of_what_is_left() -> None:
    whole = cost_html(quote(), 3)
    assert "12 runs" in whole
    assert "74 M steps" in whole
    assert "8 s" in whole
    assert "&lt;b&gt;" in whole
    assert "6 are there already" in cost_html(quote(done=6), 3)
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
    assert "Make the others goes on there" in progress_html(standing(running=False))
    over = Progress(4, 3, 1, 0, 5_000_000, 2e6, 1.0, 0.0)
    assert "goes on" not in progress_html(standing(running=False, progress=over))
    assert "No &lt;space&gt;" in progress_html(standing(running=False, error="No <space>"))
    assert "getting ready" in progress_html(standing(progress=None))
    assert progress_html(standing(progress=None, running=False)).endswith("stopped.")
