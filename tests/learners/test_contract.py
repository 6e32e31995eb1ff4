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
