"""All learners that are shipped, and settings that no preset has, keep to one contract."""

from typing import Any

import pytest

from app.documents import presets
from learners.spec import RunSpec
from tests.support.contract import LearnerContract, small

VARIANTS: dict[str, tuple[str, list[str]]] = {
    "q_lambda whose traces never fade": ("q_lambda", ["learner.trace_decay=1"]),
    "feudal, regions that do not come out even": ("feudal", ["learner.region=4"]),
    "feudal, finer eyes of those that obey": (
        "feudal",
        ["world.skill_n_directions=24", "world.skill_n_distances=18"],
    ),
    "moves kept for 3 steps": ("standard_q", ["learner.held={until: steps, most: 3}"]),
    "skills kept until the state changes, discounted by steps": (
        "timed",
        ["learner.held={until: change, most: 5}"],
    ),
    "applicable skills alone": ("hierarchical_3", ["learner.applicable=0.6"]),
    "applicable skills alone, kept": (
        "timed",
        ["learner.applicable=0.9", "learner.held={until: change}"],
    ),
    "each skill alone first": ("timed", ["schedule.pretrain=100000"]),
    "each skill alone first, then taught, and choices kept": (
        "hierarchical_3_taught",
        [
            "schedule.pretrain=50000",
            "learner.held={until: change}",
            "learner.skills_that_learn=all",
        ],
    ),
    **{
        f"appetite and fear by {rule}": ("static_appetite_fear", [f"learner.selection={rule}"])
        for rule in ("best_happiness", "worst_unhappiness", "negotiated_unhappiness", "w_learning")
    },
    "a rule, by what was reached": ("timed_auto", ["schedule.introduce.by=reach"]),
}


class TestShipped(LearnerContract):
    """Of each preset."""

    @pytest.fixture(params=presets.shipped())
    def spec(self, request: pytest.FixtureRequest) -> RunSpec:
        """The preset, small."""
        return small(presets.load(request.param))


class TestVariants(LearnerContract):
    """Of some settings more."""

    @pytest.fixture(params=VARIANTS)
    def spec(self, request: pytest.FixtureRequest) -> RunSpec:
        """The preset with these settings, small."""
        name: Any = request.param
        preset, settings = VARIANTS[name]
        return small(presets.load(preset, settings))
