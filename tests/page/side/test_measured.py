"""What is measured of runs side by side."""

import time

from app.live.snapshot import Snapshot, take
from app.page.side.measured import GreedyRuns
from tests.support.races import PATIENCE_S, alone, entry

TWO = (entry("standard_q"), entry("timed"))


def moment(step: int | None = None) -> tuple[Snapshot, ...]:
    """Both runs at a step, or at their ends."""
    runs = [alone(one, step) for one in TWO]
    return tuple(take(run, "", place) for place, run in enumerate(runs))


def test_of_runs_that_are_over_the_end_is_measured_however_near_it_the_last_time_was() -> None:
    greedy, ends = GreedyRuns(len(TWO)), moment()

    def is_measured(snapshots: tuple[Snapshot, ...]) -> bool:
        greedy.follow(snapshots)
        found = [greedy.at(place, one.step) for place, one in enumerate(snapshots)]
        steps = [one.step for one in snapshots]
        return [None if one is None else one[0] for one in found] == steps

    try:
        for snapshots in (moment(600), ends):
            deadline = time.monotonic() + PATIENCE_S
            while not is_measured(snapshots):
                assert time.monotonic() < deadline
                time.sleep(0.005)
    finally:
        greedy.stop()
