"""The learner of one seat: what it is told, and that it comes back exactly as it was put away."""

import json
import random
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.audience import own as own_module
from app.audience.own import Beginning, Own
from app.audience.own_view import CONTROLS, MOST_CONTROLS, OwnView, controls_of, own_part
from app.audience.seats import Seat
from app.audience.taps import (
    SPEEDS,
    AddOwn,
    AgainOwn,
    ExploreOwn,
    FreezeOwn,
    PlayOwn,
    SpeedOwn,
    StepOwn,
    Tap,
    TrialOwn,
)
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.boards import board_sent
from learners.commands import CommandError, FollowSchedule, Introduce
from learners.kernel.state import digest
from learners.run import replay
from tests.support.live import preset_of

SPEC = preset_of("timed", "trials=400")
DECODER = msgspec.json.Decoder(Tap)
TAPS: tuple[Tap, ...] = (
    PlayOwn(True),
    PlayOwn(False),
    StepOwn(),
    TrialOwn(),
    SpeedOwn(4),
    AddOwn("circle_clockwise"),
    AddOwn("avoid"),
    ExploreOwn("approach", True),
    ExploreOwn("circle_clockwise", True),
    ExploreOwn("circle_clockwise", False),
    FreezeOwn(True),
    FreezeOwn(False),
    AgainOwn(),
)


def handed_over(beginning: Beginning, number: int = 7) -> Own:
    own = Own(beginning, beginning.seed_of(number))
    arrive(own)
    return own


def arrive(own: Own, slice_steps: int = 997) -> None:
    while own.is_on_its_way:
        own.advance(slice_steps)


def tapped(own: Own, tap: Tap) -> None:
    try:
        own.carry_out(tap)
    except CommandError:
        assert not own.is_on_its_way
    arrive(own)


def test_each_seat_has_a_seed_of_its_own() -> None:
    beginning = Beginning("timed", SPEC, 3)
    assert [beginning.seed_of(number) for number in (1, 2, 30)] == [4, 5, 33]
    digests = set[str]()
    for number in range(1, 6):
        own = handed_over(beginning, number)
        own.advance(3_000)
        digests.add(digest(own.run.state))
    assert len(digests) == 5


def test_it_is_handed_over_where_the_lesson_begins() -> None:
    beginning = Beginning("timed", SPEC, 3, start=60, schedule=False, speed=50_000)
    own = Own(beginning, 10)
    assert own.is_new
    assert not own.learns
    arrive(own)
    assert (own.run.trial, own.is_on_its_way, own.level) == (60, False, 4)
    # The schedule is let go of there, and not before.
    assert own.run.journal == [(own.run.step, FollowSchedule(False))]
    same = replay(SPEC, 10, own.run.journal, own.run.step)
    assert digest(own.run.state) == digest(same.state)


def test_what_is_done_is_done() -> None:
    own = handed_over(Beginning("timed", SPEC, 3, start=30, schedule=False))
    own.carry_out(PlayOwn(True))
    assert own.learns
    own.carry_out(AddOwn("circle_clockwise"))
    assert own.run.present == ("approach", "circle_clockwise")
    # As the schedule has it.
    assert own.run.journal[-1] == (own.run.step, Introduce("circle_clockwise", 300))
    with pytest.raises(CommandError, match="has joined already"):
        own.carry_out(AddOwn("circle_clockwise"))
    own.carry_out(ExploreOwn("circle_clockwise", True))
    (episode,) = own.run.control.running(own.run.trial)
    assert (episode.skill, episode.probability) == ("circle_clockwise", 0.95)
    own.carry_out(ExploreOwn("circle_clockwise", False))
    assert not own.run.control.running(own.run.trial)
    own.carry_out(TrialOwn())
    assert (own.run.trial, own.playing) == (31, False)
    step = own.run.step
    own.carry_out(StepOwn())
    assert own.run.step == step + 1
    own.carry_out(AgainOwn())
    arrive(own)
    assert (own.run.trial, own.run.present) == (30, ("approach",))


def test_it_ends_where_its_preset_does() -> None:
    own = handed_over(Beginning("timed", SPEC, 3))
    own.carry_out(PlayOwn(True))
    own.advance(10**9)
    assert (own.run.trial, own.is_over, own.learns) == (400, True, False)
    for tap in (StepOwn(), TrialOwn()):
        own.carry_out(tap)
    assert own.run.trial == 400
    with pytest.raises(CommandError, match="trials are over"):
        own.carry_out(FreezeOwn(True))


def test_what_is_kept_of_it_has_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own_module, "MOST_COMMANDS", 4)
    monkeypatch.setattr(own_module, "MOST_TRIALS", 50)
    own = handed_over(Beginning("timed", SPEC, 3))
    for n in range(4):
        own.carry_out(FreezeOwn(n % 2 == 0))
    with pytest.raises(CommandError, match="changed 4 times"):
        own.carry_out(FreezeOwn(True))
    own.advance(10**9)
    assert own.run.trial == 50
    assert len(own.put_away().journal) == 4


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(TAPS), st.integers(0, 4_000), st.booleans()),
        min_size=1,
        max_size=12,
    ),
    st.integers(0, 80),
    st.booleans(),
    st.integers(0, 2**32),
)
def test_one_that_was_put_away_comes_back_as_it_was(
    doings: list[tuple[Tap, int, bool]], start: int, schedule: bool, seed: int
) -> None:
    beginning = Beginning("timed", SPEC, 3, start=start, schedule=schedule)
    stays, leaves = Own(beginning, 11), Own(beginning, 11)
    chance = random.Random(seed)
    for tap, steps, put_away in doings:
        for own in (stays, leaves):
            arrive(own, chance.randrange(1, 5_000))
            tapped(own, tap)
            own.advance(steps)
        if put_away:
            again = Own.taken_up(leaves.put_away())
            if again.is_on_its_way:
                again.advance(chance.randrange(2_000))
            if again.is_on_its_way and chance.random() < 0.5:
                # On its way it may be put away again.
                again = Own.taken_up(again.put_away())
            leaves = again
            arrive(leaves, chance.randrange(1, 5_000))
        assert leaves.run.step == stays.run.step
        assert digest(leaves.run.state) == digest(stays.run.state)
        assert leaves.run.control.history == stays.run.control.history
        assert (leaves.playing, leaves.level) == (stays.playing, stays.level)


def test_one_that_is_put_away_on_its_way_begins_there_again() -> None:
    beginning = Beginning("timed", SPEC, 3, start=60)
    own = Own(beginning, 10)
    own.advance(500)
    assert own.is_new
    again = Own.taken_up(own.put_away())
    assert again.is_new
    arrive(again)
    assert again.run.trial == 60


# --- What is seen of it ---------------------------------------------------------------------------


def part_of(own: Own, controls: tuple[str, ...], notice: str = "") -> dict[str, Any]:
    return json.loads(own_part(own, Seat(7), controls, notice))


def said(control: dict[str, Any]) -> list[dict[str, Any]]:
    """All that a control can say."""
    if control["kind"] == "choice":
        return [says for _, says in control["options"]]
    if control["kind"] == "level":
        return [{"do": "own_speed", "level": level} for level in range(len(control["words"]))]
    return [control["says"]] if control["says"] else []


def test_whatever_its_controls_say_is_a_tap_that_can_be_done() -> None:
    everything = ("play", "step", "trial", "speed", "add_skill", "explore", "freeze", "start_again")
    own = handed_over(Beginning("timed", SPEC, 3, start=5, schedule=False))
    for tap in (AddOwn("circle_clockwise"), ExploreOwn("circle_clockwise", True), AddOwn("avoid")):
        for control in part_of(own, everything)["controls"]:
            assert control["label"]
            for says in said(control):
                twin = Own.taken_up(own.put_away())
                arrive(twin)
                twin.carry_out(DECODER.decode(msgspec.json.encode(says)))
        own.carry_out(tap)
    own.carry_out(PlayOwn(True))
    own.advance(10**9)
    (play,) = part_of(own, ("play",))["controls"]
    assert play["label"] == "Start again"


def test_there_are_few_controls() -> None:
    assert controls_of(frozenset({"all"})) == CONTROLS
    assert len(CONTROLS) <= MOST_CONTROLS
    lesson = frozenset({"play", "trial", "layer.value", "inspect", "add_skill"})
    assert controls_of(lesson) == ("play", "trial", "add_skill")
    assert controls_of(frozenset({"curve"})) == ()


def test_a_learner_of_moves_has_no_skills_to_add() -> None:
    own = handed_over(Beginning("standard_q", preset_of("standard_q"), 0))
    controls = part_of(own, CONTROLS)["controls"]
    assert [control["control"] for control in controls] == ["play", "speed"]


def test_its_seed_and_its_seat_are_said() -> None:
    told = part_of(handed_over(Beginning("timed", SPEC, 3)), CONTROLS, "Look & see.")
    assert told["whose"] == (
        "You have seat 7, circle. The seed of your learner is 10: 3 and the number of your seat."
    )
    assert told["notice"] == "Look & see."


def test_its_board_is_that_of_its_moment() -> None:
    own = handed_over(Beginning("timed", SPEC, 3, start=50))
    view = OwnView(dark=False)
    status = own.status()
    assert own.status().snapshot is status.snapshot
    view.paint(status, asked=True, now_s=0.0)
    assert "own_over" not in view.parts
    assert not view.is_of(status)
    view.paint(status, asked=False, now_s=0.1)
    assert view.is_of(status)
    board = board_sent(status.snapshot, Look(), Extras(), rests=True)
    sent = (
        json.loads(view.parts["own_ground"])["board"] | json.loads(view.parts["own_over"])["board"]
    )
    assert sent == json.loads(msgspec.json.encode(board))
    assert "Paused" in json.loads(view.parts["own_words"])["sentence"]


@pytest.mark.parametrize(
    "message",
    [
        '{"do": "own_play"}',
        '{"do": "own_play", "on": 1}',
        '{"do": "own_play", "on": true, "seat": 3}',
        '{"do": "own_speed", "level": 5}',
        '{"do": "own_speed", "level": -1}',
        '{"do": "own_speed", "steps_per_s": 1e9}',
        '{"do": "own_add", "skill": ""}',
        '{"do": "own_add", "skill": "' + "x" * 65 + '"}',
        '{"do": "own_explore", "skill": "avoid", "on": true, "trials": 1000000000}',
        '{"do": "own_remove", "skill": "avoid"}',
    ],
)
def test_nothing_else_is_a_tap(message: str) -> None:
    with pytest.raises(msgspec.MsgspecError):
        DECODER.decode(message)


def test_the_fastest_level_has_a_bound() -> None:
    assert max(SPEEDS) * 30 <= 5e6
