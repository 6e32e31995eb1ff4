"""What is asked again and again: the run is the same, and what is drawn of it stays small."""

import contextlib
import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.charts.bar.model import Moment, bar_of
from app.charts.bar.sent import Around, bar_sent
from app.documents import presets
from app.live import snapshot
from app.live.requests import Begin, Pause, Play, Request, SetSpeed, StartAgain, StepOnce, TrialOnce
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.worker import MOST_WAITING
from app.schedule.blocks import MAX_PAST, Past, blocks_of
from learners.commands import (
    Command,
    CommandError,
    Explore,
    FollowSchedule,
    FreezeSelection,
    FreezeSkills,
    SetParameter,
    StopExploring,
    Undo,
)
from learners.kernel.state import digest
from learners.repeats import without_repeats
from learners.run import Run, replay
from learners.spec import RunSpec

PATIENCE_S = 60.0
SEED = 7


def spec_of(*changes: str) -> RunSpec:
    return presets.load("timed", ["world.size=40", "trials=1000", *changes])


SPEC = spec_of()


def moment(run: Run) -> Snapshot:
    return snapshot.take(run, "timed", 0)


def set_all(run: Run, commands: Sequence[Command]) -> Run:
    for command in commands:
        run.apply(command, replacing=True)
    return run


# The history


def by_hand(run: Run) -> list[Command]:
    return [event.command for event in run.control.history if event.author == "hand"]


HELD: tuple[tuple[list[Command], list[Command]], ...] = (
    ([FreezeSelection(n % 2 == 0) for n in range(1_001)], [FreezeSelection(True)]),
    ([FreezeSelection(n % 2 == 0) for n in range(1_000)], []),
    ([FreezeSkills(n % 2 == 0) for n in range(1_000)], []),
    ([FollowSchedule(n % 2 == 1) for n in range(1_000)], []),
    (
        [SetParameter("learner.epsilon", n / 1_000) for n in range(1_000)],
        [SetParameter("learner.epsilon", 0.999)],
    ),
    ([SetParameter("learner.epsilon", value) for value in (0.3, 0.2, SPEC.learner.epsilon)], []),
    ([Explore("approach", 5, 0.5)] * 500, [Explore("approach", 5, 0.5)]),
    (
        [FreezeSelection(True), FreezeSkills(True), FreezeSelection(False)],
        [FreezeSkills(True)],
    ),
)


@pytest.mark.parametrize(("given_commands", "noted"), HELD, ids=range(len(HELD)))
def test_of_what_is_set_again_before_a_step_the_last_counts(
    given_commands: list[Command], noted: list[Command]
) -> None:
    run = Run(SPEC, SEED)
    run.advance(max_steps=5_000)
    assert by_hand(set_all(run, given_commands)) == noted
    assert [event.number for event in run.control.history] == list(range(len(run.control.history)))


def test_what_a_step_saw_is_kept() -> None:
    run = Run(SPEC, SEED)
    for n in range(10):
        run.advance(max_steps=1)
        run.apply(FreezeSelection(n % 2 == 0), replacing=True)
    assert len(by_hand(run)) == 10


COMMANDS = st.sampled_from(
    (
        FreezeSelection(True),
        FreezeSelection(False),
        FreezeSkills(True),
        FreezeSkills(False),
        FollowSchedule(False),
        FollowSchedule(True),
        SetParameter("learner.epsilon", 0.3),
        SetParameter("learner.epsilon", 0.1),
        SetParameter("learner.alpha", 0.2),
        Explore("approach", 3, 0.5),
        Explore("approach", 8, 0.9),
        StopExploring("approach"),
    )
)


@settings(max_examples=40, deadline=None)
@given(plan=st.lists(st.tuples(st.integers(0, 3), COMMANDS), max_size=25))
def test_replacing_changes_nothing_but_the_history(plan: list[tuple[int, Command]]) -> None:
    replaced, plain = Run(SPEC, SEED), Run(SPEC, SEED)
    for steps, command in plan:
        for run in (replaced, plain):
            run.advance(max_steps=400 * steps)
            try:
                run.apply(command, replacing=run is replaced)
            except CommandError:
                continue
    for run in (replaced, plain):
        run.advance(max_steps=1_000)
    again = replay(SPEC, SEED, replaced.journal, replaced.step)
    assert digest(replaced.state) == digest(plain.state) == digest(again.state)
    assert again.control == replaced.control
    assert replace(replaced.control, history=()) == replace(plain.control, history=())


@settings(max_examples=40, deadline=None)
@given(before=st.lists(COMMANDS, max_size=3), commands=st.lists(COMMANDS, max_size=12))
def test_those_that_count_do_what_all_of_them_do(
    before: list[Command], commands: list[Command]
) -> None:
    run = Run(SPEC, SEED)
    run.advance(max_steps=5_000)
    carried_out = list[Command]()
    for command in before:
        with contextlib.suppress(CommandError):
            run.apply(command, replacing=True)
    alone = run.copy()
    for command in commands:
        with contextlib.suppress(CommandError):
            run.apply(command, replacing=True)
            carried_out.append(command)
    set_all(alone, without_repeats(carried_out))
    assert replace(alone.control, history=()) == replace(run.control, history=())
    assert digest(alone.state) == digest(run.state)
    assert len(without_repeats([SetParameter("learner.epsilon", n / 99) for n in range(99)])) == 1


@settings(max_examples=40, deadline=None)
@given(commands=st.lists(COMMANDS, min_size=1, max_size=12))
def test_what_is_noted_can_be_taken_back(commands: list[Command]) -> None:
    run = Run(SPEC, SEED)
    run.advance(max_steps=5_000)
    before = run.control
    for command in commands:
        try:
            run.apply(command, replacing=True)
        except CommandError:
            continue
    noted = [event.number for event in run.control.history[len(before.history) :]]
    for number in reversed(noted):
        run.apply(Undo(number))
    assert settings_of(run.control) == settings_of(before)


def settings_of(control: Any) -> tuple[Any, ...]:
    return (
        control.spec,
        control.episodes,
        control.selection_frozen,
        control.skills_frozen,
        control.schedule_on,
    )


# The session


def test_a_held_key_leaves_one_mark_in_a_live_run() -> None:
    live = Session(SPEC, "timed", SEED, 1.0, playing=False)
    live.start()
    for n in range(900):
        ticket = live.submit(FreezeSelection(n % 2 == 0))
    ticket = live.submit(FreezeSelection(True))
    status = live.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    live.stop()
    assert [e.command for e in status.snapshot.control.history if e.author == "hand"] == [
        FreezeSelection(True)
    ]


def test_requests_that_wait_are_bounded() -> None:
    idle = Session(SPEC, "timed", SEED, 1.0, playing=False)
    refused: list[str] = []
    tickets = [idle.submit(SetSpeed(1.0), refused.append) for _ in range(MOST_WAITING + 5)]
    assert refused == ["1,000 requests wait for the learner; ask again once it is ready"] * 5
    # Whoever waits for an answer waits no longer than for those that came before.
    assert tickets[-1] == MOST_WAITING
    idle.start()
    idle.wait_for(lambda status: status.answered >= tickets[-1], PATIENCE_S)
    idle.stop()


@pytest.mark.parametrize(
    ("before", "plays"),
    [
        ([], True),
        ([SetSpeed(5.0)], True),
        ([FreezeSelection(True)], True),
        ([SetParameter("learner.epsilon", 0.3)], True),
        ([StartAgain(SPEC, "timed", 3)], True),
        ([Pause()], False),
        ([StepOnce()], False),
        ([TrialOnce()], False),
        ([Play()], True),
        ([Play(), Pause()], False),
    ],
    ids=str,
)
def test_the_learner_begins_unless_somebody_has_said_otherwise(
    before: list[Request], plays: bool
) -> None:
    live = Session(spec_of("trials=1000000"), "timed", SEED, 10.0, playing=False)
    live.start()
    for request in (*before, Begin()):
        ticket = live.submit(request)
    status = live.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)
    live.stop()
    assert status.playing is plays


# What is drawn


@pytest.fixture(scope="module")
def shaken() -> Run:
    """A run in which the selection was frozen and freed in each of many trials."""
    run = Run(SPEC, SEED)
    for n in range(800):
        run.advance(until_trial=n + 1)
        run.apply(FreezeSelection(n % 2 == 0), replacing=True)
    return run


def test_the_bar_draws_the_newest_and_says_how_many_more(shaken: Run) -> None:
    past = Past()
    blocks = past.blocks_of(moment(shaken))
    all_blocks = blocks_of(moment(shaken))
    assert past.left_out == 400 - MAX_PAST
    frozen = [block for block in all_blocks if block.kind == "selection_freeze"]
    assert [b for b in blocks if b.kind == "selection_freeze"] == frozen[-MAX_PAST:]
    others = [block for block in all_blocks if block.kind != "selection_freeze"]
    assert [b for b in blocks if b.kind != "selection_freeze"] == others
    bar = bar_of(Moment(moment(shaken), blocks, past.left_out), "trials", 2_000)
    sent = bar_sent(bar, Around(1))
    assert sent["legend"][-1]["text"] == "300 earlier changes not drawn"
    assert len(json.dumps(sent)) < 60_000


@settings(max_examples=30, deadline=None)
@given(plan=st.lists(st.tuples(st.integers(0, 2), st.none() | COMMANDS), max_size=30))
def test_kept_up_with_the_past_is_as_if_played_from_the_start(
    plan: list[tuple[int, Command | None]],
) -> None:
    past, run = Past(), Run(SPEC, SEED)
    for trials, command in plan:
        run.advance(until_trial=run.trial + trials)
        try:
            if command is not None:
                run.apply(command, replacing=True)
            elif run.journal:
                run.apply(Undo(run.control.history[-1].number))
        except CommandError:
            continue
        assert past.blocks_of(moment(run)) == blocks_of(moment(run))
    other = Run(SPEC, SEED + 1)
    assert past.blocks_of(moment(other)) == blocks_of(moment(other))
