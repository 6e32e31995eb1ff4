"""Racers are in lockstep, each the run that it would be alone; lines are followed, and no more."""

import operator
import threading
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.documents import presets
from app.live.past import Budget, Past
from app.live.race import FEWEST, MOST, THESIS_FOUR, Race, RaceStatus, thesis_four
from app.live.racer import Entry
from app.live.snapshot import Snapshot, curve_window
from app.live.worker import FULL_SPEED
from learners import run as run_module
from learners.commands import CommandError, FreezeSelection, SetParameter
from learners.kernel.state import STEP, digest, selection_q_of
from learners.run import Run, replay
from tests.support import lines
from tests.support.lines import SPEC, Script, commands, play, scripts, stands, tell
from tests.support.races import (
    PATIENCE_S,
    SEED,
    alone,
    answered,
    at_rest,
    entry,
    over,
    racing,
    small,
    snapshots_at,
    tables,
)

LINE = 4

seeds = st.sampled_from([0, 7, 2**63 - 1]) | st.integers(0, 2**63 - 1)
some_presets = st.lists(
    st.sampled_from(list(presets.shipped())),
    min_size=FEWEST,
    max_size=MOST,
    unique=True,
)


def of_line(name: str = "line", spec: Any = SPEC) -> Entry:
    return Entry(name, "timed", lines.SEED, spec, LINE)


def check_lockstep(status: RaceStatus) -> None:
    """All stand at the one step, or at an end that comes before."""
    for snapshot, stand, trials in zip(status.snapshots, status.stands, status.trials, strict=True):
        assert snapshot.step == status.step or stand
        assert snapshot.step <= status.step
        assert snapshot.trial == trials


# Each is the run that it would be alone


@given(names=some_presets, seed=seeds, stops=st.lists(st.integers(1, 2_500), max_size=3))
@settings(max_examples=25)
def test_racers_are_the_runs_that_they_would_be_alone(
    names: list[str], seed: int, stops: list[int]
) -> None:
    entries = [entry(name, seed) for name in names]
    with racing(entries) as race:
        for stop in sorted(set(stops)):
            race.run_to(stop)
            there = race.wait_for(
                lambda s, stop=stop: s.finished or (s.step == stop and not s.playing), PATIENCE_S
            )
            check_lockstep(there)
            for racer, found in zip(entries, there.digests, strict=True):
                assert found == tables(alone(racer, stop))
        if not race.status.finished:
            race.play()
        end = over(race)
    assert end.error is None
    assert end.stands == ("finished",) * len(entries)
    check_lockstep(end)
    for racer, found, snapshot in zip(entries, end.digests, end.snapshots, strict=True):
        run = alone(racer)
        assert found == tables(run)
        assert np.array_equal(snapshot.selection_q, selection_q_of(run.spec, run.state))


def test_all_that_is_published_is_of_one_step(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [entry(name, SEED, "trials=3000") for name in THESIS_FOUR]
    seen: list[RaceStatus] = []
    with racing(entries) as race:
        take = race._take_status

        def note(now_s: float) -> RaceStatus:
            seen.append(take(now_s))
            return seen[-1]

        # In the race's own thread: who waits for one may miss those before.
        monkeypatch.setattr(race, "_take_status", note)
        race.set_speed(100_000.0)
        race.play()
        over(race)
    assert len({status.step for status in seen}) > 3
    for status in seen:
        check_lockstep(status)
    # The first is through long before the last, and stands there.
    assert len({snapshot.step for snapshot in seen[-1].snapshots}) == len(entries)
    assert any("finished" in status.stands and "" in status.stands for status in seen)
    # What stands is drawn by windows that are as wide as all others'.
    widths = {int(snapshot.curve.steps[0]) for snapshot in seen[-1].snapshots}
    assert widths == {curve_window(seen[-1].step)}


def test_trials_start_alike_for_the_four_of_the_thesis() -> None:
    four = thesis_four(small, SEED)
    assert [racer.name for racer in four] == list(THESIS_FOUR)
    assert len({racer.spec.learner.options for racer in four}) > 1
    with racing(four, playing=True) as race:
        assert over(race).common_starts
    runs = [Run(racer.spec, racer.seed) for racer in four]
    for trial in (0, 1, 59):
        assert len({run.start_of(trial) for run in runs}) == 1
    for other in (entry("timed", 8), entry("timed", SEED, "world.size=40")):
        with racing([entry("standard_q"), other]) as race:
            assert not race.status.common_starts
    # Nor what the prey sees nor what a capture is worth has to do with where trials start.
    sharp = entry("timed", SEED, "world.vision_radius=20", "world.capture_reward=50")
    with racing([entry("standard_q"), sharp]) as race:
        assert race.status.common_starts
    assert Run(sharp.spec, SEED).start_of(30) == runs[0].start_of(30)


def test_learners_of_other_worlds_race_too() -> None:
    entries = [entry("timed"), replace(entry("timed", 3, "world.size=60"), name="wide")]
    with racing(entries, playing=True) as race:
        end = over(race)
    assert [snapshot.world.size for snapshot in end.snapshots] == [30, 60]
    assert list(end.digests) == [tables(alone(racer)) for racer in entries]


# What is asked of it


def test_it_goes_on_and_stands_still_as_it_is_told() -> None:
    with racing([entry("timed", SEED, "trials=1000000"), entry("standard_q")]) as race:
        assert race.status.step == 0
        assert not race.status.playing
        assert race.status.digests
        race.set_speed(1.0)
        race.play()
        assert race.wait_for(lambda status: status.step > 0, PATIENCE_S).playing
        ticket = race.pause()
        stood = answered(race, ticket)
        assert not stood.playing
        assert stood.digests
        # On the way to a step it is as fast as it can be, whatever speed is set.
        race.run_to(30_000)
        there = race.wait_for(lambda status: status.step == 30_000, PATIENCE_S)
        assert (there.playing, there.runs_to, there.speed) == (False, None, 1.0)
        assert there.stands == ("", "finished")


def test_nothing_is_made_anew_while_all_stand_still() -> None:
    run = Run(SPEC, lines.SEED)
    past = Past(run, Budget())
    play(run, past, [], rest=600)
    with racing([of_line(), entry("standard_q")], {LINE: past}.get) as race:
        race.run_to(900)
        stood = race.wait_for(lambda s: s.step == 900 and bool(s.digests), PATIENCE_S)
        for _ in range(3):
            again = answered(race, race.pause())
            assert again.digests == stood.digests
            assert all(map(operator.is_, again.snapshots, stood.snapshots))
        # More is known of the line, and all but that stays.
        play(run, past, [], rest=100)
        follows(race, run)
        assert race.status.snapshots[1] is stood.snapshots[1]


def test_what_cannot_be_is_refused() -> None:
    said: list[str] = []
    with racing([entry("timed"), entry("standard_q")], playing=True) as race:
        end = over(race)
        for ask in (lambda: race.play(said.append), lambda: race.run_to(10**6, said.append)):
            answered(race, ask())
        assert said == ["the trials of all are over; start the race again"] * 2
        assert race.status.digests == end.digests
    with racing([entry("timed"), entry("standard_q")]) as race:
        race.run_to(500)
        race.wait_for(lambda status: status.step == 500, PATIENCE_S)
        answered(race, race.run_to(400, said.append))
        assert said[-1].startswith("step 400 is past, the race is at step 500")


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ([entry("timed")], "a race is of 2 to 4 runs, and not of 1"),
        ([replace(entry("timed"), name=str(n)) for n in range(5)], "not of 5"),
        ([entry("timed"), entry("timed")], "two runs are called timed"),
        ([entry("timed"), replace(entry("timed"), name=" ")], "needs a name"),
        ([entry("timed"), of_line()], "line is not in the tree any more"),
        ([entry("timed"), replace(entry("standard_q"), seed=-1)], "standard_q: seed"),
    ],
)
def test_a_race_that_cannot_be_is_none(entries: list[Entry], said: str) -> None:
    with pytest.raises(CommandError, match=said):
        Race(entries, Budget())


def test_an_error_of_one_stops_all_and_the_moment_before_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    four = [entry(name, SEED, "trials=100000") for name in THESIS_FOUR]
    advance = run_module.loop.advance

    def breaks(world: Any, state: Any, *rest: Any) -> int:
        is_third = not state.skills.size and state.tally[STEP] > 5_000
        if is_third:
            raise FloatingPointError("the kernel broke")
        return advance(world, state, *rest)

    monkeypatch.setattr(run_module.loop, "advance", breaks)
    said: list[str] = []
    with racing(four) as race:
        race.set_speed(50_000.0)
        race.play()
        stopped = over(race)
        assert stopped.error == "standard_q: FloatingPointError: the kernel broke"
        assert not stopped.playing
        check_lockstep(stopped)
        assert stopped.step > 0
        monkeypatch.undo()
        answered(race, race.play(said.append))
        assert said == [f"the race has stopped: {stopped.error}"]
        assert race.status.step == stopped.step
        # What they had learned is there, and can be looked at.
        for racer, snapshot in zip(four, snapshots_at(race, stopped.step), strict=True):
            assert np.array_equal(snapshot.visits, visits_of(alone(racer, stopped.step)))


def visits_of(run: Run) -> np.ndarray:
    return run.state.visits.reshape(8, 6, 16, -1)


# Moments


@given(steps=st.lists(st.integers(0, 40_000), min_size=5, max_size=20), last=st.floats(0, 1))
@settings(max_examples=10)
def test_looking_at_what_is_past_changes_nothing_and_shows_all_at_one_step(
    steps: list[int], last: float
) -> None:
    entries = [entry(name, SEED, "trials=2000") for name in ("timed", "standard_q")]
    with racing(entries) as race:
        race.set_speed(300_000.0)
        race.play()
        news = threading.Semaphore(0)
        race.moments.call_when_found(news.release)
        for step in steps:
            there = race.status
            for viewer in ("one", "other"):
                race.moments.want(viewer, step)
            found = snapshots_at(race, there.step)
            assert [moment.step for moment in found] == [one.step for one in there.snapshots]
        race.set_speed(FULL_SPEED)
        end = over(race)
        step = round(last * end.step)
        race.moments.want("last", step)
        while (moments := race.moments.found("last")) is None:
            assert news.acquire(timeout=PATIENCE_S)
    assert list(end.digests) == [tables(alone(racer)) for racer in entries]
    for racer, moment in zip(entries, moments, strict=True):
        assert moment.step == min(step, alone(racer).step)
        assert_is(moment, alone(racer, step))


def assert_is(snapshot: Snapshot, run: Run) -> None:
    assert (snapshot.step, snapshot.trial) == (run.step, run.trial)
    assert np.array_equal(snapshot.visits, visits_of(run))
    assert np.array_equal(snapshot.selection_q, selection_q_of(run.spec, run.state))


def test_a_moment_that_was_cut_short_by_where_the_race_was_is_made_anew() -> None:
    entries = [entry(name, SEED, "trials=1000") for name in ("timed", "standard_q")]
    with racing(entries) as race:
        found = threading.Semaphore(0)
        race.moments.call_when_found(found.release)

        def look(step: int) -> list[int]:
            race.moments.want("me", step)
            assert found.acquire(timeout=PATIENCE_S)
            moment = race.moments.found("me")
            assert moment is not None
            return [snapshot.step for snapshot in moment]

        race.run_to(300)
        race.wait_for(lambda status: status.step == 300, PATIENCE_S)
        assert look(800) == [300, 300]
        race.run_to(1_000)
        race.wait_for(lambda status: status.step == 1_000, PATIENCE_S)
        assert look(800) == [800, 800]
        # What is there need not be made again.
        race.moments.want("me", 800)
        assert not found.acquire(blocking=False)


def test_checkpoints_of_all_are_within_the_budget() -> None:
    entries = [entry(name, SEED, "trials=4000") for name in THESIS_FOUR]
    checkpoint = max(Run(racer.spec, SEED).checkpoint().nbytes for racer in entries)
    budget = Budget(most_bytes=10 * checkpoint, nearest_steps=2_000)
    with racing(entries, budget=budget, playing=True) as race:
        end = over(race)
        assert 0 < budget.nbytes <= budget.most_bytes
        snapshots_at(race, end.step // 2)
        assert budget.nbytes <= budget.most_bytes
    assert budget.nbytes == 0


# Lines that are followed


def follows(race: Race, run: Run) -> None:
    """Check that a race has come to stand where its line does."""
    race.heed()
    status = race.wait_for(
        lambda status: status.digests != () and status.digests[0] == digest(run.state), PATIENCE_S
    )
    check_lockstep(status)
    assert status.snapshots[0].step == run.step
    assert status.snapshots[0].generation == LINE
    assert status.stands[0] == "known"


@given(parts=st.lists(scripts, min_size=1, max_size=3))
@settings(max_examples=25)
def test_a_line_is_followed_as_it_grows_and_never_touched(parts: list[Script]) -> None:
    run = Run(SPEC, lines.SEED)
    past = Past(run, Budget())
    with racing([of_line(), entry("standard_q")], {LINE: past}.get, playing=True) as race:
        for part in parts:
            play(run, past, part, rest=400)
            race.play()
            follows(race, run)
        # It is the run that it would have been.
        twin = replay(SPEC, lines.SEED, run.journal, run.step)
        assert stands(run) == stands(twin)
        (of_it, _) = snapshots_at(race, run.step // 2)
        then = replay(SPEC, lines.SEED, run.journal, of_it.step)
        assert np.array_equal(of_it.selection_q, selection_q_of(then.spec, then.state))


@given(part=scripts, given=st.lists(commands, min_size=1, max_size=4))
@settings(max_examples=15)
def test_what_is_done_on_a_line_while_it_stands_is_followed(part: Script, given: Any) -> None:
    run = Run(SPEC, lines.SEED)
    past = Past(run, Budget())
    play(run, past, part, rest=300)
    with racing([of_line(), entry("standard_q")], {LINE: past}.get, playing=True) as race:
        follows(race, run)
        for command in given:
            tell(run, command)
            past.note(run)
            race.heed()
        race.wait_for(
            lambda s: bool(s.digests) and s.snapshots[0].control == run.control, PATIENCE_S
        )
        follows(race, run)


def test_a_line_that_goes_another_way_is_followed_there() -> None:
    run = Run(SPEC, lines.SEED)
    past = Past(run, Budget())
    play(run, past, [(700, FreezeSelection(True))], rest=2_000)
    with racing([of_line(), entry("standard_q", SEED, "trials=400")], {LINE: past}.get) as race:
        race.run_to(2_000)
        race.wait_for(lambda status: status.step == 2_000, PATIENCE_S)
        other = past.run_at(1_000)
        assert other is not None
        past.note(other)
        follows(race, other)
        assert race.status.step == 2_000
        play(other, past, [(100, SetParameter("learner.alpha", 0.4))], rest=500)
        follows(race, other)
        play(other, past, [], rest=5_000)
        race.heed()
        caught_up = race.wait_for(lambda status: status.snapshots[0].step == 2_000, PATIENCE_S)
        assert caught_up.stands[0] == ""


def test_a_line_that_is_taken_out_of_the_tree_stands_until_it_is_back() -> None:
    run = Run(SPEC, lines.SEED)
    past = Past(run, Budget())
    play(run, past, [], rest=2_000)
    tree: dict[int, Past] = {LINE: past}
    with racing([of_line(), entry("standard_q", SEED, "trials=400")], tree.get) as race:
        race.run_to(500)
        race.wait_for(lambda status: status.step == 500, PATIENCE_S)
        del tree[LINE]
        race.heed()
        race.run_to(900)
        gone = race.wait_for(lambda status: status.step == 900, PATIENCE_S)
        assert (gone.stands[0], gone.snapshots[0].step) == ("gone", 500)
        tree[LINE] = past
        race.heed()
        back = race.wait_for(lambda status: status.snapshots[0].step == 900, PATIENCE_S)
        assert back.stands == ("", "")


def test_two_lines_alone_end_where_they_are_known() -> None:
    tree: dict[int, Past] = {}
    runs: Iterable[Run] = [Run(SPEC, lines.SEED), Run(SPEC, lines.SEED)]
    for number, run in enumerate(runs):
        tree[number] = Past(run, Budget())
        play(run, tree[number], [(300, FreezeSelection(bool(number)))], rest=700 + number)
    entries = [Entry(str(n), "timed", lines.SEED, SPEC, n) for n in range(2)]
    with racing(entries, tree.get, playing=True) as race:
        end = race.wait_for(lambda status: "" not in status.stands, PATIENCE_S)
        assert [snapshot.step for snapshot in end.snapshots] == [1_000, 1_001]
        assert end.stands == ("known", "known")
        # More of them may be known at any time.
        assert not end.finished
        assert at_rest(race).digests == tuple(digest(run.state) for run in runs)
