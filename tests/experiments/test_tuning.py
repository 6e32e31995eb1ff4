"""Weights that are tuned in one at a time: the search, its presets, and the runs behind it."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import pytest

from app.analysis import estimates
from app.documents import presets
from app.experiments import tuning
from app.experiments.crews import Threads
from app.experiments.seeds import SeedFailedError
from app.experiments.tuning import AREA, GRID, Plan, TuningError, Weights
from app.metrics import area_at
from learners import measures
from learners.run import Run
from learners.spec import RunSpec

SKILLS = ("one", "two", "three")
PLAN = Plan((0.0, 0.5, 2.0), (5, 3), (9, 8, 7), 6_000)
TIMED = """
learner:
  options: [appetite, fear, approach]
  selection: collective
  skills_that_learn: all
  alpha: 0.1
  weights: {fear: 3}
  templates:
    - {table: appetite, prefer: inwards, value: 2}
    - {table: fear, prefer: outwards, value: 1}
schedule:
  skills: {fear: {at: 5}, approach: {at: 9}}
  episodes:
    - {skill: fear, duration: 3, probability: 0.5}
trials: 20
"""


@pytest.fixture(scope="module")
def spec() -> RunSpec:
    return presets.load("static_appetite_fear", ("world.size=20", "world.step_limit=60"))


class Landscape:
    """Rewards of sets of weights by a formula, and which sets were asked for."""

    def __init__(self, best: Mapping[str, float]) -> None:
        self.best = best
        self.asked: list[Weights] = []

    def __call__(self, sets: Sequence[Weights]) -> list[Mapping[int, float]]:
        self.asked += sets
        return [{0: self.reward_of(weights), 1: self.reward_of(weights) + 1} for weights in sets]

    def reward_of(self, weights: Weights) -> float:
        return -sum(abs(weight - self.best[skill]) for skill, weight in weights.items())


def reward_by_hand(spec: RunSpec, seed: int, horizon: int) -> float:
    run = Run(spec, seed)
    run.advance(max_steps=horizon)
    done = measures.trials_done(run.state)
    found = area_at(run.state.log_reward[:done], run.state.log_steps[:done], horizon)
    return math.nan if found is None else found


# --- The search ----------------------------------------------------------------------------------


def test_each_skill_gets_the_weight_that_is_best_beside_those_before_it() -> None:
    landscape = Landscape({"one": 1, "two": 0.25, "three": 8})
    stages = tuning.search(SKILLS, GRID, landscape)
    assert [(stage.skill, stage.weight) for stage in stages] == [
        ("one", 1),
        ("two", 0.25),
        ("three", 8),
    ]
    assert landscape.asked == [
        {"one": 1},
        *({"one": 1, "two": weight} for weight in GRID),
        *({"one": 1, "two": 0.25, "three": weight} for weight in GRID),
    ]
    assert [tried.mean for tried in stages[0].tried] == [0.5]


def test_the_grid_is_none_and_then_doubles() -> None:
    assert GRID[0] == 0
    assert [b / a for a, b in pairwise(GRID[1:])] == [2] * 8
    assert (GRID[1], GRID[-1]) == (1 / 16, 16)


@pytest.mark.parametrize(
    ("rewards", "kept"),
    [
        ({0: 1, 0.25: 7, 0.5: 7, 4: 7}, 0.5),  # the nearest to 1 by ratio
        ({0: 7, 16: 7}, 16),
        ({0.5: 7, 2: 7}, 0.5),
        ({0: -3, 1: math.nan}, 0),
    ],
)
def test_of_equal_weights_the_one_nearest_to_1_is_kept(
    rewards: dict[float, float], kept: float
) -> None:
    def rewards_of(sets: Sequence[Weights]) -> list[Mapping[int, float]]:
        return [{4: rewards[weights["two"]] if "two" in weights else 0.0} for weights in sets]

    assert tuning.search(SKILLS[:2], [*rewards], rewards_of)[-1].weight == kept


@pytest.mark.parametrize(
    ("tried", "kept", "is_at_an_end"),
    [
        ((0, 0.25, 1, 4), 4, True),
        ((0, 0.25, 1, 4), 0.25, True),
        ((0, 0.25, 1, 4), 1, False),
        ((0, 0.25, 1, 4), 0, False),
        ((1,), 1, False),
    ],
)
def test_a_weight_at_an_end_of_the_grid_is_told(
    tried: Sequence[float], kept: float, is_at_an_end: bool
) -> None:
    stage = tuning.Stage("two", [tuning.Tried(weight, {}) for weight in tried], kept)
    assert stage.is_at_an_end == is_at_an_end


def test_seeds_without_a_reward_do_not_count_unless_there_is_no_other() -> None:
    assert tuning.Tried(1, {0: math.nan, 1: 4.0, 2: 6.0}).mean == 5
    with pytest.raises(TuningError, match="ends no trial within the horizon"):
        tuning.search(SKILLS, GRID, lambda sets: [{0: math.nan} for _ in sets])


# --- Presets -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("standard_q", (), "has no skills to be weighed: its options are moves"),
        ("feudal", (), "has no skills to be weighed: its options are commands"),
        ("timed", (), "learns its selection, which has no weights"),
        ("static_appetite_fear", ("learner.options=[fear]",), "has only fear to be weighed"),
        (
            "static_appetite_fear",
            ("schedule.skills.appetite.at=300",),
            "begins without appetite, the skill that is let in first, which joins in trial 300",
        ),
    ],
)
def test_presets_without_weights_to_be_tuned_are_refused(
    name: str, settings: Sequence[str], message: str
) -> None:
    with pytest.raises(TuningError, match=message):
        tuning.check(presets.load(name, settings))


def test_what_is_said_of_skills_that_are_not_in_yet_is_left_out() -> None:
    spec = presets.parse(TIMED, "timed.yaml")
    alone = tuning.with_weights(spec, {"appetite": 1.0})
    assert alone.learner.skills == ("appetite",)
    assert (alone.schedule.skills, alone.schedule.episodes) == ({}, ())
    assert [template.table for template in alone.learner.templates] == ["appetite"]
    both = tuning.with_weights(spec, {"appetite": 1.0, "fear": 0.5})
    assert both.learner.weights == {"appetite": 1.0, "fear": 0.5}
    assert [*both.schedule.skills] == ["fear"]
    assert [episode.skill for episode in both.schedule.episodes] == ["fear"]
    weights = {"appetite": 1.0, "fear": 3.0, "approach": 1.0}
    everything = tuning.with_weights(spec, weights)
    assert everything.schedule == spec.schedule
    assert everything.learner == spec.learner.model_copy(update={"weights": weights})
    assert tuning.n_runs(spec, PLAN) == (1 + 3 + 3) * 2 + 2 * 3


# --- The runs ------------------------------------------------------------------------------------


def test_rewards_are_those_of_runs_up_to_the_horizon(spec: RunSpec) -> None:
    tuned = tuning.tune(spec, PLAN, lambda: Threads(1))
    kept: dict[str, float] = {}
    for stage in tuned.stages:
        for tried in stage.tried:
            weighed = tuning.with_weights(spec, kept | {stage.skill: tried.weight})
            by_hand = {seed: reward_by_hand(weighed, seed, PLAN.horizon) for seed in PLAN.seeds}
            assert tried.rewards == by_hand
        kept[stage.skill] = stage.weight
    assert tuned.weights == kept
    assert tuned.spec == tuning.with_weights(spec, kept)
    judged = tuned.judged[AREA]
    for key, weights in (("tuned", kept), ("ones", dict.fromkeys(kept, 1.0))):
        weighed = tuning.with_weights(spec, weights)
        values = [reward_by_hand(weighed, seed, PLAN.horizon) for seed in PLAN.judge_seeds]
        assert judged[key] == estimates.mean(values, estimates.bootstrap_rng())
    assert judged["difference"].value == pytest.approx(judged["tuned"].value - judged["ones"].value)
    assert judged["difference"].n == len(PLAN.judge_seeds)


def test_workers_and_weights_of_the_preset_make_no_difference(spec: RunSpec) -> None:
    shares: list[float] = []
    alone = tuning.tune(spec, PLAN, lambda: Threads(1), lambda done, _: shares.append(done))
    weighed = tuning.with_weights(spec, {"appetite": 7.0, "fear": 0.0})
    together = tuning.tune(weighed, PLAN, lambda: Threads(3))
    assert (together.stages, together.judged) == (alone.stages, alone.judged)
    assert shares == sorted(shares)
    assert shares[-1] == tuning.n_runs(spec, PLAN)


def test_a_run_that_fails_ends_it(spec: RunSpec, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise MemoryError("no room")

    monkeypatch.setattr("app.experiments.task.made_run", fail)
    with pytest.raises(SeedFailedError, match=r"the run of seed \d failed: MemoryError: no room"):
        tuning.tune(spec, PLAN, lambda: Threads(1))
