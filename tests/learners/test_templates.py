"""Perceptual templates: what tables begin with, against the same worked out state by state."""

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from learners.kernel.state import digest, tables
from learners.run import Run
from learners.spec import RunSpec
from tests.support.reference import MOVES, SlowWorld

SLOW = SlowWorld(size=40, n_directions=16, n_distances=6)
TURNED = {"outwards": 0, "counterclockwise": 90, "inwards": 180, "clockwise": 270}


def spec_of(templates: list[dict[str, Any]], **learner: Any) -> RunSpec:
    """A preset in a small world with these templates."""
    stated: dict[str, Any] = {"options": "moves", "alpha": 0.5}
    world = {"size": 40, "n_directions": 16, "n_distances": 6}
    learner = stated | learner | {"templates": templates}
    return RunSpec.model_validate({"world": world, "learner": learner, "trials": 400})


def middles() -> dict[tuple[int, int], float]:
    """Mean distance of the cells of each reading, as on a grid of 120."""
    cells: dict[tuple[int, int], list[float]] = {}
    for x in range(40):
        for y in range(40):
            cells.setdefault(SLOW.reading((x, y)), []).append(SLOW.distance((x, y)))
    return {reading: 3 * sum(found) / len(found) for reading, found in cells.items()}


def worth(direction: int, move: int, prefer: str, value: float) -> float:
    """What a template lets a move be worth where it holds."""
    dx, dy = MOVES[move]
    if (dx, dy) == (0, 0):
        return 0.0
    way = math.radians(direction * 360 / 16 + TURNED[prefer])
    cosine = math.cos(math.atan2(dy, dx) - way)
    return value * cosine if cosine > 1e-9 else 0.0


def bearing(heading: int, direction: int) -> float:
    """Degrees from where the prey looks, to either side."""
    return abs(math.remainder(direction * 360 / 16 - heading * 45, 360))


@pytest.mark.parametrize("prefer", TURNED)
def test_a_table_of_moves_begins_with_the_share_of_each_move_in_the_way(prefer: str) -> None:
    template = {
        "table": "selection",
        "prefer": prefer,
        "bearing": [90, 180],
        "distance": [10, 50],
        "value": 8,
    }
    run = Run(spec_of([template]), 1)
    found = tables(run.spec, run.state)
    held = 0
    for (ring, direction), distance in middles().items():
        for heading in range(8):
            holds = 10 <= distance <= 50 and bearing(heading, direction) >= 90
            held += holds
            expected = [worth(direction, move, prefer, 8) if holds else 0 for move in range(9)]
            at = heading, ring, direction
            np.testing.assert_allclose(found["selection_q"][at], expected, atol=1e-5)
            assert found["first_reach"][at] == (0 if holds else -1)
    assert 100 < held < 500


def test_a_skill_begins_with_its_template_and_the_last_one_counts() -> None:
    ways = [
        {"table": "approach", "prefer": "inwards", "value": 3},
        {"table": "approach", "prefer": "outwards", "distance": [0, 20], "value": 2},
    ]
    run = Run(spec_of(ways, options=["avoid", "approach"]), 1)
    skill_q = tables(run.spec, run.state)["skill_q"]
    assert not skill_q[0].any()
    for (ring, direction), distance in middles().items():
        for move in range(9):
            expected = worth(direction, move, "inwards", 3)
            if distance <= 20:
                expected = worth(direction, move, "outwards", 2) or expected
            assert skill_q[1, ring, direction, move] == pytest.approx(expected, abs=1e-5)


def test_a_skill_is_worth_to_the_selection_what_a_template_says_where_it_joins() -> None:
    templates = [
        {"table": "selection", "prefer": "approach", "bearing": [120, 180], "value": 4},
        {"table": "selection", "prefer": "avoid", "bearing": [0, 60], "value": 2},
    ]
    run = Run(spec_of(templates, options=["approach", "avoid"], alpha=0.1), 1)
    selection = tables(run.spec, run.state)["selection_q"]
    for heading in range(8):
        for direction in range(16):
            away = bearing(heading, direction)
            assert (selection[heading, :, direction, 0] == (4 if away >= 120 else 0)).all()
            # It joins safely: nothing else of it is above what there was.
            assert (selection[heading, :, direction, 1] == (2 if away <= 60 else 0)).all()


def test_no_template_changes_nothing_and_one_is_learned_on() -> None:
    plain, empty = Run(spec_of([]), 3), Run(spec_of([]), 3)
    template = {"table": "selection", "prefer": "inwards", "value": 5}
    seeded = Run(spec_of([template]), 3)
    before = tables(seeded.spec, seeded.state)["selection_q"]
    for run in (plain, empty, seeded):
        run.advance(max_steps=20_000)
    assert digest(plain.state) == digest(empty.state) != digest(seeded.state)
    assert (tables(seeded.spec, seeded.state)["selection_q"] != before).mean() > 0.1
    ended = seeded.state.log_outcome[: seeded.trial]
    assert (ended == 1).sum() > 2 * (plain.state.log_outcome[: plain.trial] == 1).sum()


@pytest.mark.parametrize(
    ("template", "learner", "key", "says"),
    [
        ({"table": "avoid"}, {}, "table", "is no table of this learner; allowed: selection"),
        ({"prefer": "approach"}, {}, "prefer", "allowed: inwards, outwards, clockwise"),
        ({}, {"options": ["approach"]}, "prefer", "allowed: approach"),
        ({}, {"options": "commands"}, "table", "the options are commands; allowed: none"),
        (
            {"table": "approach", "bearing": [0, 90]},
            {"options": ["approach"]},
            "bearing",
            "is not known to approach, which does not see where the prey looks; allowed: none",
        ),
        (
            {"prefer": "fear"},
            {"options": ["fear"], "selection": "collective", "skills_that_learn": "all"},
            "table",
            "is not learned, but by collective; allowed: a skill",
        ),
        ({"bearing": [90, 60]}, {}, "bearing", "from less to more; allowed: [from, to], 0 to 180"),
        ({"distance": [0, 121]}, {}, "distance", "allowed: [from, to], 0 to 120"),
    ],
)
def test_a_template_that_cannot_be_is_refused_with_the_reason(
    template: dict[str, Any], learner: dict[str, Any], key: str, says: str
) -> None:
    sound = {"table": "selection", "prefer": "inwards", "value": 1}
    with pytest.raises(ValidationError) as refused:
        spec_of([sound | template], **learner)
    problems = [
        problem
        for error in refused.value.errors()
        for problem in error.get("ctx", {})["error"].problems
    ]
    assert any(problem.key[-1] == key and says in problem.message for problem in problems), problems
