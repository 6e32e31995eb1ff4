"""Q(λ) and feudal Q do exactly what their definitions say, step by step and bit for bit."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from learners.commands import CommandError, DefineSkill, Introduce
from learners.comparators.feudal import Commanded, commanded
from learners.comparators.q_lambda import eligibility
from learners.kernel.state import CELL, HEADING, OPTION, TRIAL_STEP, tables
from learners.run import Run
from learners.skill_spec import SkillWeights
from learners.spec import RunSpec
from sim.world import board_xy
from tests.support.reference import SlowSettings, SlowWorld, Step
from tests.support.reference_comparators import (
    COMMANDS,
    SlowComparator,
    SlowFeudal,
    SlowWatkins,
)
from tests.support.stepwise import (
    BLURRED,
    CLOSE,
    ODD,
    OUTCOMES,
    SMALL,
    STANDARD,
    last_cell,
    spec_of,
)

# A state for nearly each cell, and a prey that sees nothing.
LONG = SlowWorld(size=40, n_directions=48, n_distances=32, step_limit=6_000, vision_radius=0)


@dataclass(frozen=True)
class Case:
    """A run to compare, and what must have happened in it for the comparison to mean much."""

    settings: SlowSettings
    learner: Mapping[str, Any]
    """What the preset says besides: trace_decay, or region."""
    steps: int = 6_000
    seed: int = 1
    must_see: Mapping[str, int] = field(default_factory=dict[str, int])

    @property
    def spec(self) -> RunSpec:
        """The run as a preset would state it."""
        document = spec_of(self.settings).model_dump()
        options = "moves" if "trace_decay" in self.learner else "commands"
        document["learner"] |= {"options": options, **self.learner}
        return RunSpec.model_validate(document)

    def slow(self) -> SlowWatkins | SlowFeudal:
        """The same run, slowly."""
        if "trace_decay" in self.learner:
            return SlowWatkins(self.settings, self.learner["trace_decay"], self.seed)
        return SlowFeudal(self.settings, self.learner["region"], self.seed)


_TRACED = {"learned through a trace": 500, "cut by exploring": 40, "made again": 50}
_COMMANDED = {"held for several steps": 300, "crossed as commanded": 300}
CASES = {
    "traces, small world": Case(
        SlowSettings(SMALL, alpha=0.6),
        {"trace_decay": 0.5},
        12_000,
        must_see={**_TRACED, "too small": 300},
    ),
    "traces, standard world": Case(SlowSettings(STANDARD), {"trace_decay": 0.5}, 4_000, 2),
    "traces, close to the prey": Case(
        SlowSettings(CLOSE, alpha=0.6),
        {"trace_decay": 0.9},
        seed=3,
        must_see={**_TRACED, "capture": 50, "flight": 50},
    ),
    "traces that never fade": Case(
        SlowSettings(ODD, alpha=0.3, gamma=0.99, epsilon=0.02),
        {"trace_decay": 1.0},
        seed=4,
        must_see={"learned through a trace": 3_000},
    ),
    "more traces than are remembered": Case(
        SlowSettings(LONG, gamma=0.9999, epsilon=0.0, initial_q=1.0),
        {"trace_decay": 1.0},
        steps=4_000,
        seed=5,
        must_see={"forgot the oldest": 100},
    ),
    "no traces": Case(SlowSettings(SMALL, alpha=0.6), {"trace_decay": 0.0}, seed=6),
    "commands, small world": Case(
        SlowSettings(SMALL, alpha=0.2, skill_alpha=0.05),
        {"region": 3},
        seed=7,
        must_see={**_COMMANDED, "flight": 50, "timeout": 20},
    ),
    "commands, standard world": Case(
        SlowSettings(STANDARD, alpha=0.2, skill_alpha=0.05),
        {"region": 3},
        seed=8,
        must_see={"given up after 50 steps": 5, "crossed as commanded": 100},
    ),
    "commands, close to the prey": Case(
        SlowSettings(CLOSE, alpha=0.5, skill_alpha=0.6, epsilon=0.2),
        {"region": 2},
        seed=9,
        must_see={**_COMMANDED, "capture": 50, "two crossings at once": 50},
    ),
    "regions that do not come out even": Case(
        SlowSettings(ODD, alpha=0.3, skill_alpha=0.2, gamma=0.8, initial_q=0.5),
        {"region": 3},
        seed=10,
        must_see=_COMMANDED,
    ),
    "each state a region": Case(
        SlowSettings(ODD, alpha=0.2, skill_alpha=0.3), {"region": 1}, seed=11
    ),
    "one region": Case(
        SlowSettings(CLOSE, alpha=0.2, skill_alpha=0.3),
        {"region": 24},
        seed=12,
        must_see={"held for several steps": 50},
    ),
    "what obeys sees finer": Case(
        SlowSettings(BLURRED, alpha=0.2, skill_alpha=0.1), {"region": 2}, seed=13
    ),
}


def spread(
    slow: SlowComparator, values: Mapping[Any, Any], n: int, dtype: type, none: float
) -> NDArray[Any]:
    """``(heading, distance, direction, n)`` of what is known by main state and number."""
    shape = (8, slow.world.n_distances, slow.world.n_directions, n)
    found = cast("NDArray[Any]", np.full(shape, none, dtype))
    for (state, number), value in values.items():
        found[*state, number] = value
    return found


def selection_of(slow: SlowWatkins | SlowFeudal) -> np.ndarray:
    if isinstance(slow, SlowWatkins):
        rows = slow.q
    else:
        rows = {state: slow.manager[state[0], slow.region(state)] for state in slow.states}
    known = {(state, n): q for state, row in rows.items() for n, q in enumerate(row)}
    return spread(slow, known, len(next(iter(rows.values()))), np.float32, np.nan)


def sub_policies_of(slow: SlowFeudal) -> np.ndarray:
    """``(command, heading, distance, direction, move)``: blind ones are alike for each heading."""
    shape = (5, 8, slow.world.n_skill_rings, slow.world.n_skill_sectors, 9)
    found = np.full(shape, np.nan, np.float32)
    for number, command in enumerate(COMMANDS[:4]):
        for reading, row in slow.crossers[command].items():
            found[number, :, *reading] = row
    for (heading, *reading), row in slow.searcher.items():
        found[4, heading, *reading] = row
    return found


def assert_same_step(run: Run, slow: SlowComparator, trial: int, step: Step) -> None:
    """The last step of both was the same."""
    assert last_cell(run) == step.cell
    assert run.trial == slow.trial
    assert board_xy(run.world, run.state.place[CELL]) == slow.cell
    assert run.state.place[HEADING] == slow.heading
    if step.outcome is None:
        assert run.state.place[OPTION] == slow.previous
        assert run.state.tally[TRIAL_STEP] == slow.trial_step
    else:
        assert OUTCOMES[int(run.state.log_outcome[trial])] == step.outcome


def assert_same_tables(run: Run, slow: SlowWatkins | SlowFeudal) -> None:
    """All that was learned and noted is the same to the last bit."""
    fast, selection = tables(run.spec, run.state), selection_of(slow)
    assert fast["selection_q"].tobytes() == selection.tobytes()
    if isinstance(slow, SlowFeudal):
        assert fast["skill_q"].tobytes() == sub_policies_of(slow).tobytes()
    n_options = selection.shape[-1]
    visits = spread(slow, slow.notes.visits, n_options, np.uint32, 0)
    np.testing.assert_array_equal(fast["visits"], visits, strict=True)
    reached = {(state, 0): trial for state, trial in slow.notes.first_reach.items()}
    if slow.settings.initial_q <= 0:
        first_reach = spread(slow, reached, 1, np.int32, -1)[..., 0]
        np.testing.assert_array_equal(fast["first_reach"], first_reach, strict=True)
        arrivals = Counter(slow.notes.first_reach.values())
        reached_in = run.state.log_reached[: run.trial].tolist()
        assert reached_in == [arrivals[trial] for trial in range(run.trial)]
    logs, ended = run.state, slow.notes.ended
    assert logs.log_new_states[: run.trial].tolist() == [log.new_states for log in ended]
    assert logs.log_switches[: run.trial].tolist() == [log.switches for log in ended]
    changes = np.array([log.change for log in ended], np.float32)
    np.testing.assert_array_equal(logs.log_change[: run.trial], changes)


@pytest.mark.parametrize("name", CASES)
def test_every_step_and_every_value_is_that_of_the_reference(name: str) -> None:
    case = CASES[name]
    slow, run = case.slow(), Run(case.spec, case.seed)
    for number in range(1, case.steps + 1):
        trial = run.trial
        step = slow.step()
        assert run.advance(max_steps=1) == 1
        assert_same_step(run, slow, trial, step)
        if isinstance(slow, SlowWatkins):
            active = run.state.trace[run.state.trace > 0]
            assert active.tolist() == list(slow.traces.values())
        if number % 2_000 == 0 or number == case.steps:
            assert_same_tables(run, slow)
    for event, times in case.must_see.items():
        assert slow.notes.happened[event] >= times, (event, slow.notes.happened)


@pytest.mark.parametrize("name", ["traces, close to the prey", "commands, close to the prey"])
def test_a_longer_run_made_in_few_calls_learns_the_same(name: str) -> None:
    case = CASES[name]
    slow, run = case.slow(), Run(case.spec, case.seed)
    for _ in range(2):
        for _ in range(25_000):
            slow.step()
        run.advance(max_steps=25_000)
        assert_same_tables(run, slow)
    assert slow.notes.happened["capture"] > 500


def test_without_decaying_traces_it_is_standard_q() -> None:
    settings = SlowSettings(SMALL, alpha=0.6)
    plain = Run(spec_of(settings), 3)
    traced = Run(Case(settings, {"trace_decay": 0.0}).spec, 3)
    for run in (plain, traced):
        run.advance(max_steps=60_000)
    for name, array in plain.state._asdict().items():
        if array.size:
            np.testing.assert_array_equal(array, getattr(traced.state, name), err_msg=name)


def test_eligibility_is_that_of_the_last_moves() -> None:
    case = CASES["traces, close to the prey"]
    slow, run = case.slow(), Run(case.spec, case.seed)
    assert isinstance(slow, SlowWatkins)
    most = 0
    for _ in range(2_000):
        slow.step()
        run.advance(max_steps=1)
        found = eligibility(run.spec, run.state)
        assert found is not None
        np.testing.assert_array_equal(found, spread(slow, slow.traces, 9, np.float32, 0))
        most = max(most, len(slow.traces))
    assert most > 5
    assert eligibility(spec_of(SlowSettings(SMALL)), run.state) is None


def test_the_command_that_holds_is_known() -> None:
    case = CASES["commands, small world"]
    slow, run = case.slow(), Run(case.spec, case.seed)
    assert isinstance(slow, SlowFeudal)
    held = 0
    for _ in range(2_000):
        slow.step()
        run.advance(max_steps=1)
        found = commanded(run.state)
        if slow.held is None:
            assert found is None
        else:
            command, (ring, sector) = slow.held
            assert found == Commanded(command, ring * 8 + sector, slow.held_steps)
            held += 1
    assert held > 500
    assert commanded(Run(spec_of(SlowSettings(SMALL)), 1).state) is None


def test_a_manager_takes_no_skills() -> None:
    run = Run(CASES["commands, small world"].spec, 1)
    assert run.present == ()
    with pytest.raises(CommandError, match="none, because its options are commands"):
        run.apply(Introduce("approach", 0))
    with pytest.raises(CommandError, match="options of this learner are commands"):
        run.apply(DefineSkill("sneak", SkillWeights(approach=1.0)))
