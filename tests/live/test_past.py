"""Any moment of a line can be made again, exactly, in bounded memory; the line is not touched."""

import threading
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.documents import presets
from app.live.past import MOST_BYTES, Budget, Past
from learners.commands import Explore, FreezeSelection, FreezeSkills, SetParameter
from learners.run import Run, replay
from tests.support.lines import SEED, SPEC, Script, play, scripts, stands, tell

NEAREST = 25
"""Steps between checkpoints here, so that short runs have many."""


def line(run: Run, most_bytes: int = MOST_BYTES) -> Past:
    """The past of a run whose checkpoints are taken as often as may be."""
    return Past(run, Budget(most_bytes, NEAREST), lambda: 0.0)


def replayed(run: Run, step: int) -> Run:
    """The same line, from its beginning, stopped at a step."""
    return replay(SPEC, SEED, run.journal, step)


def made(past: Past, step: int) -> Run:
    found = past.run_at(step)
    assert found is not None
    return found


# Exact


@given(script=scripts, rest=st.integers(0, 2_000), shares=st.lists(st.floats(0, 1), max_size=6))
def test_a_moment_is_what_a_run_stopped_there_would_be(
    script: Script, rest: int, shares: list[float]
) -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, script, rest)
    before = stands(run)
    steps = [round(share * run.step) for share in shares]
    steps += [step for step, _ in run.journal]
    for step in [*steps, run.step]:
        found = made(past, step)
        assert stands(found) == stands(replayed(run, step))
        assert past.trial_of_step(step) == found.trial
        assert past.is_still(step, found.control)
    assert stands(run) == before == stands(made(past, run.step))


@settings(max_examples=25)
@given(parts=st.lists(scripts, min_size=1, max_size=4), shares=st.lists(st.floats(0, 1)))
def test_whatever_was_looked_at_while_it_goes_on(parts: list[Script], shares: list[float]) -> None:
    run = Run(SPEC, SEED)
    past = line(run, most_bytes=8 * run.checkpoint().nbytes)
    looked: list[tuple[int, dict[str, object]]] = []
    for part in parts:
        play(run, past, part, rest=400)
        for share in shares:
            step = round(share * (run.step - 1))
            looked.append((step, stands(made(past, step))))
    for step, found in looked:
        assert stands(made(past, step)) == found == stands(replayed(run, step))


@given(script=scripts, at=st.floats(0, 1), to=st.floats(0, 1))
def test_a_run_of_the_line_is_taken_on(script: Script, at: float, to: float) -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, script, rest=500)
    first, second = sorted([round(at * run.step), round(to * run.step)])
    found = made(past, first)
    past.take_on(found, second)
    assert stands(found) == stands(replayed(run, second))


def test_what_is_given_is_independent() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [(900, FreezeSelection(True))], rest=600)
    before = stands(made(past, 1_000))
    found = made(past, 1_000)
    found.apply(Explore("approach", 30, 1.0))
    found.advance(max_steps=3_000)
    assert stands(found) != before
    assert stands(made(past, 1_000)) == before


def test_a_line_may_begin_far_from_its_beginning() -> None:
    run = Run(SPEC, SEED)
    run.advance(max_steps=1_500)
    run.apply(FreezeSelection(True))
    past = line(run)
    play(run, past, [(500, FreezeSelection(False))], rest=600)
    assert past.kept[0] == 1_500
    for step in (0, 700, 1_499, 1_500, 1_501, 2_600):
        assert stands(made(past, step)) == stands(replayed(run, step))


def test_beyond_its_ends_is_its_end() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [], rest=800)
    assert made(past, -5).step == 0
    assert stands(made(past, 10**9)) == stands(run)
    assert past.step_of_trial(10**9) == past.end_step == 800
    assert past.trial_of_step(10**9) == past.end_trial == run.trial


# Commands that change what was


def test_a_command_that_takes_the_place_of_another_is_what_was() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [], rest=1_000)
    for value in (0.1, 0.2, 0.3):
        before = made(past, 1_000).control
        tell(run, SetParameter("learner.epsilon", value))
        past.note(run)
        assert not past.is_still(1_000, before)
        assert stands(made(past, 1_000)) == stands(run)
    assert len(run.journal) == 1
    play(run, past, [], rest=500)
    for step in (999, 1_000, 1_001, 1_500):
        assert stands(made(past, step)) == stands(replayed(run, step))


def test_a_line_that_is_cut_goes_another_way() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [(700, FreezeSelection(True))], rest=2_000)
    made(past, 2_000)
    other = made(past, 1_000)
    past.note(other)
    assert (past.end_step, past.end_trial) == (1_000, other.trial)
    assert max(past.kept) <= 1_000
    play(other, past, [(0, Explore("approach", 30, 1.0))], rest=1_200)
    for step in (600, 1_000, 1_001, 1_800, 2_200):
        assert stands(made(past, step)) == stands(replayed(other, step))
    assert past.step_of_trial(past.end_trial) == int(other.state.log_steps[: other.trial].sum())


def test_a_run_of_another_way_is_not_taken_on() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [(700, FreezeSelection(True))], rest=2_000)
    early, late = made(past, 700), made(past, 1_500)
    past.note(made(past, 1_000))
    assert not past.take_on(late, 1_600)
    assert late.step == 1_500
    assert past.take_on(early, 900)
    assert stands(early) == stands(replayed(run, 900))
    other = made(past, 600)
    play(other, past, [(0, FreezeSkills(True))], rest=900)
    assert not past.take_on(early, 1_200)
    assert early.step == 900


def test_a_run_is_not_taken_on_from_beyond_where_the_line_was_cut_and_a_command_given() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, [], rest=2_000)
    beyond = made(past, 1_500)
    other = made(past, 1_000)
    past.note(other)
    play(other, past, [(0, SetParameter("learner.alpha", 0.4))], rest=2_000)
    # Nothing had been done by hand in the run, so what was done on the line since could follow.
    assert not past.take_on(beyond, 1_800)
    assert (beyond.step, beyond.journal) == (1_500, [])


def test_whatever_the_line_does_a_moment_is_one_of_it() -> None:
    """It is cut and goes another way, again and again, while others look at it."""
    run = Run(SPEC, SEED)
    past = line(run, most_bytes=20 * run.checkpoint().nbytes)
    run.advance(max_steps=5_000, until_trial=10_000)
    past.note(run)
    found: list[Run] = []

    def look(seed: int) -> None:
        rng = np.random.default_rng(seed)
        for _ in range(100):
            at = made(past, int(rng.integers(6_000)))
            past.take_on(at, at.step + 300)
            found.append(at)

    looking = [threading.Thread(target=look, args=(seed,)) for seed in range(3)]
    for thread in looking:
        thread.start()
    rng = np.random.default_rng(9)
    while any(thread.is_alive() for thread in looking):
        run = made(past, int(rng.integers(1_000, past.end_step + 1)))
        past.note(run)
        tell(run, SetParameter("learner.alpha", float(rng.uniform(0.1, 0.5))))
        past.note(run)
        for _ in range(8):
            run.advance(max_steps=250, until_trial=10_000)
            past.note(run)
    # What fails in a thread fails the test as well.
    assert len(found) == 300
    for at in found[::10]:
        assert stands(at) == stands(replay(SPEC, SEED, at.journal, at.step))


@pytest.mark.parametrize("preset", presets.shipped())
def test_any_learner_has_a_past(preset: str) -> None:
    spec = presets.load(preset, ["world.size=40", "trials=2000"])
    run = Run(spec, SEED)
    past = Past(run, Budget(MOST_BYTES, 5_000), lambda: 0.0)
    while run.step < 60_000:
        run.advance(max_steps=3_001, until_trial=60_000)
        past.note(run)
    for step in (0, 1, 9_999, 33_333, 60_001):
        assert stands(made(past, step)) == stands(replay(spec, SEED, [], step))


# Trials


@given(script=scripts, rest=st.integers(0, 30_000))
def test_steps_and_trials_go_together(script: Script, rest: int) -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    play(run, past, script)
    made_so_far = past.trial_of_step(run.step)
    assert made_so_far == run.trial
    run.advance(max_steps=rest, until_trial=2_000)
    past.note(run)
    starts = np.concatenate([[0], np.cumsum(run.state.log_steps[: run.trial])])
    for trial in {0, 1, 255, 256, 257, 511, 512, run.trial - 1, run.trial}:
        if 0 <= trial <= run.trial:
            assert past.step_of_trial(trial) == starts[trial]
            assert past.trial_of_step(int(starts[trial])) == trial
            assert trial == 0 or past.trial_of_step(int(starts[trial]) - 1) == trial - 1


# What is kept


def gaps(past: Past) -> np.ndarray:
    """Steps from one checkpoint to the next, the beginning and the end included."""
    return np.diff([0, *past.kept, past.end_step])


@pytest.mark.parametrize("room", [0, 1, 2, 7, 40])
def test_memory_is_bounded(room: int) -> None:
    run = Run(SPEC, SEED)
    most = room * run.checkpoint().nbytes + 2_000
    budget = Budget(most, NEAREST)
    lines = [Past(run, budget, lambda: 0.0) for _ in range(3)]
    rng = np.random.default_rng(0)
    for _ in range(60):
        run.advance(max_steps=120)
        for past in lines:
            past.note(run)
            made(past, int(rng.integers(run.step + 1)))
            assert budget.nbytes <= most
    assert sum(len(past.kept) for past in lines) <= room
    assert budget.nbytes == sum(past.nbytes for past in lines)
    if room >= 7:
        assert min(len(past.kept) for past in lines) >= room // 3
    lines[0].drop()
    assert lines[0].nbytes == 0
    assert stands(made(lines[0], 3_000)) == stands(replayed(run, 3_000))


def test_what_nobody_holds_any_more_takes_nothing() -> None:
    budget = Budget(MOST_BYTES, NEAREST)
    run = Run(SPEC, SEED)
    run.advance(max_steps=500)
    past = Past(run, budget)
    assert budget.nbytes == past.nbytes > 0
    del past
    assert budget.nbytes == 0


FAR_NEAREST = 2_000


def far_line(looks: Callable[[Past], object]) -> Past:
    """A line of which there is more than memory for, with a look at it now and then."""
    run = Run(SPEC, SEED)
    past = Past(run, Budget(30 * run.checkpoint().nbytes, FAR_NEAREST), lambda: 0.0)
    while run.step < 1_000_000:
        run.advance(max_steps=FAR_NEAREST, until_trial=200_000)
        past.note(run)
        looks(past)
    return past


def test_checkpoints_are_close_near_now_and_no_part_of_the_past_is_a_desert() -> None:
    past = far_line(lambda past: None)
    widths = gaps(past)
    assert 1.5 * widths[-8:].mean() < widths[:8].mean()
    assert widths.max() <= 8 * past.end_step / len(past.kept)


def test_checkpoints_are_close_where_one_looks() -> None:
    def near(past: Past) -> list[int]:
        return [step for step in past.kept if abs(step - 300_000) < 10_000]

    looked = far_line(lambda past: made(past, min(300_000, past.end_step)))
    assert len(near(looked)) > 2 * len(near(far_line(lambda past: None)))


def test_on_the_way_to_a_moment_checkpoints_are_left() -> None:
    run = Run(SPEC, SEED)
    past = line(run)
    run.advance(max_steps=3_000)
    past.note(run)
    past.drop()
    made(past, 1_600)
    assert past.kept[:3] == (800, 1_200, 1_400)
    assert 1_600 - past.kept[-1] <= 2 * NEAREST


def test_a_moment_that_is_not_wanted_any_more_is_given_up_and_not_for_nothing() -> None:
    run = Run(SPEC, SEED)
    past = Past(run, Budget(MOST_BYTES, 1_000_000), lambda: 0.0)
    run.advance(max_steps=3_000_000, until_trial=200_000)
    past.note(run)
    past.drop()
    answers = iter([True] * 10 + [False])
    assert past.run_at(2_900_000, lambda: next(answers)) is None
    assert past.kept
    assert 0 < past.kept[-1] < 2_900_000


def test_taking_checkpoints_costs_a_small_share_of_the_time() -> None:
    run = Run(SPEC, SEED)
    now_s = 0.0

    def clock() -> float:
        # Each look at the clock is a millisecond later, so each checkpoint takes one.
        nonlocal now_s
        now_s += 0.001
        return now_s

    past = Past(run, Budget(MOST_BYTES, NEAREST), clock)
    for _ in range(1_000):
        now_s += 0.009
        run.advance(max_steps=NEAREST, until_trial=2_000)
        past.note(run)
    assert 0.007 < 0.001 * len(past.kept) / now_s < 0.014
