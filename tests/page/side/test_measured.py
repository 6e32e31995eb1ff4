"""What is found of runs side by side follows the lines that they are of."""

import time
from collections.abc import Callable

from app.live.divergence import Divergence
from app.live.past import Budget, Past
from app.live.race import Race
from app.live.racer import Entry
from app.live.snapshot import Snapshot, take
from app.page.side.measured import Apart, GreedyRuns
from learners.commands import SetParameter
from learners.names import MAX_TRIALS
from learners.run import Run
from tests.support.races import PATIENCE_S, SEED, alone, entry, racing, small

TWO = (entry("standard_q"), entry("timed"))
STEPS = 2_000


def test_where_two_part_is_found_anew_when_one_has_been_taken_back() -> None:
    spec = small("timed", "trials=4000")
    plain, steered = Run(spec, SEED), Run(spec, SEED)
    pasts = {1: Past(plain, Budget()), 2: Past(steered, Budget())}
    go_on(plain, pasts[1], STEPS)
    go_on(steered, pasts[2], 1_000)
    steered.apply(SetParameter("learner.epsilon", 0.9))
    pasts[2].note(steered)
    go_on(steered, pasts[2], STEPS)
    entries = [Entry(f"line {line}", "timed", SEED, spec, line) for line in pasts]
    with racing(entries, pasts.get) as race:
        apart = Apart()
        first = found(apart, race, lambda one: True)
        assert first.step >= 1_000
        again = pasts[2].run_at(500)
        assert again is not None
        again.apply(SetParameter("learner.epsilon", 0.9))
        pasts[2].note(again)
        go_on(again, pasts[2], STEPS)
        second = found(apart, race, lambda one: one is not first)
        assert 500 <= second.step < first.step
        apart.stop()


def go_on(run: Run, past: Past, step: int) -> None:
    run.advance(step - run.step, MAX_TRIALS)
    past.note(run)


def found(apart: Apart, race: Race, is_it: Callable[[Divergence], bool]) -> Divergence:
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        one = apart.of(race, 0, 1, STEPS)
        if one is not None and is_it(one):
            return one
    raise TimeoutError("it was not found in time")


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
