"""Which moments a replay has of a session: dense where much changes, and all that happened."""

from itertools import pairwise

import numpy as np
import pytest

from app.player.reel import Stop, bars_of, happenings_along, recorded_run, stops_along, stops_of
from learners.kernel.state import digest
from learners.run import replay
from tests.support.replays import SEED, small_branchy, small_recorded
from tests.support.schedules import ruled_spec, small_spec


def test_a_preset_s_run_is_that_of_its_seed() -> None:
    recorded = small_recorded()
    line = recorded.live
    alone = replay(small_spec(), SEED, [], line.until_step)
    assert line.digest == digest(alone.state)
    assert line.until_trial == alone.trial == small_spec().trials
    assert (recorded.preset, recorded.seed) == ("timed", SEED)


@pytest.mark.parametrize("most", [1, 20, 200])
def test_each_line_has_its_own_moments_in_order_with_its_ends_and_all_that_happened(
    most: int,
) -> None:
    recorded = small_branchy()
    stops = stops_of(recorded, most)
    assert len(set(stops)) == len(stops)
    for line in recorded.lines:
        steps = [stop.step for stop in stops if stop.line == line.number]
        assert steps == sorted(steps)
        assert (steps[0], steps[-1]) == (line.fork_step, line.until_step)
        happened = {
            one.step
            for one in happenings_along(recorded, line)
            if line.fork_step <= one.step <= line.until_step
        }
        assert happened <= set(steps)


def test_moments_are_dense_where_much_changes() -> None:
    recorded = small_recorded()
    steps = np.array([stop.step for stop in stops_of(recorded, 150)])
    last = int(steps[-1])
    early = int((steps < last // 4).sum())
    late = int((steps >= last - last // 4).sum())
    # Values come early here, and hardly change at the end.
    assert early > 1.3 * late
    assert max(b - a for a, b in pairwise(steps.tolist())) < last / 20


def test_a_film_of_a_branch_begins_with_the_line_that_it_left() -> None:
    recorded = small_branchy()
    branch = next(line for line in recorded.lines if line.parent is not None)
    stops = stops_along(recorded, branch.number, 60)
    before = [stop for stop in stops if stop.line != branch.number]
    assert before[0] == Stop(branch.parent or 0, 0)
    assert all(stop.step < branch.fork_step for stop in before)
    assert stops[-1] == Stop(branch.number, branch.until_step)


def test_bars_are_of_what_is_recorded_and_offer_no_change() -> None:
    recorded = small_branchy()
    for line, bars in bars_of(recorded).items():
        for unit in ("trials", "steps"):
            bar = getattr(bars, unit)
            assert bar["recorded"]
            assert (bar["line"], bar["axis"]["unit"]) == (line, unit)
            assert len(bar["lines"]) == len(recorded.lines)
            assert not any(p["editable"] for lane in bar["lanes"] for p in lane["pieces"])
            assert bar["greedy"]["reward"]


def test_a_run_that_has_hardly_begun_can_be_played() -> None:
    recorded = recorded_run(small_spec("trials=1"), "timed", 1)
    assert stops_of(recorded, 9)[0] == Stop(0, 0)
    assert bars_of(recorded)[0].trials["end"]["trial"] == 1


def test_bars_have_what_a_rule_watched_along_either_axis() -> None:
    recorded = recorded_run(ruled_spec(), "timed", 5)
    bars = bars_of(recorded)[recorded.live.number]
    for bar in (bars.trials, bars.steps):
        circle, avoid = bar["rules"]
        assert (circle["skill"], circle["until"], circle["met"]) == ("circle_clockwise", 436, True)
        assert (avoid["skill"], avoid["until"]) == ("avoid", None)
