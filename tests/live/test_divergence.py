"""Where two runs part is where stepping both, one step at a time, finds that they do."""

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.divergence import Divergence, first_divergence, is_same
from app.live.past import Budget, Past
from learners.commands import CommandError, Explore, FreezeSelection, Introduce, SetParameter
from learners.names import MAX_TRIALS
from learners.run import Run
from sim.world import board_xy
from tests.support.lines import SEED, SPEC, Script, Wish, play, scripts, stands, tell
from tests.support.races import small

short_scripts: st.SearchStrategy[Script] = scripts.map(
    lambda script: [(min(steps, 60), wish) for steps, wish in script[:6]]
)
"""Of runs that are stepped through, which takes long."""


def line(
    run: Run, script: Sequence[tuple[int, Wish]] = (), rest: int = 0, nearest_steps: int = 100
) -> Past:
    """The past of a run in which things are done."""
    past = Past(run, Budget(nearest_steps=nearest_steps), clock=lambda: float(run.step))
    play(run, past, script, rest)
    return past


def stepwise(one: Run, other: Run) -> int | None:
    """The steps after which two runs part, found by making them both again, step by step."""
    runs = [Run(run.preset, run.seed) for run in (one, other)]
    given = [[*run.journal] for run in (one, other)]
    for step in range(min(one.step, other.step) + 1):
        if not is_same(runs[0].state, runs[1].state):
            return max(step - 1, 0)
        for run, left in zip(runs, given, strict=True):
            while left and left[0][0] == step:
                run.apply(left.pop(0)[1])
        if not is_same(runs[0].state, runs[1].state):
            return step
        for run in runs:
            run.advance(1, MAX_TRIALS)
    return None


def found_step(found: Divergence | None) -> int | None:
    return None if found is None else found.step


@given(
    common=short_scripts,
    parts=st.tuples(short_scripts, short_scripts),
    rest=st.sampled_from([0, 1, 200]),
)
@settings(max_examples=40)
def test_it_is_where_stepping_finds_it(
    common: Script, parts: tuple[Script, Script], rest: int
) -> None:
    runs = [Run(SPEC, SEED), Run(SPEC, SEED)]
    pasts = [
        line(run, [*common, (40, 0), *part], rest) for run, part in zip(runs, parts, strict=True)
    ]
    before = [stands(run) for run in runs]
    found = first_divergence(*pasts)
    assert found_step(found) == stepwise(*runs)
    assert [stands(run) for run in runs] == before
    if found is not None:
        assert not found.from_start
        assert found.trial == pasts[0].trial_of_step(found.step)
        # The other way round it is the same, and nothing that is earlier.
        back = first_divergence(*reversed(pasts))
        assert back is not None
        assert (back.step, back.did) == (found.step, found.did[::-1])
        until = first_divergence(*pasts, until=found.step - 1)
        assert until is None or found.step == 0


@given(seed=st.integers(0, 5), rest=st.integers(0, 300))
@settings(max_examples=6)
def test_runs_of_other_presets_part_where_stepping_finds_it(seed: int, rest: int) -> None:
    """Of two schedules that differ in a time alone, at the first skill that joins earlier."""
    later = SPEC.schedule.skills | {
        "circle_clockwise": SPEC.schedule.skills["circle_clockwise"].model_copy(update={"at": 22})
    }
    other = SPEC.model_copy(update={"schedule": SPEC.schedule.model_copy(update={"skills": later})})
    runs = [Run(SPEC, seed), Run(other, seed)]
    pasts = [line(run, rest=2_000 + rest) for run in runs]
    found = first_divergence(*pasts)
    assert found_step(found) == stepwise(*runs)
    if found is not None:
        assert found.trial == 20
        assert found.did[0].given[0] == Introduce("circle_clockwise", 5)
        assert found.did[1].given == ()


def test_one_past_and_the_same_are_the_same() -> None:
    run = Run(SPEC, SEED)
    past = line(run, [(300, FreezeSelection(True))], 900)
    assert first_divergence(past, past) is None
    twin = line(Run(SPEC, SEED), [(300, FreezeSelection(True))], 500)
    assert first_divergence(past, twin) is None
    assert first_divergence(twin, past) is None


def test_other_seeds_and_other_learners_part_at_the_start() -> None:
    standard = line(Run(small("standard_q"), SEED), rest=300)
    for other in (
        line(Run(small("standard_q"), SEED + 1), rest=300),
        line(Run(small("timed"), SEED), rest=300),
        line(Run(small("standard_q", "world.size=40"), SEED), rest=300),
        line(Run(small("standard_q"), SEED + 1)),
    ):
        found = first_divergence(standard, other)
        assert found is not None
        assert (found.step, found.trial, found.from_start) == (0, 0, True)
        assert found.seeds == (SEED, other.seed)


def test_what_each_did_there_is_told() -> None:
    run, other = Run(SPEC, SEED), Run(SPEC, SEED)
    past = line(run, rest=1_500)
    explored = line(other, [(700, Explore("approach", 30, 1.0)), (0, FreezeSelection(True))], 800)
    found = first_divergence(past, explored)
    assert found is not None
    assert found.step == stepwise(run, other)
    for past_of, did in zip((past, explored), found.did, strict=True):
        before, after = past_of.run_at(found.step), past_of.run_at(found.step + 1)
        assert before is not None
        assert after is not None
        counted = after.state.visits.astype(int) - before.state.visits
        n_skills = len(SPEC.learner.skills)
        assert did.skill == SPEC.learner.skills[int(counted.argmax()) % n_skills]
        if after.trial == before.trial:
            ways = [board_xy(at.world, int(at.state.place[0])) for at in (before, after)]
            assert did.move == (ways[1][1] - ways[0][1] + 1) * 3 + ways[1][0] - ways[0][0] + 1
        assert did.control == after.control


def test_where_the_next_step_is_not_known_nothing_is_told_of_it() -> None:
    run = Run(SPEC, SEED)
    past = line(run, rest=500)
    other = line(Run(SPEC, SEED), [(500, Introduce("avoid", 3))])
    found = first_divergence(past, other)
    assert found is not None
    assert found.step == 500
    assert found.did[0].given == ()
    assert found.did[1].given[0] == Introduce("avoid", 3)
    assert {did.skill for did in found.did} == {did.move for did in found.did} == {None}


def test_far_apart_it_goes_by_checkpoints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looking at each of many steps takes a copy; making so many, over and over, takes long."""
    runs = [Run(small("timed", "trials=100000"), SEED) for _ in range(2)]
    pasts = [Past(run, Budget(), clock=lambda: float(runs[0].step)) for run in runs]
    for _ in range(40):
        for run, past in zip(runs, pasts, strict=True):
            run.advance(20_000, MAX_TRIALS)
            past.note(run)
        if runs[0].step == 500_000:
            tell(runs[1], SetParameter("learner.epsilon", 0.3))
            pasts[1].note(runs[1])
    made = [0]
    advance = Run.advance

    def counted(run: Run, max_steps: int = 2**62, until_trial: int | None = None) -> int:
        steps = advance(run, max_steps, until_trial)
        made[0] += steps
        return steps

    monkeypatch.setattr(Run, "advance", counted)
    found = first_divergence(*pasts)
    assert found is not None
    assert 500_000 <= found.step < 500_100
    assert made[0] < 800_000


def test_a_line_that_goes_another_way_meanwhile_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Run(SPEC, SEED)
    past = line(run, rest=2_000)
    other = line(Run(SPEC, SEED), [(500, FreezeSelection(True))], 1_500)
    run_at = Past.run_at

    def cut_first(of: Past, step: int, *rest: object, **more: object) -> Run | None:
        found = run_at(of, step, *rest, **more)  # pyright: ignore[reportArgumentType]
        if of is past and step > 100:
            back = run_at(past, 100)
            assert back is not None
            past.note(back)
        return found

    monkeypatch.setattr(Past, "run_at", cut_first)
    with pytest.raises(CommandError, match="went another way meanwhile"):
        first_divergence(past, other)
