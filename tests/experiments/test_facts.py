"""Facts of a run that its log does not say: when they are found, and what they are."""

from pathlib import Path

import numpy as np
import pytest

from app.documents import experiments
from app.experiments import archive, facts, store
from app.experiments.crews import Threads
from app.experiments.facts import Facts
from app.experiments.probes import Agenda
from app.experiments.runner import run_experiment
from app.experiments.task import Limits, made_run
from app.results import read
from learners import behaviour
from learners.kernel.state import digest
from learners.run import Run
from learners.spec import RunSpec
from sim.world import CAPTURE, FLIGHT

WORLD = {"size": 80, "n_directions": 8, "n_distances": 4, "step_limit": 60}
THREE = ["approach", "circle_clockwise", "avoid"]
JOINS = {"circle_clockwise": {"at": 6_400}, "avoid": {"at": 6_800}}
EPISODES = [
    {"skill": "circle_clockwise", "duration": 300, "probability": 0.9},
    {"skill": "avoid", "duration": 400, "probability": 0.9},
]


def timed(trials: int = 7_500) -> RunSpec:
    return RunSpec.model_validate(
        {
            "world": WORLD,
            "learner": {"options": THREE, "alpha": 0.1},
            "schedule": {"skills": JOINS, "episodes": EPISODES},
            "trials": trials,
        }
    )


def found_in(spec: RunSpec, steps: int | None = None) -> tuple[Run, dict[str, float]]:
    """A run until its trials or steps are over, and its facts."""
    found = Facts()
    run = made_run(spec, 7, Limits(spec.trials, steps), found.probes(spec, spec.trials))
    assert run is not None
    return run, found.found


def test_they_leave_no_mark_on_the_run() -> None:
    run, found = found_in(timed())
    unseen = made_run(timed(), 7, Limits(7_500))
    assert found
    assert unseen is not None
    assert digest(run.state) == digest(unseen.state)


def test_they_are_those_of_the_moments_that_are_in_their_names() -> None:
    spec = timed()
    _, found = found_in(spec)
    again = Run(spec, 7)
    again.advance(max_steps=50_000)
    assert found[facts.progress("approach", 50_000)] == behaviour.progress(again, "approach")
    again.advance(max_steps=50_000)
    assert again.trial < 6_400
    assert found[facts.STAYED] == behaviour.travel(again).stayed
    gained = behaviour.trials(again, 0, again.trial).gained
    assert found[facts.GAINED] == pytest.approx(gained.sum() / again.state.log_steps.sum())
    again.advance(until_trial=7_200)
    far_off = behaviour.travel(again).distance
    assert found[facts.distance("avoid")] == pytest.approx(far_off.mean())
    assert found[facts.far("avoid")] == np.mean(far_off > 40)
    assert facts.distance("circle_clockwise") in found
    again.advance(until_trial=7_500)
    first_reach = again.state.first_reach
    early = np.sum((first_reach >= 0) & (first_reach < 4_000))
    assert found[facts.VALUED_A_TRIAL] == early / 4_000
    before_circle = np.sum((first_reach >= 0) & (first_reach < 6_400))
    assert found[facts.VALUED_EARLY] == early / before_circle


def test_endings_are_those_of_the_last_trials_of_the_preset() -> None:
    run, found = found_in(timed())
    outcome = run.state.log_outcome[5_500:7_500]
    seen = behaviour.trials(run, 5_500, 7_500).seen
    assert found[facts.LOST_TO_FLIGHT] == np.mean(outcome[outcome != CAPTURE] == FLIGHT)
    assert found[facts.SEEN_FLEE] == np.mean(outcome[seen] == FLIGHT)
    assert found[facts.FLIGHTS_SEEN] == np.mean(seen[outcome == FLIGHT])
    assert found[facts.FLIGHTS_SEEN] + found[facts.FLIGHTS_UNSEEN] == pytest.approx(1)


def test_a_longer_run_has_the_same_ones() -> None:
    spec = timed()
    short, long = Facts(), Facts()
    made_run(spec, 7, Limits(7_500), short.probes(spec, 7_500))
    made_run(spec, 7, Limits(7_500, horizon=600_000), long.probes(spec, 7_500))
    assert short.found.items() <= long.found.items()


def test_moments_that_a_run_does_not_come_to_leave_none() -> None:
    run, found = found_in(timed(), steps=60_000)
    assert run.trial < 4_000
    assert set(found) == {facts.progress("approach", 50_000)}


def test_a_learner_without_skills_has_fewer() -> None:
    spec = RunSpec.model_validate(
        {"world": WORLD, "learner": {"options": "moves", "alpha": 0.6}, "trials": 2_500}
    )
    _, found = found_in(spec)
    endings = {facts.SEEN_FLEE, facts.FLIGHTS_SEEN, facts.FLIGHTS_UNSEEN, facts.LOST_TO_FLIGHT}
    assert set(found) == {facts.GAINED, facts.STAYED, *endings}


def test_what_there_is_none_of_has_no_share() -> None:
    found, spec = Facts(), timed(2_000)
    run = Run(spec, 7)
    agenda = Agenda(found.probes(spec, 2_000))
    run.advance(until_trial=2_000)
    run.state.log_outcome[:] = CAPTURE
    agenda.look(run)
    assert facts.SEEN_FLEE in found.found
    assert facts.LOST_TO_FLIGHT not in found.found
    assert facts.FLIGHTS_SEEN not in found.found


# --- On disk -------------------------------------------------------------------------------------


def test_they_are_kept_and_read_back(tmp_path: Path) -> None:
    text = """
        presets: [hierarchical_2]
        settings: [{label: small, world.size: 20, world.step_limit: 60}]
        trials: 1500
        seeds: 1
    """
    experiment = experiments.parse(text, "some.yaml")
    with store.Folder(tmp_path / "results", experiment, resume=False, force=False) as folder:
        run_experiment(experiment, folder, Threads(1))
    (run,) = read.read_folder(tmp_path / "results").rows
    spec = experiment.variants[0].spec
    made = Facts()
    made_run(spec, run.seed, Limits(1_500), made.probes(spec, 1_500))
    assert read.read_log(run).facts == made.found


@pytest.mark.parametrize(
    ("names", "values", "why"),
    [
        (["some"], [], "shorter"),
        (["some"], [np.nan], "no number"),
        ([], [], None),
    ],
)
def test_damaged_ones_are_an_error(names: list[str], values: list[float], why: str | None) -> None:
    arrays = {
        "outcome": np.zeros(0, np.int8),
        "steps": np.zeros(0, np.int32),
        "introductions": np.zeros((0, 2), np.int64),
        "introduced": np.zeros(0, "U32"),
        "moments": np.zeros(0, np.int64),
        "value_share": np.zeros((0, 4, 8), np.float32),
        "value_distance": np.zeros((0, 4, 8), np.float32),
        "greedy_trial": np.zeros(0, np.int64),
        "greedy_step": np.zeros(0, np.int64),
        "greedy_reward": np.zeros(0, np.float32),
        "probe_names": np.array(names, "U64"),
        "probe_values": np.array(values, np.float64),
    }
    packed = archive.packed(arrays)
    if why is None:
        assert archive.unpacked(packed, 0, 0).facts == {}
    else:
        with pytest.raises(archive.ArchiveError, match=why):
            archive.unpacked(packed, 0, 0)
