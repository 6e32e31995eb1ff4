"""One axis: trials and steps of a run have the same places in the curve and in the lanes."""

from dataclasses import replace

import numpy as np
import pytest

from app.charts.bar.axis import axis_of, last_trial
from learners.measures import Progress
from tests.support.schedules import seen, small_run, to


def test_places_along_trials_are_linear_and_end_with_the_last() -> None:
    axis = axis_of(seen(to(small_run(), 250)), "trials")
    assert [axis.of_trial(trial) for trial in (0, 100, 250, 500, 9_000)] == [0, 0.2, 0.5, 1, 1]
    assert axis.now == 0.5


def test_the_axis_goes_on_when_the_run_does() -> None:
    run = small_run()
    assert last_trial(seen(run)) == 500
    assert last_trial(seen(to(run, 500))) == 500
    assert last_trial(seen(to(run, 501))) == 1_000


def test_trials_that_have_ended_stand_along_steps_where_they_began() -> None:
    run = to(small_run(), 330)
    axis = axis_of(seen(run), "steps")
    made = np.concatenate([[0], np.cumsum(run.state.log_steps[:330])])
    for trial in (0, 1, 100, 329, 330):
        assert axis.of_trial(trial) == pytest.approx(made[trial] / axis.end)
    assert axis.now == run.step / axis.end


def test_both_kinds_of_axis_agree_on_what_was_when() -> None:
    run = to(small_run(), 330)
    along = axis_of(seen(run), "trials"), axis_of(seen(run), "steps")
    steps = np.array([0, 500, 2_000, run.step])
    for step, place in zip(steps, along[0].of_steps(steps), strict=True):
        # Between the beginnings of two trials.
        assert along[1].of_trial(int(place * 500)) <= step / along[1].end + 1e-9
        assert along[1].of_trial(int(place * 500) + 1) >= step / along[1].end - 1e-9


def test_trials_ahead_are_taken_to_be_as_long_as_the_latest() -> None:
    shot = replace(
        seen(small_run()),
        progress=Progress(np.array([0, 1_000, 3_000]), np.array([0, 90_000, 130_000])),
        trial=3_000,
        step=130_000,
    )
    axis = axis_of(shot, "steps")
    assert axis.of_trial(3_100) * axis.end == pytest.approx(130_000 + 100 * 20)


def test_a_moment_that_is_newer_than_its_curves_has_its_place() -> None:
    former = seen(to(small_run(), 100))
    run = to(small_run(), 200)
    axis = axis_of(replace(seen(run), progress=former.progress), "steps")
    assert axis.of_trial(200) == pytest.approx(run.step / axis.end)


@pytest.mark.parametrize(
    ("step", "end", "texts"),
    [
        (0, 1e4, ["0", "2 k", "4 k", "6 k", "8 k", "10 k"]),
        (147_057, 1.5e5 * 4 / 3, ["0", "0.05 M", "0.1 M", "0.15 M", "0.2 M"]),
        (863_706, 1e6, ["0", "0.2 M", "0.4 M", "0.6 M", "0.8 M", "1 M"]),
        (5_470_000, 6e6, ["0", "1 M", "2 M", "3 M", "4 M", "5 M", "6 M"]),
    ],
)
def test_numbers_along_steps_have_few_digits(step: int, end: float, texts: list[str]) -> None:
    axis = axis_of(replace(seen(small_run()), step=step), "steps")
    assert axis.end == pytest.approx(end)
    assert [tick.text for tick in axis.ticks] == texts
    assert all(0 <= tick.at <= 1 for tick in axis.ticks)


def test_numbers_along_trials_are_the_words_that_people_use() -> None:
    axis = axis_of(seen(small_run("trials=48000")), "trials")
    assert [tick.text for tick in axis.ticks] == ["0", "10,000", "20,000", "30,000", "40,000"]
