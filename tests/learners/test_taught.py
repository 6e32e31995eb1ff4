"""Who chooses in a run: a script for some trials, or a skill alone before the first of them."""

import math
import re

import numpy as np
import pytest

from app.documents import presets
from app.live import snapshot
from learners.commands import (
    CommandError,
    FollowSchedule,
    Introduce,
    SetSchedule,
    StopTeaching,
    Teach,
    Undo,
)
from learners.kernel.state import REPERTOIRE, STEP, TRIAL_STEP, digest
from learners.names import MAX_TRIALS
from learners.policies.taught import flank, table_of
from learners.run import Run, replay
from learners.schedule_spec import TeachSpec
from learners.spec import RunSpec
from sim.spec import WorldSpec
from sim.world import board_xy, cell_at, compile_world

SMALL = (
    "world.size=30",
    "world.n_directions=16",
    "world.n_distances=6",
    "world.step_limit=60",
    "trials=300",
)
THREE = ("approach", "circle_clockwise", "avoid")
AVOID = THREE.index("avoid")


def small(preset: str, *settings: str) -> RunSpec:
    """A preset in a small world."""
    return presets.load(preset, [*SMALL, *settings])


def taken_in_a_trial(run: Run) -> set[int]:
    """Options of the next trial's steps."""
    trial, taken = run.trial, set[int]()
    while run.trial == trial:
        before = run.state.visits.copy()
        run.advance(max_steps=1)
        taken.add(int(np.argmax(run.state.visits != before)) % len(run.spec.learner.skills))
    return taken


# --- The script ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("distance", "degrees", "skill"),
    [
        (10, 0, "avoid"),
        (28, 85, "avoid"),
        (28, 95, "avoid"),
        (28, 97, "circle_clockwise"),
        (30, 0, "circle_clockwise"),
        (40, 100, "circle_clockwise"),
        (40, 109, "circle_clockwise"),
        (40, 112, "approach"),
        (5, 180, "approach"),
    ],
)
@pytest.mark.parametrize("heading", range(8))
@pytest.mark.parametrize("side", [-1, 1])
def test_the_script_backs_away_in_front_and_approaches_behind(
    distance: float, degrees: float, skill: str, heading: int, side: int
) -> None:
    world = WorldSpec()
    table = table_of("flank", world, THREE, THREE)
    compiled = compile_world(world)
    angle = math.radians(heading * 45 + side * degrees)
    x = round(60 + distance * math.cos(angle))
    y = round(60 + distance * math.sin(angle))
    n_cells = compiled.cell_word.size
    assert THREE[table[heading * n_cells + cell_at(compiled, x, y)]] == skill


def test_the_script_is_the_same_for_every_heading() -> None:
    table = flank(WorldSpec(size=41))
    assert (table[2] == np.rot90(table[0], -1)).all(), "counter-clockwise, y to the north"
    table[:, 20, 20] = 0  # the prey's own cell, on which nobody ever stands
    assert (table[4] == table[0][::-1, ::-1]).all()
    assert (table[5] == table[1][::-1, ::-1]).all()


def test_where_there_are_both_circles_it_takes_the_clockwise_one() -> None:
    skills = ("circle_counterclockwise", "avoid", "approach", "circle_clockwise")
    assert set(table_of("flank", WorldSpec(), skills, skills)) == {1, 2, 3}
    skills = ("circle_counterclockwise", "avoid", "approach")
    assert set(table_of("flank", WorldSpec(), skills, skills)) == {0, 1, 2}


# --- Teaching ------------------------------------------------------------------------------------


def test_while_it_is_taught_a_learner_takes_what_the_script_says() -> None:
    run = Run(small("hierarchical_3_taught", "schedule.teach.trials=100"), 3)
    table = table_of("flank", run.spec.world, THREE, THREE)
    n_cells = run.world.cell_word.size
    while run.trial < 100:
        place = int(run.state.place[1]) * n_cells + int(run.state.place[0])
        before = run.state.visits.copy()
        run.advance(max_steps=1)
        assert np.argmax(run.state.visits != before) % 3 == table[place]
    assert not run.is_taught
    assert any(len(taken_in_a_trial(run)) == 3 for _ in range(20)), "it chooses for itself again"


def test_teaching_by_hand_is_as_by_the_schedule() -> None:
    by_schedule = Run(small("hierarchical_3_taught", "schedule.teach.trials=50"), 4)
    by_hand = Run(small("hierarchical_3"), 4)
    by_hand.apply(Teach("flank", 50))
    for run in (by_schedule, by_hand):
        run.advance()
    assert digest(by_schedule.state) == digest(by_hand.state)
    again = replay(by_hand.preset, 4, by_hand.journal, by_hand.step)
    assert digest(again.state) == digest(by_hand.state)


def test_teaching_can_be_stopped_given_again_and_taken_back() -> None:
    run = Run(small("hierarchical_3_taught"), 5)
    run.advance(until_trial=10)
    run.apply(StopTeaching())
    assert not run.is_taught
    run.apply(Undo(run.control.history[-1].number))
    assert run.is_taught
    assert run.control.taught_until == 300
    run.apply(Teach("flank", 5))
    assert run.control.taught_until == 15
    run.apply(Undo(run.control.history[-1].number))
    assert run.control.taught_until == 300


def test_what_is_over_is_not_taken_back() -> None:
    run = Run(small("hierarchical_3"), 5)
    run.apply(Teach("flank", 10))
    taught = run.control.history[-1].number
    run.advance(until_trial=5)
    run.apply(StopTeaching())
    stopped = run.control.history[-1].number
    with pytest.raises(CommandError, match="that teaching is over"):
        run.apply(Undo(taught))
    run.advance(until_trial=10)
    with pytest.raises(CommandError, match="that teaching would be over by now"):
        run.apply(Undo(stopped))


def test_of_two_lessons_before_a_step_only_the_last_counts() -> None:
    run = Run(small("hierarchical_3"), 5)
    for trials in (10, 20, 30):
        run.apply(Teach("flank", trials), replacing=True)
    assert [command for _, command in run.journal] == [Teach("flank", 30)]


def test_a_schedule_that_is_not_followed_still_taught_from_the_start() -> None:
    run = Run(small("hierarchical_3_taught"), 5)
    run.apply(FollowSchedule(False))
    assert run.is_taught, "it was given before the first step"


def test_what_was_taught_cannot_be_planned_anew() -> None:
    run = Run(small("hierarchical_3_taught"), 5)
    run.advance(until_trial=3)
    schedule = run.spec.schedule.model_copy(update={"teach": TeachSpec(trials=200)})
    with pytest.raises(CommandError, match="is past and cannot change"):
        run.apply(SetSchedule(schedule))


@pytest.mark.parametrize(
    ("preset", "message"),
    [
        ("standard_q", "flank chooses approach, avoid, a circle, not among"),
        ("hierarchical_2", "flank chooses avoid, not among the learner's options; allowed: none, "),
    ],
)
def test_a_learner_without_the_skills_of_the_script_is_not_taught(
    preset: str, message: str
) -> None:
    run = Run(small(preset), 1)
    with pytest.raises(CommandError, match=re.escape(message)):
        run.apply(Teach("flank", 10))
    with pytest.raises(presets.PresetError, match="chooses"):
        small(preset, "schedule.teach={trials: 10}")


# --- Pre-training --------------------------------------------------------------------------------


def pretrained() -> Run:
    """A run of three skills that come one after the other, each alone for 400 steps first."""
    return Run(small("timed", "schedule.pretrain=400"), 6)


def test_each_skill_learns_alone_in_turn_and_trials_begin_as_ever() -> None:
    run, plain = pretrained(), Run(small("timed"), 6)
    for number, skill in enumerate(THREE):
        alone = run.alone
        assert alone is not None
        assert (alone.skill, alone.until_step) == (skill, 400 * (number + 1))
        before = run.state.skills.reshape(3, -1).copy()
        run.advance(max_steps=400)
        changed = (run.state.skills.reshape(3, -1) != before).any(axis=1)
        assert changed.tolist() == [number == other for other in range(3)]
    assert run.alone is None
    assert (run.trial, run.step, run.state.tally[TRIAL_STEP]) == (0, 1_200, 0)
    assert run.start == plain.start == run.start_of(0)
    assert run.state.visits.sum() == 1_200
    selection = snapshot.take(run, "", 0).selection_q
    assert (selection[np.isfinite(selection)] == 0).all(), "the selection has learned nothing"


def test_starts_are_those_of_trials_that_no_run_has() -> None:
    run = pretrained()
    assert run.start == run.start_of(MAX_TRIALS)
    run.advance(max_steps=399)
    moment = snapshot.take(run, "", 0)
    assert board_xy(run.world, moment.trail[0]) == board_xy(run.world, run.start[0])
    assert len(moment.trail) == run.state.tally[TRIAL_STEP] + 1


def test_its_steps_are_logged_with_the_first_trial_and_no_part_of_its_way() -> None:
    run = pretrained()
    run.advance(until_trial=30)
    assert run.state.log_steps[:30].sum() + run.state.tally[TRIAL_STEP] == run.state.tally[STEP]
    paths = snapshot.take(run, "", 0).paths
    run = pretrained()
    run.advance(until_trial=3)
    paths = snapshot.take(run, "", 0).paths
    assert [len(path.cells) for path in paths][1:] == (run.state.log_steps[1:3] + 1).tolist()
    assert len(paths[0].cells) == run.state.log_steps[0] - run.pretrained_steps + 1
    assert paths[0].cells[0] == run.start_of(0)[0]


def test_what_a_skill_saw_alone_is_new_to_the_selection() -> None:
    run = pretrained()
    repertoire = int(run.state.tally[REPERTOIRE])
    run.advance(max_steps=1_200)
    assert run.state.tally[REPERTOIRE] == repertoire + 1
    run.advance(until_trial=5)
    assert run.state.log_new_states[0] > 0


def test_a_skill_that_comes_by_hand_is_not_pretrained() -> None:
    run = pretrained()
    run.advance(max_steps=100)
    run.apply(Introduce("circle_counterclockwise", 0))
    run.advance(max_steps=1_100)
    assert run.alone is None
    assert run.trial == 0


def test_a_moment_of_pretraining_is_made_again_from_its_journal() -> None:
    run = pretrained()
    run.advance(max_steps=150)
    run.apply(Teach("flank", 20))
    run.advance(max_steps=700)
    again = replay(run.preset, 6, run.journal, run.step)
    assert digest(again.state) == digest(run.state)
    assert (again.state.place == run.state.place).all()


@pytest.mark.parametrize(
    ("preset", "setting", "message"),
    [
        ("standard_q", "schedule.pretrain=5", "trains skills, and the options are moves"),
        ("standard_q", "learner.applicable=0.5", "needs skills between which a table selects"),
        ("feudal", "learner.held={until: change}", "a command holds"),
        ("q_lambda", "learner.held={until: change}", "traces go from move to move"),
        ("timed", "learner.held={most: 5}", "learner.held.until: is missing"),
        ("timed", "learner.held={until: change, most: 0}", "learner.held.most: value 0: must be"),
        ("timed", "schedule.teach={script: frontal, trials: 5}", "schedule.teach.script: value"),
        ("timed", "schedule.pretrain=-1", "schedule.pretrain: value -1: must be at least 0"),
    ],
)
def test_what_cannot_work_is_refused_with_the_reason(
    preset: str, setting: str, message: str
) -> None:
    with pytest.raises(presets.PresetError, match=re.escape(message)):
        small(preset, setting)


def test_applicable_skills_need_the_sensors_of_the_selection() -> None:
    with pytest.raises(presets.PresetError, match="asks in each state of the selection"):
        small("timed", "learner.applicable=0.5", "world.skill_n_directions=24")
