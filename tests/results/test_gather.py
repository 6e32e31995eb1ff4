"""What runs come to that are over one after another."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.experiments.archive import packed
from app.experiments.record import origin_of
from app.metrics import NAMES, reward_at
from app.results.gather import Gatherer
from learners import measures
from tests.support.folders import greedy_curve, no_facts
from tests.support.runs import experiment_of, fact


def _archive(outcome: np.ndarray, steps: np.ndarray) -> bytes:
    nothing = np.zeros((0, 18, 24), np.float32)
    return packed(
        {
            "outcome": outcome,
            "steps": steps,
            "introductions": np.zeros((0, 2), np.int64),
            "introduced": np.zeros(0, "<U1"),
            "moments": np.zeros(0, np.int64),
            "value_share": nothing,
            "value_distance": nothing,
            **greedy_curve(),
            **no_facts(),
        }
    )


@pytest.mark.parametrize("lengths", [(1_000, 400), (400, 1_000), (1_000, 700, 150)])
def test_runs_have_values_where_the_shortest_so_far_got_to(lengths: tuple[int, ...]) -> None:
    experiment = experiment_of("presets: [timed]\nseeds: 3")
    world = experiment.variants[0].spec.world
    draw = np.random.default_rng(1)
    gatherer = Gatherer(experiment, 1_000_000)
    logs = []
    for seed, per_trial in enumerate(lengths):
        outcome = draw.integers(1, 4, 400).astype(np.int8)
        steps = np.full(400, per_trial)
        logs.append((measures.rewards(world, outcome), steps))
        _, run = fact(0, seed, 1.0, trials=400, steps=400 * per_trial)
        origin = origin_of(experiment, Path())._replace(metrics=NAMES)
        gatherer.add(
            replace(run, variant=experiment.variants[0].label, origin=origin),
            _archive(outcome, steps),
        )
    gathering = gatherer.gathering()
    shortest = min(lengths) * 400 // 100_000 * 100_000 or min(lengths) * 400
    assert gathering.horizon is not None
    assert gathering.horizon.steps == shortest
    assert [run.values["horizon_reward"] for _, run in gathering.runs] == pytest.approx(
        [reward_at(*log, shortest) for log in logs]
    )
