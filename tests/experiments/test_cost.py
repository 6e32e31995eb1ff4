"""What an experiment would take, against what it takes."""

import json
import math
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.cli import main
from app.documents.experiments import load, parse
from app.experiments import cost
from app.experiments.cost import estimated_steps, plan
from app.experiments.task import made_run
from learners.spec import RunSpec

EARLY = """
presets: [timed]
grid:
  schedule.skills.circle_clockwise.at: [500, 1000, 2000]
  schedule.skills.avoid.at: [500, 1500, 2500]
trials: 5000
seeds: 1
"""
STOP = "presets: [hierarchical_2, timed]\nstop: {success: 0.7}\nseeds: 2\n"


@pytest.fixture(autouse=True)
def nothing_is_measured_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "_speeds", {})


def clock(of_the_processor: Iterator[float], now: list[float]) -> SimpleNamespace:
    return SimpleNamespace(thread_time=of_the_processor.__next__, monotonic=lambda: now[0])


def steps_made(text: str) -> int:
    experiment = parse(text, "mine.yaml")
    made = (
        made_run(v.spec, seed, experiment.trials_of(v), experiment.steps, experiment.stop)
        for v, seed in experiment.runs()
    )
    return sum(run.step for run in made if run is not None)


def test_steps_are_of_the_right_size() -> None:
    found = plan(load("figure_4_1", 3), 2)
    assert found.runs == 12
    assert found.steps == pytest.approx(74e6, rel=0.2)  # 74 million were measured
    with_budget = parse("presets: [timed]\nsteps: 1000\nseeds: 5", "my.yaml")
    assert plan(with_budget, 2).steps == 5000


def test_steps_are_of_the_right_size_where_skills_join_early_and_runs_are_short() -> None:
    assert plan(parse(EARLY, "mine.yaml"), 2).steps == pytest.approx(steps_made(EARLY), rel=0.25)


def test_a_skill_that_joins_late_makes_late_trials_long() -> None:
    experiment = parse("presets: [timed]\ntrials: 12000\n", "mine.yaml")
    (alone,) = experiment.variants
    experiment_after = parse("presets: [timed]\ntrials: 14000\n", "mine.yaml")
    (explored,) = experiment_after.variants
    without, beyond = (
        estimated_steps(experiment, alone),
        estimated_steps(experiment_after, explored),
    )
    # Circling is explored in 2,000 of the 14,000 trials, and they take longer than all others.
    assert beyond - without > without


def test_an_experiment_with_a_stop_takes_less_than_is_said() -> None:
    found = plan(parse(STOP, "mine.yaml"), 2)
    assert found.at_most
    assert steps_made(STOP) < found.steps
    assert not plan(parse(EARLY, "mine.yaml"), 2).at_most


# --- Time ----------------------------------------------------------------------------------------


def test_the_time_is_that_of_all_presets_however_fast_one_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def seconds(spec: RunSpec) -> float:
        return 3e-3 if spec.learner.skills else 1e-3

    monkeypatch.setattr(cost, "_seconds_of_a_step", seconds)
    found = plan(parse("presets: [timed, standard_q]\nsteps: 1000\nseeds: 5", "my.yaml"), 1)
    assert found.steps == 10_000
    assert found.seconds == pytest.approx(20, rel=0.01)


def test_of_several_pilots_the_one_that_was_held_up_least_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks = iter([0.0, 3.0, 10.0, 12.0, 20.0, 25.0])
    monkeypatch.setattr(cost, "time", clock(looks, [0.0]))
    found = plan(parse("presets: [timed]\nsteps: 50000\nseeds: 1", "my.yaml"), 1)
    assert found.seconds == pytest.approx(2, rel=0.01)


def test_a_clock_that_stands_for_a_moment_still_gives_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks = iter([0.0, 0.0, 0.0, 6.0] * 3)
    monkeypatch.setattr(cost, "time", clock(looks, [0.0]))
    found = plan(parse("presets: [timed]\nsteps: 50000\nseeds: 1", "my.yaml"), 1)
    assert found.seconds == pytest.approx(2, rel=0.01)


def test_a_speed_is_good_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    # Each look is later than the one before by more and more.
    looks = (float(number**2) for number in count())
    monkeypatch.setattr(cost, "time", clock(looks, now))
    experiment = parse("presets: [timed]\nsteps: 50000\nseeds: 1", "my.yaml")
    first = plan(experiment, 1).seconds
    now[0] = 300.0
    assert plan(experiment, 1).seconds == first
    now[0] = 3_000.0
    assert plan(experiment, 1).seconds > first


def plan_with_epsilon(epsilon: float) -> None:
    text = f"presets: [timed]\nset: {{learner.epsilon: {epsilon}}}\nsteps: 50\n"
    assert math.isfinite(plan(parse(text, "my.yaml"), 1).seconds)


def test_speeds_of_many_presets_are_not_kept_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "_measured", lambda spec: 1e-6)
    for number in range(200):
        plan_with_epsilon(number / 1000)
    assert len(cost._speeds) < 100


def measured_in(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Gains the epsilon of each preset whose speed is measured, in one pilot."""
    found: list[float] = []

    def measured(spec: RunSpec) -> float:
        found.append(spec.learner.epsilon)
        return 1e-6

    monkeypatch.setattr(cost, "_measured", measured)
    monkeypatch.setattr(cost, "_PILOTS", 1)
    return found


def test_a_longer_run_with_another_schedule_is_as_fast_and_not_measured_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    measured = measured_in(monkeypatch)
    for text in (
        "presets: [timed]\n",
        "presets: [timed]\ntrials: 60000\n",
        "presets: [timed]\nsteps: 50000\n",
        "presets: [timed]\nset: {description: mine, schedule.skills.avoid.at: 31000}\n",
    ):
        plan(parse(text, "my.yaml"), 1)
    assert len(measured) == 1
    plan_with_epsilon(0.25)
    assert len(measured) == 2


def test_a_speed_that_was_measured_again_is_not_the_oldest_any_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(cost, "time", clock(count(0.0), now))
    monkeypatch.setattr(cost, "_MOST_KEPT", 3)
    measured = measured_in(monkeypatch)
    plan_with_epsilon(0.1)
    now[0] = cost._KEPT_S
    plan_with_epsilon(0.2)
    now[0] += 1.0
    plan_with_epsilon(0.1)
    plan_with_epsilon(0.3)
    plan_with_epsilon(0.4)
    assert measured == [0.1, 0.2, 0.1, 0.3, 0.4]
    plan_with_epsilon(0.1)
    assert measured[5:] == [], "it was put out in place of the oldest"


# --- In words ------------------------------------------------------------------------------------


def planned(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, *words: str) -> str:
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    assert main.main(["experiment", str(file), "--dry-run", *words]) == 0
    return capsys.readouterr().out


def test_what_is_little_is_not_said_to_be_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "presets: [timed]\nset: {world.size: 30}\ntrials: 600\nseeds: 1\n"
    said = planned(tmp_path, capsys, text)
    assert "less than a second with" in said
    assert "0.1 MB" in said
    assert " 0 " not in said


def test_a_stop_makes_it_an_upper_bound(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "steps  at most about" in planned(tmp_path, capsys, STOP)
    assert json.loads(planned(tmp_path, capsys, STOP, "--json"))["at_most"] is True
    assert "at most" not in planned(tmp_path, capsys, EARLY)
