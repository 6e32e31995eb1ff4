"""What happened along a line is told with the very step at which it did."""

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.explain.happenings import MOST_BY_HAND, Happening, first_capture_in, happenings_of
from app.live.places import Mark, Place
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FreezeSelection,
    Introduce,
    Remove,
    SetParameter,
    StopExploring,
    Undo,
)
from learners.run import Run
from sim.world import CAPTURE, FLIGHT, TIMEOUT
from tests.support.schedules import commands, small_run, to


def step_of_trial(run: Run, trial: int) -> int:
    assert 0 <= trial <= run.trial
    return int(run.state.log_steps[:trial].sum(dtype=np.int64))


def happened(run: Run, **parts: Any) -> tuple[Happening, ...]:
    return happenings_of(run.control, run.trial, lambda trial: step_of_trial(run, trial), **parts)


def told(run: Run) -> list[tuple[int, str, str]]:
    """Trial, kind and text of all that happened in a run."""
    return [(one.trial, one.kind, one.text) for one in happened(run)]


def test_the_schedule_joins_explores_and_freezes() -> None:
    run = to(small_run(), 500)
    assert told(run) == [
        (10, "freeze", "the selection learns again"),
        (100, "join", "circle clockwise joins"),
        (120, "freeze", "the selection learns again"),
        (160, "exploration", "exploring circle clockwise is over"),
        (200, "join", "avoid joins"),
        (220, "freeze", "the selection learns again"),
        (250, "exploration", "exploring avoid is over"),
        (340, "exploration", "exploring approach is over"),
    ]
    assert [one.step for one in happened(run)] == [
        step_of_trial(run, one.trial) for one in happened(run)
    ]
    # Of what is still to come nothing is said.
    assert told(to(small_run(), 200)) == told(run)[:4]


def test_what_was_done_by_hand_is_at_its_step_even_within_a_trial() -> None:
    run = to(small_run(), 50)
    run.advance(max_steps=7)
    step, trial = run.step, run.trial
    run.apply(SetParameter("learner.epsilon", 0.2))
    run.apply(Introduce("avoid", 5))
    to(run, 60)
    run.apply(StopExploring("avoid"))
    run.apply(Undo(1))
    by_hand = [one for one in happened(run) if one.step in (step, run.step)]
    assert [(one.kind, one.text) for one in by_hand] == [
        ("command", "Exploration ε = 0.2"),
        ("join", "avoid added"),
        ("command", "exploring avoid stopped"),
        ("command", "undone: Exploration ε = 0.2"),
    ]
    assert (trial + 5, "freeze", "the selection learns again") in told(run)


def test_what_a_command_ends_does_not_end_once_more_by_itself() -> None:
    run = to(small_run(), 110)
    run.apply(StopExploring("circle_clockwise"))
    run.apply(FreezeSelection(True))
    to(run, 130)
    run.apply(Explore("circle_clockwise", 100, 0.5))
    run.apply(FreezeSelection(False))
    to(run, 150)
    run.apply(Remove("circle_clockwise"))
    kinds = {kind for trial, kind, _ in told(to(run, 190)) if trial > 110}
    assert kinds == {"command"}


def test_the_first_capture_and_marks_are_among_it() -> None:
    run = to(small_run(), 300)
    outcomes = np.array([TIMEOUT, FLIGHT, CAPTURE, FLIGHT, CAPTURE], np.int8)
    assert first_capture_in(outcomes) == 2
    assert first_capture_in(outcomes[:2]) is None
    assert first_capture_in(outcomes[:0]) is None
    mark = Mark(4, Place(0, step_of_trial(run, 7) + 3), 7, "Look at <this>!")
    found = happened(run, first_capture=2, marks=[mark])
    assert found[:2] == (
        Happening(step_of_trial(run, 3), 3, "capture", "the first capture"),
        Happening(step_of_trial(run, 7) + 3, 7, "mark", "Look at <this>!"),
    )
    # The running trial has not ended in anything yet.
    assert happened(run, first_capture=300) == happened(run)


def test_of_a_held_key_the_newest_is_told() -> None:
    run = small_run()
    for number in range(MOST_BY_HAND + 50):
        run.advance(max_steps=1)
        run.apply(FreezeSelection(number % 2 == 0))
    by_hand = [one for one in happened(run) if one.kind == "command"]
    assert len(by_hand) == MOST_BY_HAND
    assert by_hand[-1].step == run.step


@given(st.lists(st.tuples(st.integers(0, 3_000), commands), max_size=12))
def test_ends_are_those_that_a_run_meets_trial_by_trial(
    script: list[tuple[int, Command]],
) -> None:
    run = small_run()
    met: list[tuple[int, str, str]] = []
    for steps, command in [*script, (2_000, None)]:
        until = run.step + steps
        while run.step < until:
            trial = run.trial
            if run.advance(until - run.step, trial + 1) == 0:
                break
            if run.trial == trial:
                continue
            held = run.control
            if held.frozen_until == run.trial and not held.selection_frozen:
                met.append((run.step, "freeze", "the selection learns again"))
            for episode in held.episodes:
                if episode.until_trial == run.trial:
                    skill = episode.skill.replace("_", " ")
                    met.append((run.step, "exploration", f"exploring {skill} is over"))
        if command is not None:
            try:
                run.apply(command)
            except CommandError:
                continue
    found = happened(run)
    steps = [one.step for one in found]
    assert steps == sorted(steps)
    ends = [
        (one.step, one.kind, one.text) for one in found if one.kind in ("freeze", "exploration")
    ]
    assert sorted(ends) == sorted(met)
