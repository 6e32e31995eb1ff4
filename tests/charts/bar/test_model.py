"""Curves, bands and ghosts of the bar."""

from dataclasses import replace

import numpy as np
import pytest

from app.charts.bar.axis import axis_of
from app.charts.bar.model import Ghost, Moment, View, bands_of, bar_of, ghost_of, learned_of
from app.live.snapshot import Snapshot
from app.schedule.blocks import blocks_of
from learners.commands import Explore, FollowSchedule, FreezeSkills
from learners.measures import Progress
from learners.run import Run
from tests.support.curves import greedy_curve, learned
from tests.support.schedules import seen, small_run, to


def at_step(step: int, **parts: object) -> Snapshot:
    """A moment of a run of 500 trials of 100 steps each."""
    trial = step // 100
    progress = Progress(np.array([0, trial]), np.array([0, trial * 100]))
    shot = replace(seen(small_run()), step=step, trial=trial, progress=progress)
    return replace(shot, **parts)


# Curves


def test_a_run_without_an_end_of_a_trial_has_no_curve() -> None:
    shot = at_step(0, curve=learned([], []), trial_curve=learned([], []))
    for unit in ("trials", "steps"):
        assert learned_of(shot, axis_of(shot, unit)).at.size == 0


def test_the_first_window_is_level_and_stays_so_when_others_follow() -> None:
    one = at_step(700, curve=learned([700], [-12.5]))
    axis = axis_of(one, "steps")
    points = learned_of(one, axis)
    assert (points.at * axis.end).tolist() == pytest.approx([0, 700])
    assert points.reward.tolist() == [-12.5, -12.5]
    two = at_step(2_000, curve=learned([1_000, 2_000], [-12.5, 4.0]))
    axis = axis_of(two, "steps")
    points = learned_of(two, axis)
    assert (points.at * axis.end).tolist() == pytest.approx([0, 1_000, 2_000])
    assert points.reward.tolist() == [-12.5, -12.5, 4.0]


def test_windows_in_which_no_trial_ended_are_left_out() -> None:
    nan = float("nan")
    shot = at_step(3_500, curve=learned([1_000, 2_000, 3_000, 3_500], [nan, -50.0, nan, 100.0]))
    assert learned_of(shot, axis_of(shot, "steps")).reward.tolist() == [-50.0, -50.0, 100.0]


@pytest.mark.parametrize(("last", "shown"), [(3_400, 3), (3_600, 4), (4_000, 4)])
def test_a_window_that_has_just_begun_does_not_end_the_curve(last: int, shown: int) -> None:
    spiked = learned([1_000, 2_000, 3_000, last], [10.0, 12.0, 11.0, 100.0])
    shot = at_step(last, curve=spiked)
    assert learned_of(shot, axis_of(shot, "steps")).reward.size == shown + 1


def test_windows_of_trials_stand_where_they_end() -> None:
    shot = at_step(40_000, trial_curve=learned([10_000, 35_000], [60.0, 20.0]))
    points = learned_of(shot, axis_of(shot, "trials"))
    assert points.at.tolist() == [0, 0.2, 0.7]
    assert points.reward.tolist() == [60.0, 60.0, 20.0]


def test_greedy_reward_stands_where_it_was_measured_and_tells_of_gaps() -> None:
    shot = at_step(40_000)
    greedy = greedy_curve(
        (20, 2_000, 4.0), (45, 4_500, 40.0), (300, 30_000, 50.0), (450, 45_000, 9)
    )
    bar = bar_of(Moment(shot, blocks_of(shot), greedy=greedy), "trials", greedy_every=20)
    # What is yet to come is not told.
    assert bar.greedy.at.tolist() == [0.04, 0.09, 0.6]
    assert bar.greedy.reward.tolist() == [4.0, 40.0, 50.0]
    assert bar.greedy_gaps == (False, True)


def test_a_ghost_goes_by_its_own_trials_or_steps_as_far_as_the_axis_goes() -> None:
    ghost = Ghost(
        "the run before",
        "",
        curve=learned([1_000, 5_000, 90_000], [1.0, 2.0, 3.0]),
        trial_curve=learned([20_000, 40_000, 90_000], [5.0, 6.0, 7.0]),
        progress=Progress(np.array([0, 1_000]), np.array([0, 100_000])),
    )
    shot = at_step(9_000)
    assert ghost_of(ghost, axis_of(shot, "trials")).at.tolist() == [0, 0.4, 0.8]
    steps = ghost_of(ghost, axis_of(shot, "steps"))
    assert steps.reward.tolist() == [1.0, 1.0, 2.0]
    assert steps.at.tolist() == [0, 0.1, 0.5]


# Bands


def spans(run: Run, kind: str) -> list[tuple[int, int | None]]:
    bands = bands_of(blocks_of(seen(run)))
    return [(band.block.first, band.block.until) for band in bands if band.kind == kind]


def test_forced_exploration_is_a_band() -> None:
    assert spans(to(small_run(), 130), "forced") == [(100, 160), (200, 250), (300, 340)]


def test_freezes_are_bands_be_they_by_hand_or_as_a_skill_joins() -> None:
    run = to(small_run(), 30)
    run.apply(FreezeSkills(True))
    to(run, 50)
    assert spans(run, "frozen") == [(0, 10), (30, None), (100, 120), (200, 220)]


def test_what_will_not_happen_is_no_band() -> None:
    run = to(small_run(), 30)
    run.apply(Explore("approach", 10, 0.5))
    run.apply(FollowSchedule(False))
    assert spans(run, "forced") == [(30, 40)]


def test_the_axis_of_rewards_ends_with_those_of_the_world() -> None:
    shot = seen(small_run())
    bar = bar_of(Moment(shot, ()), "trials", 2_000)
    assert bar.rewards == (-50.0, 100.0)


# A part of a run


def rewards_at(shot: Snapshot, view: View) -> list[tuple[int, float]]:
    bar = bar_of(Moment(shot, ()), "trials", 500, view)
    trials = bar.axis.start + bar.learned.at * (bar.axis.end - bar.axis.start)
    return [
        (round(trial), round(reward, 6))
        for trial, reward in zip(trials.tolist(), bar.learned.reward.tolist(), strict=True)
    ]


def test_a_part_of_a_run_has_an_axis_of_its_own_and_begins_with_what_was_known_before() -> None:
    windows = learned([10_000, 20_000, 30_000, 40_000], [0.0, 10.0, 20.0, 30.0])
    shot = at_step(40_000, trial_curve=windows)
    assert rewards_at(shot, View(150, 420)) == [(150, 5.0), (200, 10.0), (300, 20.0), (400, 30.0)]
    assert rewards_at(shot, View(0, 350)) == [(0, 0.0), (100, 0.0), (200, 10.0), (300, 20.0)]
    # As it was last.
    assert rewards_at(shot, View(450, 500)) == [(450, 30.0)]


def test_nothing_is_told_of_the_rewards_after_the_trial_at_which_they_are_hidden() -> None:
    windows = learned([10_000, 20_000, 30_000], [0.0, 10.0, 20.0])
    shot = at_step(30_000, trial_curve=windows)
    other = at_step(30_000, trial_curve=windows._replace(reward=np.array([0.0, 10.0, -40.0])))
    hidden = View(100, 420, hides_after=299)
    assert rewards_at(shot, hidden) == rewards_at(other, hidden) == [(100, 0.0), (200, 10.0)]
    greedy = greedy_curve((100, 10_000, 1.0), (200, 20_000, 2.0), (300, 30_000, 3.0))
    ghost = Ghost("timed", "", windows, windows, shot.progress)
    moment = Moment(shot, (), greedy=greedy, ghost=ghost)
    bar = bar_of(moment, "trials", 100, hidden)
    assert bar.greedy.reward.tolist() == [1.0, 2.0]
    assert bar.ghost is None
    assert bar_of(moment, "trials", 100).ghost is not None
    assert len(bar_of(moment, "trials", 100, View(100, 420)).greedy.at) == 3


def test_of_the_schedule_a_part_has_what_goes_on_there() -> None:
    run = to(small_run(), 400)
    moment = Moment(seen(run), blocks_of(seen(run)))
    bar = bar_of(moment, "trials", 500, View(250, 450))
    drawn = [piece.block for lane in bar.lanes for piece in lane.pieces]
    assert all(block.until is None or block.until > 250 for block in drawn)
    assert drawn
    assert len(bar.lanes) == len(bar_of(moment, "trials", 500).lanes)
    assert all(0.0 <= mark.at <= 1.0 for mark in bar.marks)
    ticks = [tick.text for tick in bar.axis.ticks]
    assert ticks[0] != "0"
