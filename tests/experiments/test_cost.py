"""What an experiment would take, against what it takes."""

import json
import math
import time
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.cli import main
from app.documents.experiments import load, parse
from app.experiments import cost
from app.experiments.cost import longest_run, plan
from app.experiments.task import Limits, made_run

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
    monkeypatch.setattr(cost, "_known", {})
    # Whatever else this machine is at.
    monkeypatch.setattr(cost, "_cores_for", lambda _, n_threads, __: float(n_threads))


def steps_made(text: str) -> int:
    experiment = parse(text, "mine.yaml")
    made = (
        made_run(
            v.spec,
            seed,
            Limits(
                experiment.trials_of(v),
                experiment.steps,
                experiment.horizon_steps,
                experiment.stop,
            ),
        )
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
    without, beyond = (
        plan(parse(f"presets: [timed]\ntrials: {trials}\n", "mine.yaml"), 2).steps
        for trials in (12_000, 14_000)
    )
    # Circling is explored in 2,000 of the 14,000 trials, and they take longer than all others.
    assert beyond - without > without


def test_of_a_learner_that_nobody_has_seen_the_steps_are_known_as_well() -> None:
    text = "presets: [standard_q]\nset: {learner.alpha: 0, world.vision_radius: 0}\ntrials: 2000\n"
    assert plan(parse(text, "mine.yaml"), 2).steps == pytest.approx(steps_made(text), rel=0.05)


def test_presets_that_are_too_many_for_pilots_have_their_share(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cost, "_PILOTS", 2)
    text = "presets: [timed, hierarchical_2, hierarchical_3]\ntrials: 1000\n"
    assert plan(parse(text, "mine.yaml"), 2).steps == pytest.approx(steps_made(text), rel=0.5)


def test_a_pilot_that_does_not_come_to_its_end_goes_on_as_it_did_of_late(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cost, "_PILOT_STEPS", 250_000)
    text = "presets: [hierarchical_2]\nseeds: 3\n"
    assert plan(parse(text, "mine.yaml"), 2).steps == pytest.approx(steps_made(text), rel=0.35)


def test_pilots_end_before_a_first_trial_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "_PILOT_STEPS", 0)
    found = plan(parse("presets: [timed]\ntrials: 100", "mine.yaml"), 2)
    assert found.steps > 0
    assert math.isfinite(found.seconds)


def test_the_longest_run_is_that_of_the_slowest_learner_or_of_the_steps_there_are() -> None:
    text = "presets: [hierarchical_2, hierarchical_3]\ntrials: 2000\n"
    longest = longest_run(parse(text, "mine.yaml"))
    assert longest < plan(parse(text, "mine.yaml"), 2).steps < 2 * longest
    assert longest_run(parse(f"{text}steps: 1000\n", "mine.yaml")) == 1000


def test_an_experiment_with_a_stop_takes_less_than_is_said() -> None:
    found = plan(parse(STOP, "mine.yaml"), 2)
    assert found.at_most
    assert steps_made(STOP) < found.steps
    assert not plan(parse(EARLY, "mine.yaml"), 2).at_most


# --- Time ----------------------------------------------------------------------------------------


def test_the_time_is_that_of_all_presets_however_fast_one_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def measured(runs: Sequence[cost._Course]) -> list[cost._Pace]:
        return [cost._Pace(20.0, 3e-3 if spec.learner.skills else 1e-3) for spec, *_ in runs]

    monkeypatch.setattr(cost, "_measured", measured)
    found = plan(parse("presets: [timed, standard_q]\nsteps: 1000\nseeds: 5", "my.yaml"), 1)
    assert found.steps == 10_000
    assert found.seconds == pytest.approx(20, rel=0.01)


def plan_of(seconds: Sequence[float], seeds: int, workers: int) -> float:
    """When runs of variants that take so long are over."""
    return cost._finished_after([(each, seeds) for each in seconds], workers)


def test_the_last_runs_are_waited_for() -> None:
    assert plan_of([10.0], 4, 1) == 40
    assert plan_of([10.0], 4, 2) == 20
    assert plan_of([10.0], 4, 3) == 20
    assert plan_of([1.0, 9.0], 2, 2) == 18 + 1 - 8
    assert plan_of([], 0, 1) == 0


def test_who_is_given_half_of_a_core_takes_twice_as_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "_measured", lambda runs: [cost._Pace(20.0, 1e-3) for _ in runs])
    experiment = parse("presets: [timed]\nsteps: 1000\nseeds: 4", "my.yaml")
    whole = plan(experiment, 2).seconds
    monkeypatch.setattr(cost, "_cores_for", lambda _, n_threads, __: 0.5 * n_threads)
    assert plan(experiment, 2).seconds == pytest.approx(2 * whole)


def test_what_threads_are_given_is_found_out_anew_when_something_else_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.undo()
    now, tried = [0.0], list[int]()
    monkeypatch.setattr(cost, "_given", {})
    monkeypatch.setattr(cost, "_tried", lambda _, n_threads: tried.append(n_threads) or 1.0)
    monkeypatch.setattr(cost, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(cost, "available_cores", lambda: 2)
    (variant,) = parse("presets: [timed]\n", "my.yaml").variants
    for at, n_threads, beside in (
        (0, 1, "a"),
        (9, 1, "a"),
        (9, 1, "b"),
        (70, 1, "b"),
        (70, 9, "b"),
    ):
        now[0] = at
        assert cost._cores_for(variant.spec, n_threads, beside) == 1.0
    assert tried == [1, 1, 1, 4]


def test_threads_that_work_are_given_something() -> None:
    (variant,) = parse("presets: [timed]\ntrials: 10\n", "my.yaml").variants
    assert 0 < cost._tried(variant.spec, 2) <= 2


def times(monkeypatch: pytest.MonkeyPatch, *looks: float) -> float:
    """Seconds of a step of a pilot whose moments took so long, each with 50,000 steps."""
    ends = (sum(looks[: n // 2 + n % 2]) for n in count())
    monkeypatch.setattr(cost, "time", SimpleNamespace(thread_time=ends.__next__))
    (variant,) = parse("presets: [timed]\n", "my.yaml").variants
    pilot = cost._Pilot(cost._Course(variant.spec, variant.spec.trials, None))
    for took in looks:
        assert pilot.advance() == pytest.approx(took)
    return pilot.pace().seconds * 50_000


def test_a_moment_in_which_a_pilot_was_held_up_does_not_count(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert times(monkeypatch, 2.0, 2.0, 30.0, 2.1, 2.0) == pytest.approx(2.0)


def test_a_clock_that_stands_for_a_moment_still_gives_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert times(monkeypatch, 2.0, 0.0, 2.0) == pytest.approx(2.0)


def test_a_machine_that_is_busy_gets_a_rougher_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[int] = []
    advance = cost._Pilot.advance

    def late(pilot: cost._Pilot) -> float:
        took = advance(pilot)
        steps.append(pilot.steps)
        time.sleep(0.01)
        return took

    monkeypatch.setattr(cost._Pilot, "advance", late)
    monkeypatch.setattr(cost, "_BUSY_S", 0.05)
    experiment = parse("presets: [timed]\n", "my.yaml")
    assert plan(experiment, 1).steps > max(steps)
    assert len(steps) < 10


def pilots_of(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Gains the epsilon of each preset of which a pilot is run."""
    found: list[float] = []

    def piloted(runs: Sequence[cost._Course]) -> list[cost._Pace]:
        found.extend(spec.learner.epsilon for spec, *_ in runs)
        return [cost._Pace(100.0, 1e-6) for _ in runs]

    monkeypatch.setattr(cost, "_piloted", piloted)
    return found


def plan_with_epsilon(epsilon: float) -> None:
    text = f"presets: [timed]\nset: {{learner.epsilon: {epsilon}}}\nsteps: 50\n"
    assert math.isfinite(plan(parse(text, "my.yaml"), 1).seconds)


def test_what_was_measured_is_good_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    now, found = [0.0], pilots_of(monkeypatch)
    monkeypatch.setattr(cost, "time", SimpleNamespace(monotonic=lambda: now[0]))
    for seconds, n_pilots in ((0, 1), (300, 1), (3_000, 2)):
        now[0] = seconds
        plan_with_epsilon(0.1)
        assert len(found) == n_pilots


def test_pilots_of_many_presets_are_not_kept_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    pilots_of(monkeypatch)
    for number in range(200):
        plan_with_epsilon(number / 1000)
    assert len(cost._known) < 100


def test_a_run_that_is_a_little_longer_is_not_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    found = pilots_of(monkeypatch)
    steps = [
        plan(parse(f"presets: [timed]\n{more}", "my.yaml"), 1).steps
        for more in ("", "trials: 48100\n", "set: {description: mine}\n", "seeds: 7\n")
    ]
    assert len(found) == 1
    assert steps == [4_800_000, 4_810_000, 4_800_000, 33_600_000]
    for more in ("trials: 80000\n", "set: {schedule.skills.avoid.at: 31000}\n"):
        plan(parse(f"presets: [timed]\n{more}", "my.yaml"), 1)
    assert len(found) == 3


def test_what_was_measured_again_is_not_the_oldest_any_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now, found = [0.0], pilots_of(monkeypatch)
    monkeypatch.setattr(cost, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(cost, "_MOST_KEPT", 3)
    plan_with_epsilon(0.1)
    now[0] = cost._KEPT_S
    plan_with_epsilon(0.2)
    now[0] += 1.0
    plan_with_epsilon(0.1)
    plan_with_epsilon(0.3)
    plan_with_epsilon(0.4)
    assert found == [0.1, 0.2, 0.1, 0.3, 0.4]
    plan_with_epsilon(0.1)
    assert found[5:] == [], "it was put out in place of the oldest"


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
