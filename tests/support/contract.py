"""What every learner keeps to, whatever it learns by: a class of tests to inherit from.

A learner of one's own inherits :class:`LearnerContract` in a test file, and gives its ``spec``.
With :func:`small` a preset is one whose whole schedule passes within some hundred short trials.
"""

from collections import Counter
from typing import Any, cast

import numpy as np
import pytest

from app.explain.cell import hunts_from, policy_of, reading_at
from app.explain.cell_html import reading_html
from app.explain.chain import chain_html, chain_of
from app.explain.sentence import said_of
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.metrics.course import greedy_by, greedy_of
from app.picture.layer import Extras, SuccessMap
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.player.moments import moment_sent
from learners import hunts, measures
from learners.checkpoints import Checkpoint, logs_of
from learners.commands import (
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    SetParameter,
    StopExploring,
)
from learners.kernel.state import (
    CELL,
    HEADING,
    NOT_REACHED,
    TRIAL_REACHED,
    TRIAL_STEP,
    digest,
    tables,
)
from learners.names import COMMANDS, MAX_TRIALS
from learners.run import Run, replay
from learners.spec import RunSpec
from sim import rng
from sim.spec import N_HEADINGS
from sim.world import CAPTURE, FLIGHT, TIMEOUT, board_xy
from tests.support.lines import stands

SEED = 11
TRIALS = 400
SOONER = 250
"""Trials of a schedule that become one here."""
N_HUNTS = 400


def small(spec: RunSpec) -> RunSpec:
    """The same learner in a small world, whose schedule is over after some hundred trials."""
    document = spec.model_dump()
    size = {"size": 30, "n_directions": 16, "n_distances": 6, "step_limit": 60}
    schedule = _sooner(document["schedule"])
    schedule["pretrain"] = document["schedule"]["pretrain"] // SOONER
    return RunSpec.model_validate(
        document | {"trials": TRIALS, "schedule": schedule, "world": document["world"] | size}
    )


def _sooner(part: Any, key: str = "") -> Any:
    """All numbers of trials in a part of a schedule, divided."""
    match part:
        case dict():
            entries = cast("dict[str, Any]", part)
            return {name: _sooner(value, name) for name, value in entries.items()}
        case list() | tuple():
            return [_sooner(item) for item in cast("list[Any]", part)]
        case int() if key in {"at", "freeze", "duration", "window", "trials"}:
            return -(-part // SOONER)
        case _:
            return part


def moment(run: Run) -> Snapshot:
    """A snapshot as the page takes it."""
    return snapshot.take(run, "some", 0)


class LearnerContract:
    """The contract; ``spec`` is a fixture, or an attribute, of what inherits it."""

    @pytest.fixture
    def run(self, spec: RunSpec) -> Run:
        """The learner after some trials, in the middle of one."""
        run = Run(spec, SEED)
        run.advance(until_trial=150)
        run.advance(max_steps=17)
        return run

    # The world and the trials

    def test_trials_start_where_those_of_any_other_learner_start(self, spec: RunSpec) -> None:
        moves = {"learner": {"options": "moves", "alpha": 0.1}, "trials": TRIALS}
        other = Run(RunSpec.model_validate({"world": spec.world.model_dump(), **moves}), SEED)
        run = Run(spec, SEED)
        for trial in range(1, 60):
            run.advance(until_trial=trial)
            stands_at = int(run.state.place[CELL]), int(run.state.place[HEADING])
            assert stands_at == run.start_of(trial) == other.start_of(trial)

    def test_trials_end_as_the_world_has_it(self, spec: RunSpec) -> None:
        run = Run(spec, SEED)
        run.advance()
        outcomes, steps = run.state.log_outcome[:TRIALS], run.state.log_steps[:TRIALS]
        ends = run.state.log_cell[:TRIALS]
        assert set(outcomes.tolist()) == {CAPTURE, FLIGHT, TIMEOUT}
        assert (ends[outcomes == CAPTURE] == run.world.prey_cell).all()
        # The steps of a pre-training are those of the first trial.
        later = slice(1, None)
        assert (steps[later] <= spec.world.step_limit).all()
        assert (steps[later][outcomes[later] == TIMEOUT] == spec.world.step_limit).all()
        for trial in np.flatnonzero(outcomes == FLIGHT).tolist():
            _, heading = run.start_of(trial)
            x, y = board_xy(run.world, int(ends[trial]))
            # On its own cell, the prey has noticed where the predator came from.
            on_prey = int(ends[trial]) == int(run.world.prey_cell)
            assert on_prey or int(run.world.cell_word[ends[trial]]) >> heading & 1, (x, y)
        np.testing.assert_array_equal(
            run.state.log_reward[:TRIALS], measures.rewards(spec.world, outcomes)
        )

    # What is noted

    def test_logs_and_tables_of_counts_agree(self, run: Run) -> None:
        state, done = run.state, run.trial
        assert state.log_steps[:done].sum() + state.tally[TRIAL_STEP] == run.step
        known = tables(run.spec, state)
        if run.spec.schedule.pretrain == 0:
            assert known["visits"].sum() == run.step
        switches = state.log_switches[:done]
        assert (switches >= 1).all()
        assert (switches <= state.log_steps[:done]).all()
        assert (state.log_change[:done] >= 0).all()
        # Of a selection that a rule makes there is no table.
        assert state.log_change[:done].any() or run.spec.learner.selection != "learned"
        first_reach = known["first_reach"]
        if run.spec.learner.initial_q <= 0:
            arrivals = np.bincount(first_reach[first_reach != NOT_REACHED], minlength=done + 1)
            np.testing.assert_array_equal(state.log_reached[:done], arrivals[:done])
            assert state.tally[TRIAL_REACHED] == arrivals[done]
            assert arrivals.any()

    def test_measures_are_of_all_trials(self, run: Run) -> None:
        assert sum(measures.endings(run.state)) == run.trial
        curve = measures.curve(run.state)
        assert np.isfinite(curve.reward).any()

    # Determinism

    @pytest.mark.parametrize("division", [1, 2, 3])
    def test_how_steps_are_divided_makes_no_difference(self, spec: RunSpec, division: int) -> None:
        whole, parts = Run(spec, SEED), Run(spec, SEED)
        whole.advance(max_steps=6_000)
        draw = np.random.default_rng(division)
        while parts.step < whole.step:
            most = whole.step - parts.step
            parts.advance(max_steps=min(int(draw.choice([1, 1, 2, 7, 61, 400])), most))
        assert stands(parts) == stands(whole)

    def test_a_run_is_a_function_of_its_seed(self, spec: RunSpec) -> None:
        digests = list[str]()
        for seed in (SEED, SEED, SEED + 1):
            run = Run(spec, seed)
            run.advance(until_trial=60)
            digests.append(digest(run.state))
        assert digests[0] == digests[1] != digests[2]

    def test_a_checkpoint_goes_on_as_the_run_did(self, spec: RunSpec) -> None:
        run, checkpoints = Run(spec, SEED), list[Checkpoint]()
        for steps in (0, 1, 33, 444, 1_111, 2_345):
            run.advance(max_steps=steps)
            checkpoints.append(run.checkpoint())
        run.advance(max_steps=500)
        for checkpoint in checkpoints:
            restored = Run.restored(checkpoint, logs_of(run.state))
            restored.advance(max_steps=run.step - restored.step)
            assert stands(restored) == stands(run)

    def test_a_copy_is_independent(self, run: Run) -> None:
        twin, before = run.copy(), stands(run)
        twin.advance(max_steps=700)
        assert stands(run) == before
        run.advance(max_steps=700)
        assert stands(run) == stands(twin)

    def test_a_journal_is_replayed_bit_for_bit(self, spec: RunSpec) -> None:
        run = Run(spec, SEED)
        for steps, command in (
            (333, SetParameter("learner.epsilon", 0.3)),
            (50, FreezeSelection(True)),
            (401, SetParameter("learner.alpha", 0.05)),
            (2, FreezeSelection(False)),
            (77, SetParameter("learner.gamma", 0.8)),
            (500, FreezeSkills(True)),
            (300, SetParameter("world.capture_reward", 40.0)),
            (20, FollowSchedule(False)),
        ):
            run.advance(max_steps=steps)
            run.apply(command)
        run.advance(max_steps=1_000)
        assert stands(replay(spec, SEED, run.journal, run.step)) == stands(run)

    def test_a_digest_takes_in_all_that_is_learned(self, run: Run) -> None:
        before, transient = digest(run.state), {"trail", "place", "change", "streams"}
        for name, array in run.state._asdict().items():
            if name in {"selection", "skills"}:
                # The first value of the first row.
                changed = run.copy()
                if array.size:
                    getattr(changed.state, name)[0] += 1.0
                    assert digest(changed.state) != before, name
            elif name in {"visits", "first_reach", "seen"}:
                changed = run.copy()
                getattr(changed.state, name)[-1] += 1
                assert digest(changed.state) != before, name
            elif name in transient or name.startswith("log_"):
                changed = run.copy()
                getattr(changed.state, name)[-1:] += array.dtype.type(1)
                assert digest(changed.state) == before, name

    def test_what_is_frozen_learns_nothing(self, run: Run) -> None:
        run.apply(FreezeSelection(True))
        run.apply(FreezeSkills(True))
        run.apply(FollowSchedule(False))
        before = tables(run.spec, run.state)
        run.advance(max_steps=500)
        after = tables(run.spec, run.state)
        for name in ("selection_q", "skill_q"):
            np.testing.assert_array_equal(before[name], after[name], err_msg=name)
        assert after["visits"].sum() > before["visits"].sum()

    # Pure greed

    def test_greedy_rewards_are_the_same_by_either_way(self, run: Run) -> None:
        of_run, seen = greedy_of(run, N_HUNTS), moment(run)
        assert greedy_by(run.world, policy_of(seen), run.spec.world, N_HUNTS) == of_run
        assert 0 <= of_run.success <= 1

    def test_hunts_are_its_own_trials_without_exploring_and_learning(self, spec: RunSpec) -> None:
        run = Run(spec, SEED)
        run.advance(until_trial=300)
        run.apply(FollowSchedule(False))
        for episode in run.control.episodes:
            run.apply(StopExploring(episode.skill))
        run.apply(SetParameter("learner.epsilon", 0.0))
        run.apply(FreezeSelection(True))
        run.apply(FreezeSkills(True))
        policy, ends = hunts.policy_of(run.spec, run.state), Counter[int]()
        for trial in range(run.trial, run.trial + 150):
            cell, heading = run.start_of(trial)
            draws = run.state.streams[rng.DECISIONS]
            hunt = hunts.hunt(run.world, policy, cell, heading, counter=draws)
            run.advance(until_trial=trial + 1)
            assert hunt.outcome == run.state.log_outcome[trial]
            assert hunt.steps == run.state.log_steps[trial]
            assert hunt.cells[-1] == run.state.log_cell[trial]
            ends[hunt.outcome] += 1
        assert len(ends) > 1

    # What is seen of it

    def test_a_snapshot_has_the_tables(self, run: Run) -> None:
        seen, known = moment(run), tables(run.spec, run.state)
        for name in ("selection_q", "skill_q", "visits", "first_reach"):
            expected = known[name]
            if name == "selection_q":
                expected = np.where(np.isnan(expected), -np.inf, expected)
            np.testing.assert_array_equal(getattr(seen, name), expected, err_msg=name)
        np.testing.assert_array_equal(seen.value, seen.selection_q.max(axis=-1))
        assert (seen.eligibility is None) == (run.spec.learner.trace_decay is None)
        assert seen.commanded is None or run.spec.learner.options == COMMANDS
        for number, name in enumerate(run.spec.learner.sub_policies):
            tables_seen = [seen.skill_q_of(number, heading) for heading in range(N_HEADINGS)]
            alike = all(np.array_equal(table, tables_seen[0]) for table in tables_seen)
            assert alike or run.spec.learner.sees_heading(name)

    @pytest.mark.parametrize("frame", [FOLDED, OF_TRIAL, ALL])
    def test_every_layer_draws_it(self, run: Run, frame: Any) -> None:
        seen = moment(run)
        outcomes = hunts.success_map(run.world, policy_of(seen))
        assert outcomes is not None
        extras = Extras(SuccessMap(outcomes, run.trial, 0), since=moment(Run(run.spec, SEED)))
        options = range(seen.selection_q.shape[-1])
        for key, layer in LAYERS.items():
            for option in options if layer.about != "nothing" else (0,):
                look = layer.heeded(Look(layer=key, frame=frame, option=option), run.spec.learner)
                picture = layer.paint(seen, look, extras)
                assert picture.colours.shape == (run.world.size**2, 3)
                picture.over()
                assert layer.legend(seen, look, extras)
                assert layer.caption(seen, look, extras)
        assert moment_sent(seen, Look(), extras)

    def test_inspection_explains_it(self, run: Run) -> None:
        seen = moment(run)
        assert said_of(seen)
        for x, y, heading in ((15, 15, 0), (2, 28, 3), (20, 11, 6)):
            reading = reading_at(seen, x, y, heading)
            assert len(reading.options) > 0
            assert sum(option.greedy for option in reading.options) >= 1
            assert reading_html(reading, Look())
            assert chain_html(chain_of(seen, x, y, heading))
            (shown,) = hunts_from(seen, [(x, y)], heading)
            assert shown.hunt.outcome == reading.outcome

    def test_any_number_of_trials_may_be_asked_for(self, spec: RunSpec) -> None:
        run = Run(spec, SEED)
        run.advance(max_steps=40_000, until_trial=MAX_TRIALS)
        assert run.step == 40_000
        assert run.trial > 0
